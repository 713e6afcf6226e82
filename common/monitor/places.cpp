#include "common/monitor/places.h"

#include <google/protobuf/io/coded_stream.h>

namespace padr::monitor {
namespace {

constexpr float kTurn = 6.2831853F;       // rad
constexpr std::int32_t kHalfTurn = 3142;  // mrad
constexpr std::uint8_t kPresent = 1;
constexpr std::uint8_t kAwake = 2;
constexpr std::uint8_t kHeld = 4;

std::uint32_t zigzag(std::int32_t v) {
  return (static_cast<std::uint32_t>(v) << 1U) ^ static_cast<std::uint32_t>(v >> 31);
}

}  // namespace

std::int32_t to_millimetres(float metres) {
  if (!(std::abs(metres) <= kMostMetres)) return 0;  // the own world is finite; should it not be, nothing must break
  return static_cast<std::int32_t>(std::lround(static_cast<double>(metres) * 1e3));
}

bool from_millimetres(std::int64_t in, float& metres) {
  constexpr auto kMost = static_cast<std::int64_t>(kMostMetres) * 1000;
  metres = static_cast<float>(static_cast<double>(in) * 1e-3);
  return in >= -kMost && in <= kMost;
}

Whole to_whole(const Place& p) {
  const float turned = std::isfinite(p.angle) ? std::remainder(p.angle, kTurn) : 0;
  return {to_millimetres(p.position.x), to_millimetres(p.position.y),
          std::clamp(static_cast<std::int32_t>(std::lround(turned * 1e3F)), -kHalfTurn, kHalfTurn)};
}

void put(const Whole& w, Column& out) {
  out.Add(w.x);
  out.Add(w.y);
  out.Add(w.angle);
}

std::size_t size_of(const Whole& w) {
  using google::protobuf::io::CodedOutputStream;
  return CodedOutputStream::VarintSize32(zigzag(w.x)) + CodedOutputStream::VarintSize32(zigzag(w.y)) +
         CodedOutputStream::VarintSize32(zigzag(w.angle));
}

bool take(const Column& in, std::size_t count, const Column& base, std::vector<Place>& out, Column& sums) {
  if (static_cast<std::size_t>(in.size()) != 3 * count || (!base.empty() && base.size() != in.size())) return false;
  const auto sum = [&](int i) { return std::int64_t{in[i]} + (base.empty() ? 0 : base[i]); };
  for (int i = 0; i < in.size(); i += 3) {
    Place p;
    const std::int64_t angle = sum(i + 2);
    if (!from_millimetres(sum(i), p.position.x) || !from_millimetres(sum(i + 1), p.position.y) || angle < -kHalfTurn ||
        angle > kHalfTurn)
      return false;
    p.angle = static_cast<float>(angle) * 1e-3F;
    out.push_back(p);
    for (int k = 0; k < 3; ++k) sums.Add(static_cast<std::int32_t>(sum(i + k)));
  }
  return true;
}

void put_flags(const EntityFlags& f, std::string& flags, std::string& owners) {
  flags += static_cast<char>((f.present ? kPresent : 0) | (f.awake ? kAwake : 0) | (f.held ? kHeld : 0));
  owners += static_cast<char>(put_slot(f.owner));
}

bool take_flags(const std::string& flags, const std::string& owners, std::uint32_t first, std::uint32_t total,
                std::vector<EntityFlags>& out) {
  if (flags.size() != owners.size() || total >= kNoEntity || first > total || flags.size() > total - first)
    return false;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    const auto bits = static_cast<std::uint8_t>(flags[i]);
    EntityFlags f;
    if (bits > (kPresent | kAwake | kHeld) || !take_slot(static_cast<std::uint8_t>(owners[i]), f.owner)) return false;
    f.present = (bits & kPresent) != 0;
    f.awake = (bits & kAwake) != 0;
    f.held = (bits & kHeld) != 0;
    out.push_back(f);
  }
  return true;
}

}  // namespace padr::monitor
