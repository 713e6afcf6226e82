// The classic format: a file header of 24 bytes, then records of 16 bytes and a packet.
// draft-ietf-opsawg-pcap describes it.
#include <algorithm>
#include <array>

#include "common/capture/formats.h"

namespace padr::capture {
namespace {

constexpr std::size_t kFileHeader = 24;
constexpr std::size_t kRecordHeader = 16;
/// What libpcap allows for any link type that can carry IP; more is damage.
constexpr std::uint32_t kMostCaptured = 262144;
constexpr std::int64_t kNanos = 1'000'000'000;

constexpr std::array<std::array<std::uint8_t, 4>, 5> kMagics{{{0xA1, 0xB2, 0xC3, 0xD4},
                                                              {0xA1, 0xB2, 0x3C, 0x4D},
                                                              {0xD4, 0xC3, 0xB2, 0xA1},
                                                              {0x4D, 0x3C, 0xB2, 0xA1},
                                                              {0x0A, 0x0D, 0x0D, 0x0A}}};

class PcapReader : public FrameFormat {
 public:
  PcapReader(ByteQueue& queue, PcapKind kind) : queue_(queue), kind_(kind) {}

  std::optional<Frame> next() override {
    if (stop() == Stop::kDamaged) return std::nullopt;
    if (!begun_ && !read_header()) return std::nullopt;
    queue_.take(held_);
    held_ = 0;
    const ByteView head = queue_.peek(kRecordHeader);
    if (head.size() < kRecordHeader) return halt(head.empty() ? Stop::kEnd : Stop::kCut);
    const std::uint32_t captured = kind_.order.u32(head, 8);
    if (captured > kMostCaptured)
      return halt(Stop::kDamaged, "captured length " + std::to_string(captured) + " is not allowed; at most " +
                                      std::to_string(kMostCaptured));
    Frame f;
    f.time_ns =
        kind_.order.u32(head, 0) * kNanos + std::int64_t{kind_.order.u32(head, 4)} * (kind_.nanoseconds ? 1 : 1000);
    f.original = std::max(kind_.order.u32(head, 12), captured);
    const ByteView all = queue_.peek(kRecordHeader + captured);
    if (all.size() < kRecordHeader + captured) return halt(Stop::kCut);
    f.number = ++packets_;
    f.offset = queue_.offset();
    f.link_type = link_type_;
    f.bytes = all.subspan(kRecordHeader);
    held_ = all.size();
    return f;
  }

 private:
  bool read_header() {
    const ByteView head = queue_.peek(kFileHeader);
    if (head.size() < kFileHeader) {
      halt(Stop::kCut);
      return false;
    }
    // The upper bits tell of a frame check sequence, which only follows the packet.
    link_type_ = kind_.order.u32(head, 20) & 0xFFFFU;
    queue_.take(kFileHeader);
    begun_ = true;
    return true;
  }

  ByteQueue& queue_;
  PcapKind kind_;
  bool begun_ = false;
  std::uint32_t link_type_ = 0;
  std::uint64_t packets_ = 0;
  std::size_t held_ = 0;  ///< bytes of the last frame, whose packet the caller may still look at
};

}  // namespace

std::optional<PcapKind> pcap_kind(ByteView head) {
  switch (be32(head, 0)) {
    case 0xA1B2C3D4:
      return PcapKind{{true}, false};
    case 0xA1B23C4D:
      return PcapKind{{true}, true};
    case 0xD4C3B2A1:
      return PcapKind{{false}, false};
    case 0x4D3CB2A1:
      return PcapKind{{false}, true};
    default:
      return std::nullopt;
  }
}

bool is_begin_of_magic(ByteView head) {
  return std::any_of(kMagics.begin(), kMagics.end(), [head](const auto& magic) {
    return std::equal(head.begin(), head.end(), magic.begin(),
                      [](std::byte a, std::uint8_t b) { return std::to_integer<std::uint8_t>(a) == b; });
  });
}

std::unique_ptr<FrameFormat> make_pcap_reader(ByteQueue& queue, PcapKind kind) {
  return std::make_unique<PcapReader>(queue, kind);
}

}  // namespace padr::capture
