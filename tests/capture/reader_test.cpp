#include <gtest/gtest.h>

#include "common/capture/ip_packet.h"
#include "common/capture/pcapng_writer.h"
#include "common/model/rng.h"
#include "common/model/user_error.h"
#include "tests/capture/made.h"
#include "tests/seed.h"

namespace padr {
namespace {

using namespace test;
using Lines = std::vector<std::string>;

constexpr const char* kV4 = "192.0.2.1:4001 192.0.2.2:4002 ";
constexpr const char* kV6 = "[2001:db8::1]:4001 [2001:db8::2]:4002 ";

struct LinkCase {
  const char* what;
  std::uint32_t link;
  Data frame;
  std::string content;  ///< without number and time
};

std::vector<LinkCase> link_cases() {
  const Data v4 = ipv4(udp("Pd4"));
  const Data v6 = ipv6(udp("Pd6"));
  const std::string is4 = std::string("udp ") + kV4 + "Pd4";
  const std::string is6 = std::string("udp ") + kV6 + "Pd6";
  const auto cooked = [](std::uint32_t type, const Data& ip) { return Maker().zeros(14).u16(type).add(ip).data; };
  const auto cooked2 = [](std::uint32_t type, const Data& ip) { return Maker().u16(type).zeros(18).add(ip).data; };
  // Hop-by-hop options, then an authentication header, then a fragment header of a packet in one piece.
  const Data extended = Maker().u8(51).u8(0).zeros(6).u8(44).u8(1).zeros(10).u8(17).zeros(7).add(udp("Pd6")).data;
  const Data piece = Maker().u8(17).u8(0).u16(0x0001).u32(9).add(udp("Pd6")).data;
  Data padded = ethernet(v4);
  padded.resize(60);
  return {
      {"ethernet", 1, ethernet(v4), is4},
      {"ethernet, IPv6", 1, ethernet(v6), is6},
      {"ethernet, padded to 60 bytes", 1, padded, is4},
      {"VLAN", 1, ethernet(v4, {0x8100}), is4},
      {"QinQ", 1, ethernet(v6, {0x88A8, 0x8100}), is6},
      {"ARP", 1, Maker().zeros(12).u16(0x0806).zeros(28).data, "other"},
      {"a frame that ends in a VLAN tag", 1, Maker().zeros(12).u16(0x8100).u8(0).data, "other"},
      {"cooked", 113, cooked(0x0800, v4), is4},
      {"cooked, VLAN", 113, cooked(0x8100, Maker().u16(3).u16(0x86DD).add(v6).data), is6},
      {"cooked 2", 276, cooked2(0x86DD, v6), is6},
      {"null, little endian", 0, Maker(false).u32(2).add(v4).data, is4},
      {"null, big endian, IPv6 of macOS", 0, Maker(true).u32(30).add(v6).data, is6},
      {"null, another family", 0, Maker(false).u32(7).add(v4).data, "other"},
      {"loop", 108, Maker(true).u32(24).add(v6).data, is6},
      {"raw", 101, v4, is4},
      {"raw, IPv6", 101, v6, is6},
      {"raw, by DLT_RAW's number", 12, v4, is4},
      {"ipv4", 228, v4, is4},
      {"ipv6", 229, v6, is6},
      {"a link type that is not known", 147, v4, "unknown link"},
      {"empty", 101, {}, "other"},
      {"TCP", 101, ipv4(udp("Pd4"), 6), "other"},
      {"IPv4, first fragment", 101, ipv4(udp("Pd4"), 17, 0x2000), "fragment"},
      {"IPv4, later fragment", 101, ipv4(udp("Pd4"), 17, 0x0010), "fragment"},
      {"IPv4, not to be fragmented", 101, ipv4(udp("Pd4"), 17, 0x4000), is4},
      {"IPv6 with extension headers", 101, ipv6(extended, 0), is6},
      {"IPv6 fragment", 101, ipv6(piece, 44), "fragment"},
      {"IPv6 without next header", 101, ipv6({}, 59), "other"},
      {"IPv4, header too short", 101, Maker().u16(0x4400).u16(28).zeros(24).data, "malformed"},
      {"UDP longer than its packet", 101, ipv4(Maker().u16(1).u16(2).u16(99).u16(0).data), "malformed"},
      {"UDP shorter than its header", 101, ipv4(Maker().u16(1).u16(2).u16(7).u16(0).data), "malformed"},
      {"an extension header that runs out", 101, ipv6(Maker().u8(17).u8(9).zeros(6).data, 0), "malformed"},
  };
}

TEST(Reader, LinkTypesInBothFormatsByteOrdersAndResolutions) {
  for (const LinkCase& c : link_cases()) {
    for (const bool big : {false, true}) {
      for (const bool nano : {false, true}) {
        const Lines wanted{"1 1000000005000 " + c.content, ""};
        EXPECT_EQ(reading(pcap({big, nano, c.link}, {c.frame})), wanted) << c.what << " big " << big;
        Data file = section(big);
        for (const Data& more :
             {interface(big, c.link, nano ? 9 : 6), packet(big, 0, nano ? 1000000005000 : 1000000005, c.frame)})
          file.insert(file.end(), more.begin(), more.end());
        EXPECT_EQ(reading(file), wanted) << c.what << " pcapng, big " << big;
        EXPECT_EQ(reading(file, 7), wanted) << c.what << " in small pieces";
      }
    }
  }
}

TEST(Reader, SnaplenMakesCutDatagrams) {
  const Data frame = ethernet(ipv4(udp("Pd0123456789")));
  EXPECT_EQ(reading(pcap({}, {frame}, 14 + 28 + 4))[0], std::string("1 1000000005000 cut ") + kV4 + "Pd01");
  EXPECT_EQ(reading(pcap({}, {frame}, 14 + 28))[0], std::string("1 1000000005000 cut ") + kV4);
  EXPECT_EQ(reading(pcap({}, {frame}, 14 + 25))[0].substr(0, 19), "1 1000000005000 cut");
  // Once, these were malformed.
  for (const std::size_t kept : {14U + 19, 14U + 1, 10U})
    EXPECT_EQ(reading(pcap({}, {frame}, kept))[0], "1 1000000005000 cut headers") << kept;
  EXPECT_EQ(reading(pcap({}, {ethernet(ipv6(udp("Pd0123456789")))}, 14 + 39))[0], "1 1000000005000 cut headers");
}

TEST(Reader, InterfacesAndSectionsOfTheirOwn) {
  Data file;
  const auto add = [&file](const Data& d) { file.insert(file.end(), d.begin(), d.end()); };
  add(section(false));
  add(interface(false, 1));
  add(interface(false, 101, 0x80 | 10));  // 1/1024 s
  add(packet(false, 1, 1024 * 3 + 512, ipv4(udp("a"))));
  add(packet(false, 0, 4000001, ethernet(ipv4(udp("b")))));
  add(block(false, 5, Maker(false).u32(0).zeros(8).data));  // statistics: nothing for us
  add(section(true));
  add(interface(true, 276, 3));
  add(packet(true, 0, 5001, Maker().u16(0x0800).zeros(18).add(ipv4(udp("c"))).data));
  const std::string v4 = kV4;
  EXPECT_EQ(reading(file), (Lines{"1 3500000000 udp " + v4 + "a", "2 4000001000 udp " + v4 + "b",
                                  "3 5001000000 udp " + v4 + "c", ""}));
}

TEST(Reader, SimpleAndObsoletePackets) {
  const Data ip = ipv4(udp("x"));
  const auto size = static_cast<std::uint32_t>(ip.size());
  Data file = section(false);
  for (const Data& more : {interface(false, 101), block(false, 3, Maker(false).u32(size).add(ip).data),
                           block(false, 2, Maker(false).u16(0).u16(0).u32(0).u32(9).u32(size).u32(size).add(ip).data)})
    file.insert(file.end(), more.begin(), more.end());
  EXPECT_EQ(reading(file), (Lines{std::string("1 0 udp ") + kV4 + "x", std::string("2 9000 udp ") + kV4 + "x", ""}));
}

TEST(Reader, DamageIsNamedWithPacketAndByte) {
  const Data frame = ethernet(ipv4(udp("Pd")));
  Data good = pcap({}, {frame, frame});
  const std::size_t second = 24 + 16 + frame.size();
  Data absurd = good;
  absurd[second + 8 + 3] = std::byte{0x7F};
  EXPECT_EQ(reading(absurd).back(), "made: packet 2 at byte " + std::to_string(second) + ": captured length " +
                                        std::to_string(0x7F000000U + frame.size()) + " is not allowed; at most 262144");
  EXPECT_EQ(reading(absurd).size(), 2U) << "the first packet is still there";
  const std::size_t begin = section(false).size();
  const auto ng = [](std::initializer_list<Data> parts) {
    Data file = section(false);
    for (const Data& p : parts) file.insert(file.end(), p.begin(), p.end());
    return file;
  };
  const std::string at = "made: packet 1 at byte " + std::to_string(begin) + ": ";
  EXPECT_EQ(reading(ng({Maker(false).u32(6).u32(10).u32(0).data})).back(),
            at + "block length 10 is not allowed; a multiple of 4 from 12 to 16777216");
  EXPECT_EQ(reading(ng({Maker(false).u32(6).u32(0xFFFFFFF0).u32(0).data})).back(),
            at + "block length 4294967280 is not allowed; a multiple of 4 from 12 to 16777216");
  EXPECT_EQ(reading(ng({Maker(false).u32(9).u32(12).u32(16).data})).back(),
            at + "the lengths at the begin and the end of a block differ");
  EXPECT_EQ(reading(ng({packet(false, 0, 1, frame)})).back(), at + "interface 0, and 0 are described");
  EXPECT_EQ(reading(ng({block(false, 1, Maker(false).u32(1).data)})).back(),
            at + "an interface description of 4 bytes; at least 8");
  EXPECT_EQ(reading(ng({interface(false, 1, 0xFF)})).back(),
            at + "an interface whose time resolution does not fit 64 bits");
}

TEST(Reader, WhatIsNoCaptureIsRefused) {
  EXPECT_THROW(reading(bytes_of("PADRTRC and so on")), UserError);
  EXPECT_THROW(reading(bytes_of("xy")), UserError);
  EXPECT_EQ(reading({}), Lines{"made: the file is empty or ends after a few bytes"});
}

/// Files of every kind with three packets each, and where each packet ends.
std::vector<std::pair<Data, std::vector<std::size_t>>> whole_files() {
  const Data frame = ethernet(ipv4(udp("Pd and more")));
  std::vector<std::pair<Data, std::vector<std::size_t>>> all;
  for (const bool big : {false, true}) {
    const std::size_t record = 16 + frame.size();
    all.push_back({pcap({big, true, 1}, {frame, frame, frame}), {24 + record, 24 + 2 * record, 24 + 3 * record}});
    Data ng = section(big);
    std::vector<std::size_t> ends;
    const Data i = interface(big, 1, 9);
    ng.insert(ng.end(), i.begin(), i.end());
    for (std::uint64_t t = 1; t <= 3; ++t) {
      const Data p = packet(big, 0, t, frame);
      ng.insert(ng.end(), p.begin(), p.end());
      ends.push_back(ng.size());
    }
    all.push_back({ng, ends});
  }
  return all;
}

TEST(Reader, CutAnywhereAndGrownAgain) {
  for (const auto& [file, ends] : whole_files()) {
    const Lines whole = reading(file);
    ASSERT_EQ(whole.size(), 4U);
    for (std::size_t n = 0; n <= file.size(); ++n) {
      const auto cut = file.begin() + static_cast<std::ptrdiff_t>(n);
      const auto there = static_cast<std::size_t>(
          std::count_if(ends.begin(), ends.end(), [n = n](std::size_t end) { return end <= n; }));
      Memory memory(Data(file.begin(), cut));
      capture::FrameReader reader(memory.source(), "made");
      std::size_t seen = 0;
      while (const auto f = reader.next()) EXPECT_EQ(f->number, ++seen);
      EXPECT_EQ(seen, there) << "cut at " << n;
      const bool at_packet = n == file.size() || std::find(ends.begin(), ends.end(), n) != ends.end();
      EXPECT_TRUE(!at_packet || reader.stop() == capture::Stop::kEnd) << n;
      EXPECT_TRUE(at_packet || there == 0 || reader.stop() == capture::Stop::kCut) << n;
      memory.add(Data(cut, file.end()));
      while (const auto f = reader.next()) EXPECT_EQ(f->number, ++seen);
      EXPECT_EQ(seen, 3U) << "grown from " << n;
      EXPECT_EQ(reader.trouble(), "");
    }
  }
}

TEST(Reader, TurnedBitsSpoilNothingBefore) {
  Rng rng(seed());
  for (const auto& [file, ends] : whole_files()) {
    const Lines whole = reading(file);
    for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
      Data bad = file;
      bad[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
      if (rng.chance(0.3))
        bad[rng.below(static_cast<std::uint32_t>(bad.size() - bit / 8)) + bit / 8] ^= std::byte{0x80};
      try {
        const Lines lines = reading(bad);
        for (std::size_t i = 0; i < ends.size() && ends[i] <= bit / 8; ++i) EXPECT_EQ(lines[i], whole[i]) << bit;
      } catch (const UserError&) {
        EXPECT_LT(bit, 32U) << "only the magic tells whether it is a capture";
      }
    }
  }
}

TEST(Writer, IsReadBackAndChecksumsAreRight) {
  Data file;
  capture::PcapngWriter w({"a comment", "a test", "lo", ""},
                          [&file](std::span<const std::byte> b) { file.insert(file.end(), b.begin(), b.end()); });
  const Data v4 = udp("");  // any bytes
  const Endpoint a = ipv4({127, 0, 0, 1}, 65535);
  const Endpoint b = ipv4({127, 0, 0, 2}, 1);
  Endpoint c;
  c.address[0] = 0x20;
  c.address[15] = 9;
  c.port = 77;
  std::vector<std::byte> ip;
  const std::int64_t time = 1795269582243440118;
  for (const std::size_t size : {0U, 1U, 2U, 1199U, 1200U, 65507U}) {
    const Data payload(size, std::byte{0xAB});
    capture::make_udp_packet(a, b, payload, 9, ip);
    w.packet(time, capture::Direction::kOutbound, ip);
    capture::make_udp_packet(c, c, std::span(payload).first(std::min<std::size_t>(size, 1200)), 9, ip);
    w.packet(time + 1, capture::Direction::kInbound, ip);
  }
  w.dropped(time, 3);

  Memory memory(file);
  capture::FrameReader reader(memory.source(), "made");
  std::uint64_t n = 0;
  while (const auto f = reader.next()) {
    ++n;
    capture::UdpDatagram d;
    ASSERT_EQ(capture::udp_of(*f, d), capture::Content::kUdp);
    EXPECT_EQ(d.from, n % 2 == 1 ? a : c);
    EXPECT_EQ(d.to, n % 2 == 1 ? b : c);
    EXPECT_EQ(f->time_ns, time + (n % 2 == 1 ? 0 : 1));
    EXPECT_EQ(f->direction, n % 2 == 1 ? capture::Direction::kOutbound : capture::Direction::kInbound);
    // Over everything that a UDP checksum covers, it included, the sum is all ones.
    const auto bytes = f->bytes;
    const std::size_t header = n % 2 == 1 ? 20 : 40;
    std::uint32_t sum = 17 + static_cast<std::uint32_t>(bytes.size() - header);
    for (std::size_t i = n % 2 == 1 ? 12 : 8; i < bytes.size(); ++i)
      sum += std::to_integer<std::uint32_t>(bytes[i]) << (i % 2 == 0 ? 8U : 0U);
    while (sum >> 16U != 0) sum = (sum & 0xFFFFU) + (sum >> 16U);
    EXPECT_EQ(sum, 0xFFFFU) << "packet " << n;
  }
  EXPECT_EQ(n, 12U);
  EXPECT_EQ(reader.trouble(), "");
  EXPECT_EQ(reader.comment(), "a comment");
}

}  // namespace
}  // namespace padr
