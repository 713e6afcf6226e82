#include "common/capture/pcapng_writer.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace padr::capture {
namespace {

constexpr std::uint32_t kOrderMagic = 0x1A2B3C4D;
constexpr std::size_t kMostOption = 65535;
constexpr std::size_t kMostPacket = 262144;
constexpr std::byte kNanoseconds{9};

}  // namespace

PcapngWriter::PcapngWriter(const About& about, ByteSink sink) : sink_(std::move(sink)) {
  begin(0x0A0D0D0A);
  put32(kOrderMagic);
  put16(1);  // version 1.0
  put16(0);
  put32(0xFFFFFFFF);  // how long the section is, is not known
  put32(0xFFFFFFFF);
  option(1, about.comment);
  option(4, about.application);
  option(0, std::span<const std::byte>{});
  end();

  begin(1);
  put16(kLinkRaw);
  put16(0);
  put32(kMostPacket);
  option(2, about.interface);
  option(3, about.filter);
  option(9, std::span(&kNanoseconds, 1));
  option(0, std::span<const std::byte>{});
  end();
}

void PcapngWriter::packet(std::int64_t time_ns, Direction direction, std::span<const std::byte> ip) {
  assert(ip.size() <= kMostPacket);
  begin(6);
  put32(0);
  put_time(time_ns);
  put32(static_cast<std::uint32_t>(ip.size()));
  put32(static_cast<std::uint32_t>(ip.size()));
  put_bytes(ip);
  const std::array<std::byte, 4> flags{static_cast<std::byte>(direction)};
  option(2, flags);
  option(0, std::span<const std::byte>{});
  end();
}

void PcapngWriter::dropped(std::int64_t time_ns, std::uint64_t packets) {
  begin(5);
  put32(0);
  put_time(time_ns);
  std::array<std::byte, 8> count{};
  for (std::size_t i = 0; i < count.size(); ++i) count[i] = static_cast<std::byte>(packets >> (8 * i) & 0xFFU);
  option(5, count);
  option(0, std::span<const std::byte>{});
  end();
}

void PcapngWriter::begin(std::uint32_t type) {
  block_.clear();
  put32(type);
  put32(0);  // the length, once it is known
}

void PcapngWriter::end() {
  put32(0);
  const std::size_t length = block_.size();
  for (std::size_t i = 0; i < 4; ++i)
    block_[4 + i] = block_[length - 4 + i] = static_cast<std::byte>(length >> (8 * i) & 0xFFU);
  sink_(block_);
}

void PcapngWriter::put16(std::uint32_t v) {
  block_.push_back(static_cast<std::byte>(v & 0xFFU));
  block_.push_back(static_cast<std::byte>(v >> 8U & 0xFFU));
}

void PcapngWriter::put32(std::uint32_t v) {
  put16(v & 0xFFFFU);
  put16(v >> 16U);
}

void PcapngWriter::put_time(std::int64_t ns) {
  const auto units = static_cast<std::uint64_t>(std::max<std::int64_t>(ns, 0));
  put32(static_cast<std::uint32_t>(units >> 32U));
  put32(static_cast<std::uint32_t>(units & 0xFFFFFFFFU));
}

void PcapngWriter::put_bytes(std::span<const std::byte> bytes) {
  block_.insert(block_.end(), bytes.begin(), bytes.end());
  while (block_.size() % 4 != 0) block_.push_back(std::byte{0});
}

void PcapngWriter::option(std::uint32_t code, std::span<const std::byte> value) {
  value = value.first(std::min(value.size(), kMostOption));
  put16(code);
  put16(static_cast<std::uint32_t>(value.size()));
  put_bytes(value);
}

void PcapngWriter::option(std::uint32_t code, const std::string& text) {
  if (!text.empty()) option(code, std::as_bytes(std::span(text)));
}

}  // namespace padr::capture
