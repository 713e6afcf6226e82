#include "tools/monitor/blocks.h"

#include <bit>
#include <cstdint>

namespace padr::monitor {
namespace {

/// Little endian, whatever this machine is.
class BlockWriter {
 public:
  explicit BlockWriter(std::string& out) : out_(out) {}
  void u8(unsigned v) { out_ += static_cast<char>(v & 0xFFU); }
  void u16(unsigned v) {
    u8(v);
    u8(v >> 8U);
  }
  void u32(std::uint32_t v) {
    u16(v);
    u16(v >> 16U);
  }
  void f32(float v) { u32(std::bit_cast<std::uint32_t>(v)); }

 private:
  std::string& out_;
};

}  // namespace

std::string encode_block(const Block& head, const std::vector<EntityFlags>& flags, const std::vector<Place>& at) {
  unsigned there = 0;
  for (const EntityFlags& f : flags) there += f.present ? 1 : 0;
  std::string out;
  out.reserve(24 + 16 * std::size_t{there});
  BlockWriter w(out);
  w.u8(1);
  w.u8(head.slot);
  w.u8(static_cast<unsigned>(head.which));
  w.u8((head.interaction ? 1U : 0U) | (head.paused ? 2U : 0U) | (head.driven ? 4U : 0U));
  w.u32(static_cast<std::uint32_t>(head.tick));
  w.f32(head.threshold);
  w.f32(head.target.x);
  w.f32(head.target.y);
  w.u16(there);
  w.u16(0);
  for (std::size_t e = 0; e < flags.size(); ++e) {
    const EntityFlags& f = flags[e];
    if (!f.present) continue;
    w.u16(static_cast<unsigned>(e));
    w.u8(f.owner);
    w.u8((f.awake ? 1U : 0U) | (f.held ? 2U : 0U));
    w.f32(at[e].position.x);
    w.f32(at[e].position.y);
    w.f32(at[e].angle);
  }
  return out;
}

}  // namespace padr::monitor
