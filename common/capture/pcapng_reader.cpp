// pcapng: blocks of a type, a length, a body and the length again; draft-ietf-opsawg-pcapng describes it. A section
// header begins a section, which has a byte order and interfaces of its own; packets refer to interfaces by number.
#include <algorithm>
#include <limits>
#include <vector>

#include "common/capture/formats.h"

namespace padr::capture {
namespace {

constexpr std::uint32_t kSectionHeader = 0x0A0D0D0A;
constexpr std::uint32_t kInterface = 1;
constexpr std::uint32_t kObsoletePacket = 2;
constexpr std::uint32_t kSimplePacket = 3;
constexpr std::uint32_t kEnhancedPacket = 6;
constexpr std::uint32_t kOrderMagic = 0x1A2B3C4D;
constexpr std::size_t kFrameOfBlock = 12;  ///< type and both lengths
/// Longer blocks are taken for damage: they would have to be held in memory.
constexpr std::uint32_t kMostBlock = 16U << 20U;
constexpr std::size_t kMostInterfaces = 65536;
constexpr std::uint64_t kNanos = 1'000'000'000;

/// Units of a second for an if_tsresol octet; 0 if there are too many for 64 bits.
std::uint64_t units_per_second(std::uint32_t resolution) {
  const bool binary = (resolution & 0x80U) != 0;
  const std::uint32_t exponent = resolution & 0x7FU;
  if (exponent > (binary ? 63U : 19U)) return 0;
  if (binary) return std::uint64_t{1} << exponent;
  std::uint64_t units = 1;
  for (std::uint32_t i = 0; i < exponent; ++i) units *= 10;
  return units;
}

struct Interface {
  std::uint32_t link_type = 0;
  std::uint32_t snaplen = 0;  ///< 0: no limit
  std::uint64_t per_second = 1'000'000;
  std::int64_t offset_s = 0;

  std::int64_t nanoseconds(std::uint64_t units) const {
    const std::uint64_t seconds = units / per_second;
    const std::uint64_t rest = units % per_second;
    const std::uint64_t ns = per_second <= kNanos ? rest * kNanos / per_second : rest / (per_second / kNanos);
    constexpr std::int64_t kMostSeconds = 9'000'000'000;  // what fits 64 bits of nanoseconds
    const auto whole = static_cast<std::int64_t>(std::min<std::uint64_t>(seconds, kMostSeconds));
    const std::int64_t shift = std::clamp(offset_s, -kMostSeconds, kMostSeconds);
    return std::clamp<std::int64_t>(whole + shift, 0, kMostSeconds) * static_cast<std::int64_t>(kNanos) +
           static_cast<std::int64_t>(std::min(ns, kNanos - 1));
  }
};

/// Calls `each(code, value)` for every option that is whole.
template <typename Each>
void options(ByteView b, ByteOrder order, const Each& each) {
  while (b.size() >= 4) {
    const std::uint32_t code = order.u16(b, 0);
    const std::size_t length = order.u16(b, 2);
    if (code == 0 || b.size() - 4 < length) return;
    each(code, b.subspan(4, length));
    b = b.subspan(std::min(b.size(), 4 + (length + 3) / 4 * 4));
  }
}

class PcapngReader : public FrameFormat {
 public:
  explicit PcapngReader(ByteQueue& queue) : queue_(queue) {}

  std::optional<Frame> next() override {
    if (stop() == Stop::kDamaged) return std::nullopt;
    while (true) {
      queue_.take(held_);
      held_ = 0;
      if (!next_block()) return std::nullopt;
      Frame f;
      std::string wrong;
      const bool is_packet = take_block(f, wrong);
      if (!wrong.empty()) {
        held_ = 0;
        return halt(Stop::kDamaged, wrong);
      }
      if (!is_packet) continue;
      f.number = ++packets_;
      f.offset = queue_.offset();
      return f;
    }
  }

 private:
  /// Holds the next block, or halts.
  bool next_block() {
    const ByteView head = queue_.peek(kFrameOfBlock);
    if (head.size() < kFrameOfBlock) {
      halt(head.empty() ? Stop::kEnd : Stop::kCut);
      return false;
    }
    type_ = order_.u32(head, 0);
    if (be32(head, 0) == kSectionHeader) {
      if (be32(head, 8) != kOrderMagic && le32(head, 8) != kOrderMagic) {
        halt(Stop::kDamaged, "a section header without its byte-order magic");
        return false;
      }
      type_ = kSectionHeader;
      order_.big = be32(head, 8) == kOrderMagic;
    }
    const std::uint32_t length = order_.u32(head, 4);
    if (length < kFrameOfBlock || length % 4 != 0 || length > kMostBlock) {
      halt(Stop::kDamaged, "block length " + std::to_string(length) + " is not allowed; a multiple of 4 from 12 to " +
                               std::to_string(kMostBlock));
      return false;
    }
    const ByteView all = queue_.peek(length);
    if (all.size() < length) {
      halt(Stop::kCut);
      return false;
    }
    if (order_.u32(all, length - 4) != length) {
      halt(Stop::kDamaged, "the lengths at the begin and the end of a block differ");
      return false;
    }
    held_ = length;
    body_ = all.subspan(8, length - kFrameOfBlock);
    return true;
  }

  /// Whether it is a packet, which then is in `f`. What is wrong with the block goes into `wrong`.
  bool take_block(Frame& f, std::string& wrong) {
    switch (type_) {
      case kSectionHeader:
        take_section();
        return false;
      case kInterface:
        wrong = take_interface();
        return false;
      case kEnhancedPacket:
      case kObsoletePacket:
        wrong = take_packet(f);
        return true;
      case kSimplePacket:
        wrong = take_simple(f);
        return true;
      default:
        return false;
    }
  }

  void take_section() {
    first_interface_ += static_cast<std::uint32_t>(interfaces_.size());
    interfaces_.clear();
    comment_.clear();
    if (body_.size() < 16) return;
    options(body_.subspan(16), order_, [this](std::uint32_t code, ByteView value) {
      if (code != 1) return;
      if (!comment_.empty()) comment_ += '\n';
      for (const std::byte b : value) comment_ += static_cast<char>(b);
    });
  }

  std::string take_interface() {
    if (body_.size() < 8) return "an interface description of " + std::to_string(body_.size()) + " bytes; at least 8";
    if (interfaces_.size() == kMostInterfaces) return "more than " + std::to_string(kMostInterfaces) + " interfaces";
    Interface i;
    i.link_type = order_.u16(body_, 0);
    i.snaplen = order_.u32(body_, 4);
    options(body_.subspan(8), order_, [&](std::uint32_t code, ByteView value) {
      if (code == 9 && !value.empty()) i.per_second = units_per_second(u8(value, 0));
      if (code == 14 && value.size() >= 8) {
        const std::uint64_t first = order_.u32(value, 0);
        const std::uint64_t second = order_.u32(value, 4);
        i.offset_s = static_cast<std::int64_t>(order_.big ? first << 32U | second : second << 32U | first);
      }
    });
    if (i.per_second == 0) return "an interface whose time resolution does not fit 64 bits";
    interfaces_.push_back(i);
    return "";
  }

  std::string take_packet(Frame& f) {
    if (body_.size() < 20) return "a packet block of " + std::to_string(body_.size()) + " bytes; at least 20";
    const std::uint32_t number = type_ == kEnhancedPacket ? order_.u32(body_, 0) : order_.u16(body_, 0);
    if (number >= interfaces_.size())
      return "interface " + std::to_string(number) + ", and " + std::to_string(interfaces_.size()) + " are described";
    const std::uint32_t captured = order_.u32(body_, 12);
    if (captured > body_.size() - 20)
      return "captured length " + std::to_string(captured) + " is more than its block has room for";
    const Interface& i = interfaces_[number];
    f.interface = first_interface_ + number;
    f.link_type = i.link_type;
    f.time_ns = i.nanoseconds(std::uint64_t{order_.u32(body_, 4)} << 32U | order_.u32(body_, 8));
    f.original = std::max(order_.u32(body_, 16), captured);
    f.bytes = body_.subspan(20, captured);
    const std::size_t padded = (std::size_t{captured} + 3) / 4 * 4;
    options(body_.subspan(std::min(body_.size(), 20 + padded)), order_, [&](std::uint32_t code, ByteView value) {
      if (code != 2 || value.size() < 4) return;
      const std::uint32_t way = order_.u32(value, 0) & 3U;
      f.direction = way == 1 ? Direction::kInbound : way == 2 ? Direction::kOutbound : Direction::kUnknown;
    });
    return "";
  }

  std::string take_simple(Frame& f) {
    if (interfaces_.empty()) return "a packet before any interface is described";
    if (body_.size() < 4) return "a simple packet block of " + std::to_string(body_.size()) + " bytes; at least 4";
    const std::uint32_t snaplen =
        interfaces_[0].snaplen == 0 ? std::numeric_limits<std::uint32_t>::max() : interfaces_[0].snaplen;
    f.original = order_.u32(body_, 0);
    f.interface = first_interface_;
    f.link_type = interfaces_[0].link_type;
    f.bytes = body_.subspan(4, std::min<std::size_t>({f.original, snaplen, body_.size() - 4}));
    return "";
  }

  ByteQueue& queue_;
  ByteOrder order_;
  std::uint32_t type_ = 0;
  ByteView body_;
  std::size_t held_ = 0;  ///< bytes of the present block
  std::vector<Interface> interfaces_;
  std::uint32_t first_interface_ = 0;
  std::uint64_t packets_ = 0;
};

}  // namespace

bool is_pcapng(ByteView head) {
  return be32(head, 0) == kSectionHeader;
}

std::unique_ptr<FrameFormat> make_pcapng_reader(ByteQueue& queue) {
  return std::make_unique<PcapngReader>(queue);
}

}  // namespace padr::capture
