#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include "common/capture/frame_reader.h"
#include "common/capture/udp_datagram.h"

// Captures made by hand, byte by byte, and not by the code under test.
namespace padr::test {

using Data = std::vector<std::byte>;

/// Numbers in one byte order or the other.
class Maker {
 public:
  explicit Maker(bool big = true) : big_(big) {}
  Maker& u8(std::uint32_t v) { return put(v, 1); }
  Maker& u16(std::uint32_t v) { return put(v, 2); }
  Maker& u32(std::uint32_t v) { return put(v, 4); }
  Maker& add(const Data& d) {
    data.insert(data.end(), d.begin(), d.end());
    return *this;
  }
  Maker& zeros(std::size_t n) {
    data.resize(data.size() + n);
    return *this;
  }
  Data data;

 private:
  Maker& put(std::uint32_t v, unsigned bytes) {
    for (unsigned i = 0; i < bytes; ++i)
      data.push_back(static_cast<std::byte>(v >> 8U * (big_ ? bytes - 1 - i : i) & 0xFFU));
    return *this;
  }
  bool big_;
};

inline Data bytes_of(const std::string& text) {
  Data d;
  for (const char c : text) d.push_back(static_cast<std::byte>(c));
  return d;
}
inline std::string text_of(std::span<const std::byte> bytes) {
  std::string s;
  for (const std::byte b : bytes) s += static_cast<char>(b);
  return s;
}

inline Data udp(const std::string& payload, std::uint32_t from = 4001, std::uint32_t to = 4002) {
  return Maker()
      .u16(from)
      .u16(to)
      .u16(static_cast<std::uint32_t>(8 + payload.size()))
      .u16(0)
      .add(bytes_of(payload))
      .data;
}
/// 192.0.2.1 to 192.0.2.2. `fragment`: flags and offset.
inline Data ipv4(const Data& rest, std::uint32_t protocol = 17, std::uint32_t fragment = 0) {
  return Maker()
      .u16(0x4500)
      .u16(static_cast<std::uint32_t>(20 + rest.size()))
      .u16(7)
      .u16(fragment)
      .u8(64)
      .u8(protocol)
      .u16(0)
      .u32(0xC0000201)
      .u32(0xC0000202)
      .add(rest)
      .data;
}
/// 2001:db8::1 to 2001:db8::2. `next`: of the first header.
inline Data ipv6(const Data& rest, std::uint32_t next = 17) {
  return Maker()
      .u32(0x60000000)
      .u16(static_cast<std::uint32_t>(rest.size()))
      .u8(next)
      .u8(64)
      .u32(0x20010DB8)
      .u32(0)
      .u32(0)
      .u32(1)
      .u32(0x20010DB8)
      .u32(0)
      .u32(0)
      .u32(2)
      .add(rest)
      .data;
}
inline Data ethernet(const Data& ip, std::initializer_list<std::uint32_t> tags = {}) {
  Maker m;
  m.zeros(12);
  for (const std::uint32_t tag : tags) m.u16(tag).u16(5);
  return m.u16(std::to_integer<unsigned>(ip[0]) >> 4U == 4 ? 0x0800 : 0x86DD).add(ip).data;
}

struct PcapFile {
  bool big = false;
  bool nanoseconds = false;
  std::uint32_t link = 1;
};
/// `times`: in ns; `snaplen` cuts what is kept.
inline Data pcap(const PcapFile& f, const std::vector<Data>& frames, std::size_t snaplen = 65535) {
  Maker m(f.big);
  m.u32(f.nanoseconds ? 0xA1B23C4D : 0xA1B2C3D4).u16(2).u16(4).u32(0).u32(0).u32(65535).u32(f.link);
  std::uint32_t n = 0;
  for (const Data& frame : frames) {
    const Data kept(frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(std::min(snaplen, frame.size())));
    m.u32(1000 + n).u32(f.nanoseconds ? 5000 : 5).u32(static_cast<std::uint32_t>(kept.size()));
    m.u32(static_cast<std::uint32_t>(frame.size())).add(kept);
    ++n;
  }
  return m.data;
}

/// One pcapng block of this type around a body.
inline Data block(bool big, std::uint32_t type, Data body) {
  while (body.size() % 4 != 0) body.push_back(std::byte{0});
  const auto size = static_cast<std::uint32_t>(body.size() + 12);
  return Maker(big).u32(type).u32(size).add(body).u32(size).data;
}
inline Data section(bool big) {
  return block(big, 0x0A0D0D0A, Maker(big).u32(0x1A2B3C4D).u16(1).u16(0).u32(~0U).u32(~0U).data);
}
/// `resolution`: the if_tsresol octet.
inline Data interface(bool big, std::uint32_t link, std::uint32_t resolution = 6) {
  return block(big, 1, Maker(big).u16(link).u16(0).u32(0).u16(9).u16(1).u8(resolution).zeros(3).u32(0).data);
}
inline Data packet(bool big, std::uint32_t interface, std::uint64_t time, const Data& frame) {
  const auto size = static_cast<std::uint32_t>(frame.size());
  return block(big, 6,
               Maker(big)
                   .u32(interface)
                   .u32(static_cast<std::uint32_t>(time >> 32U))
                   .u32(static_cast<std::uint32_t>(time & 0xFFFFFFFFU))
                   .u32(size)
                   .u32(size)
                   .add(frame)
                   .data);
}

/// Gives what is there, at most `step` bytes at a time; more can be added.
class Memory {
 public:
  explicit Memory(Data data = {}, std::size_t step = 1U << 20U) : data_(std::move(data)), step_(step) {}
  void add(const Data& more) { data_.insert(data_.end(), more.begin(), more.end()); }
  capture::ByteSource source() {
    return [this](std::span<std::byte> into) {
      const std::size_t n = std::min({into.size(), data_.size() - at_, step_});
      std::copy_n(data_.begin() + static_cast<std::ptrdiff_t>(at_), n, into.begin());
      at_ += n;
      return n;
    };
  }

 private:
  Data data_;
  std::size_t step_;
  std::size_t at_ = 0;
};

/// What is in a file, in short: "N time contents [payload]" a line, at the end how it stopped.
inline std::vector<std::string> reading(const Data& file, std::size_t step = 1U << 20U) {
  constexpr const char* kNames[] = {"udp", "cut", "fragment", "other", "unknown link", "malformed", "cut headers"};
  Memory memory(file, step);
  capture::FrameReader reader(memory.source(), "made");
  std::vector<std::string> lines;
  while (const auto f = reader.next()) {
    capture::UdpDatagram d;
    const auto content = capture::udp_of(*f, d);
    std::string line =
        std::to_string(f->number) + " " + std::to_string(f->time_ns) + " " + kNames[static_cast<std::size_t>(content)];
    if (content == capture::Content::kUdp || content == capture::Content::kCutUdp)
      line += " " + to_string(d.from) + " " + to_string(d.to) + " " + text_of(d.payload);
    lines.push_back(line);
  }
  lines.push_back(reader.trouble());
  return lines;
}

}  // namespace padr::test
