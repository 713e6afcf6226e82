#include <nlohmann/json.hpp>

#include "common/model/ids.h"
#include "common/wire/codec.h"
#include "common/wire/seal.h"
#include "common/wire/sealed.h"
#include "tests/capture/made.h"
#include "tests/shell.h"

// What a user of padr-capture sees.
namespace padr {
namespace {

using namespace test;

class Program : public Shell {
 protected:
  Outcome capture(const std::string& arguments) const { return shell(std::string(PADR_CAPTURE) + " " + arguments); }
  void write(const std::string& name, const Data& data) const { Shell::write(name, text_of(data)); }
  /// A state datagram in a frame. `count`: of the updates that its sender says it has made.
  static Data state(std::uint32_t seq, std::uint16_t session = 5, std::uint32_t count = 0) {
    sync::StatePacket p;
    p.seq = seq;
    p.mark_tick = static_cast<Tick>(seq);
    p.mark_count = count;
    return ethernet(ipv4(udp(text_of(wire::seal({wire::Kind::kState, 1, session}, wire::encode(p))))));
  }
};

TEST_F(Program, SaysWhatIsWrongWithTheCommandLine) {
  for (const auto& [arguments, line] : std::vector<std::pair<std::string, std::string>>{
           {"", "give a command: summary, timeline, rebuild, compare, export, follow"},
           {"sumary x", "'sumary' is no command; allowed: summary, timeline, rebuild, compare, export, follow"},
           {"summary peer.trace", "peer.trace: not a capture but a trace; padr-report reads it"},
           {"summary", "CAPTURE is required"},
           {"summary nothing.pcap", "cannot read 'nothing.pcap': No such file or directory"},
           {"summary .", "it is a directory"},
           {"export x", "give one of --json and --csv"},
           {"export x --json --csv", "give one of --json and --csv"},
           {"rebuild x --wait-peers " + std::to_string(kMaxPeers + 1), "--wait-peers"},
           {"rebuild x --csv x", "CAPTURE and --csv: both name the file 'x'"},
           {"rebuild x --csv - --svg -", "--csv and --svg: only one of them can be printed"},
           {"compare x", "none of these is one: 'x'"},
           {"compare x nothing.trace", "cannot read 'nothing.trace': No such file or directory"},
           {"summary x.gz", "x.gz: not a capture but gzip: zcat x.gz | padr-capture ... -"},
           {"summary x --keylog 0.keys 1.keys", "1.keys: not a capture; it looks like a key log: --keylog 1.keys"}}) {
    Shell::write("x", "");
    Shell::write("peer.trace", "PADRTRC and more");
    Shell::write("x.gz", "\x1F\x8B\x08 and more");
    Shell::write("0.keys", "");
    Shell::write("1.keys", "padr-key 12");
    const Outcome o = capture(arguments);
    EXPECT_EQ(o.status, 2) << arguments;
    EXPECT_NE(o.err.find(line), std::string::npos) << arguments << ": " << o.err;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  }
  Shell::write("text", "no capture at all");
  EXPECT_EQ(capture("summary text").status, 2);
  EXPECT_NE(capture("summary text").err.find("text: not a capture"), std::string::npos);
  for (const std::string command : {"", "summary", "timeline", "rebuild", "compare", "export", "follow"})
    EXPECT_EQ(capture(command + " --help").status, 0);
}

TEST_F(Program, NothingOfOursIsNoError) {
  write("other.pcap", pcap({}, {ethernet(ipv4(udp("a DNS query"))), ethernet(ipv4(udp("x"), 6))}));
  const Outcome o = capture("summary other.pcap");
  EXPECT_EQ(o.status, 0);
  EXPECT_EQ(o.out, "other.pcap: 2 packets, 0 datagrams of PADR in 0.0 s, 1 of other UDP, 1 without UDP\n");
  EXPECT_EQ(capture("rebuild other.pcap").status, 2);
  EXPECT_EQ(capture("timeline other.pcap").status, 2);
  EXPECT_EQ(capture("export other.pcap --json").out, "");
}

TEST_F(Program, WhatIsCutIsMarkedAsSuch) {
  Data file = pcap({}, {state(1), state(2)});
  file.erase(file.end() - 3, file.end());
  write("cut.pcap", file);
  const Outcome o = capture("summary cut.pcap");
  EXPECT_EQ(o.status, 1);
  EXPECT_NE(o.out.find("1 datagram of PADR"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("Incomplete: cut.pcap: packet 2 at byte"), std::string::npos) << o.out;
  EXPECT_NE(o.err.find("padr-capture: incomplete: cut.pcap: packet 2"), std::string::npos) << o.err;
  EXPECT_NE(capture("summary cut.pcap --json -").out.find("\"complete\": false"), std::string::npos);
}

// Once, there was no word of it but in the first line of summary.
TEST_F(Program, SaysWhyNothingCanBeRead) {
  write("snap.pcap", pcap({}, {state(1), state(2)}, 54));
  const std::string cut =
      "padr-capture: snap.pcap: 2 of 2 packets are cut off by the capture (snaplen); capture with -s 0\n";
  write("wifi.pcap", pcap({.link = 105}, {state(1)}));
  const std::string link = "padr-capture: wifi.pcap: 1 of 1 packets are of a link type that is not understood\n";
  for (const std::string command : {"summary", "timeline", "rebuild", "export --json"}) {
    const int status = command == "timeline" || command == "rebuild" ? 2 : 0;
    for (const auto& [file, line] : {std::pair{"snap.pcap", cut}, std::pair{"wifi.pcap", link}}) {
      const Outcome o = capture(command + " " + file);
      EXPECT_TRUE(o.err.starts_with(line)) << command << ": " << o.err;
      EXPECT_EQ(o.status, status) << command;
    }
  }
  Shell::write("ten.pcap", text_of(pcap({}, {})).substr(0, 10));
  EXPECT_EQ(capture("export ten.pcap --json").err,
            "padr-capture: incomplete: ten.pcap: the file ends in its own header\n");
}

// Once, what was cut off counted as headers, and as lost.
TEST_F(Program, WhatIsCutOffIsNeitherHeadersNorLost) {
  constexpr std::uint32_t kHeaders = 14 + 20 + 8;
  Data file = pcap({}, {state(1)});
  const Data short_one = pcap({}, {state(2)}, kHeaders + 11);
  const Data next = pcap({}, {state(3)});
  const Data too_short = pcap({}, {state(4)}, kHeaders + 4);
  for (const Data* part : {&short_one, &next, &too_short}) file.insert(file.end(), part->begin() + 24, part->end());
  write("some.pcap", file);
  const Outcome o = capture("summary some.pcap");
  EXPECT_EQ(o.status, 0);
  EXPECT_NE(o.out.find("4 packets, 3 datagrams of PADR"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("1 cut off in their headers"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("The capture has cut off 1 datagram (snaplen"), std::string::npos) << o.out;
  const auto json = nlohmann::json::parse(capture("summary some.pcap --json -").out);
  const auto& parts = json["all"]["wire_bytes_by_part"];
  EXPECT_EQ(parts["headers"], 3 * 28);
  EXPECT_GT(parts["cut_off"], 0);
  std::uint64_t sum = 0;
  for (const auto& part : parts) sum += part.get<std::uint64_t>();
  EXPECT_EQ(sum, json["all"]["wire_bytes"].get<std::uint64_t>());
  EXPECT_TRUE(json["sessions"][0]["links"][0]["missing"].is_null());
  EXPECT_EQ(json["cut_headers"], 1);
}

// Once, the time from the first packet to the last was -1 s, and every rate 0.
TEST_F(Program, ACaptureNeedNotBeInTheOrderOfTime) {
  Data file = section(false);
  for (const Data& part : {interface(false, 1), packet(false, 0, 3'000'000, state(2)),
                           packet(false, 0, 1'000'000, state(1)), packet(false, 0, 2'000'000, state(3))})
    file.insert(file.end(), part.begin(), part.end());
  write("mixed.pcapng", file);
  const Outcome o = capture("summary mixed.pcapng");
  EXPECT_EQ(o.status, 0);
  EXPECT_NE(o.out.find("3 datagrams of PADR in 2.0 s, 1 earlier than the one before"), std::string::npos) << o.out;
  const std::string json = capture("summary mixed.pcapng --json -").out;
  EXPECT_NE(json.find("\"out_of_order\": 1"), std::string::npos) << json;
  EXPECT_TRUE(o.err.starts_with("padr-capture: warning: not in order of time: 1 datagrams are earlier")) << o.err;
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
}

TEST_F(Program, SeveralCapturesCountADatagramOnce) {
  // Peer 1 sent 1, 2, 2 (a duplicate) and 3; a has seen the first three, b all but the first.
  write("a.pcap", pcap({}, {state(1), state(2), state(2)}));
  write("b.pcap", pcap({}, {state(2), state(2), state(3)}));
  const Outcome o = capture("export --json a.pcap b.pcap");
  EXPECT_EQ(o.status, 0) << o.err;
  std::vector<std::string> seqs;
  for (std::size_t at = 0; (at = o.out.find("\"padr.seq\":", at)) != std::string::npos; at += 11)
    seqs.push_back(o.out.substr(at + 11, 1));
  std::sort(seqs.begin(), seqs.end());
  EXPECT_EQ(seqs, (std::vector<std::string>{"1", "2", "2", "3"}));
  EXPECT_NE(capture("summary a.pcap b.pcap").out.find("4 datagrams of PADR"), std::string::npos);
  EXPECT_NE(capture("summary a.pcap b.pcap").out.find("2 seen in another file, too"), std::string::npos);
}

/// In JSON, so often.
std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) ++n;
  return n;
}

// Peer 1 has 4001, peer 2 has 4002, and each sees the other one behind a NAT. Once, everything counted twice.
TEST_F(Program, ADatagramThatANatGivesAnotherAddressCountsOnce) {
  const auto from = [](PeerId sender, std::uint32_t seq, std::uint32_t source, std::uint32_t target) {
    sync::StatePacket p;
    p.seq = seq;
    p.mark_tick = 60;
    const wire::Bytes sealed = wire::seal({wire::Kind::kState, sender, 5}, wire::encode(p));
    Data frame = ethernet(ipv4(udp(text_of(sealed), source, target)));
    frame[14 + 19] = std::byte{1};  // all on one machine
    return frame;
  };
  write("1.pcap", pcap({}, {from(1, 1, 4001, 6001), from(2, 1, 6001, 4001), from(1, 2, 4001, 6001)}));
  write("2.pcap", pcap({}, {from(1, 1, 6002, 4002), from(2, 1, 4002, 6002), from(1, 2, 6002, 4002)}));
  const Outcome o = capture("summary 1.pcap 2.pcap");
  EXPECT_NE(o.out.find("6 packets, 3 datagrams of PADR in 2.0 s, 3 seen in another file"), std::string::npos) << o.out;
  EXPECT_EQ(count_of(o.out, "\n  1 -> 2 "), 1U) << o.out;
  EXPECT_EQ(count_of(o.out, "\n  2 -> 1 "), 1U) << o.out;
  // One capture of both sides; one of the datagrams was lost between them, and another came doubled.
  write("both.pcap", pcap({}, {from(1, 1, 4001, 6001), from(1, 1, 6002, 4002), from(2, 1, 4002, 6002),
                               from(2, 1, 6001, 4001), from(2, 1, 6001, 4001), from(1, 2, 4001, 6001)}));
  const Outcome both = capture("summary both.pcap");
  EXPECT_NE(both.out.find("6 packets, 4 datagrams of PADR in 5.0 s, 2 seen from another address, too"),
            std::string::npos)
      << both.out;
  EXPECT_EQ(count_of(both.out, "\n  1 -> 2 "), 1U) << both.out;
  EXPECT_EQ(count_of(both.out, "\n  2 -> 1 "), 1U) << both.out;
}

/// Peer 1, id 0x11, on 4001, speaks to peer 2, id 0x22, on 4002 through one on 4009. A carrier has an id of its own.
Data hop(std::uint32_t seq, bool second, std::uint32_t number) {
  const wire::Key key{};
  sync::StatePacket p;
  p.seq = seq;
  p.mark_tick = 60;
  p.to_incarnation = 9;
  const wire::Bytes inner =
      wire::seal_with(key, wire::SealMode::kAuth, 0x11, seq, wire::seal({wire::Kind::kState, 1, 5}, wire::encode(p)));
  wire::Bytes whole;
  wire::encode_carried({0x22, inner}, whole);
  whole = wire::seal_with(key, wire::SealMode::kAuth, second ? 0x33 : 0x11, number, whole);
  return ethernet(ipv4(udp(text_of(whole), second ? 4009 : 4001, second ? 4002 : 4009)));
}

// Once, each hop counted as a datagram, the second as a duplicate, and addresses were not those of the frame.
TEST_F(Program, WhatIsCarriedCountsOnceAndHasTheAddressesOfItsHops) {
  write("lo.pcap",
        pcap({}, {hop(1, false, 101), hop(1, true, 501), hop(2, false, 102), hop(2, true, 502), hop(2, true, 502)}));
  const std::string out = capture("summary lo.pcap --json -").out;
  const std::size_t links = out.find("\"links\"");
  ASSERT_NE(links, std::string::npos) << out;
  EXPECT_NE(out.find("\"datagrams\": 3,", links), std::string::npos) << "one was doubled on the second hop\n" << out;
  EXPECT_NE(out.find("\"duplicates\": 1,", links), std::string::npos) << out;
  EXPECT_NE(out.find("\"carried\": 5,"), std::string::npos) << out;

  EXPECT_NE(capture("follow - <lo.pcap").out.find("carried, peer 1 -> 192.0.2.2:4009"), std::string::npos);
  const std::string lines = capture("export lo.pcap --json").out;
  EXPECT_EQ(count_of(lines, "\"udp.srcport\":4001,\"udp.dstport\":4009,"), 2U) << lines;
  EXPECT_EQ(count_of(lines, "\"udp.srcport\":4009,\"udp.dstport\":4002,"), 3U) << lines;
  EXPECT_EQ(count_of(lines, "\"padr.carried.to\":\"00000022\""), 5U) << lines;
}

// A demo beside a crowd, on the loopback device.
TEST_F(Program, OfSeveralSessionsRebuildAsksWhichOne) {
  write("two.pcap", pcap({}, {state(1, 9), state(1, 513), state(2, 513)}));
  const Outcome which = capture("rebuild two.pcap --scenario arena --wait-peers 2");
  EXPECT_EQ(which.status, 2);
  EXPECT_EQ(which.err,
            "padr-capture: --session: the capture has 2 sessions, say which one: 513 (ticks 1 to 2, 1 peer, 2 state "
            "datagrams); 9 (ticks 1 to 1, 1 peer, 1 state datagrams)\n");
  for (const std::string number : {"513", "0x201"}) {
    const Outcome one = capture("rebuild two.pcap --scenario arena --wait-peers 2 --session " + number);
    EXPECT_EQ(one.err, "");
    EXPECT_TRUE(one.out.starts_with("session 513: arena")) << one.out;
  }
  const Outcome other = capture("rebuild two.pcap --session 7");
  EXPECT_EQ(other.status, 2);
  EXPECT_NE(other.err.find("--session: 7 is not in the capture; it has 513 ("), std::string::npos) << other.err;
  for (const std::string number : {"0", "65536", "0x10000", "5a", "0x", "-1", "5 "}) {
    const Outcome wrong = capture("rebuild two.pcap --session '" + number + "'");
    EXPECT_EQ(wrong.status, 2) << number;
    EXPECT_NE(wrong.err.find("allowed: 1 .. 65535 or 0x1 .. 0xffff"), std::string::npos) << wrong.err;
  }
}

TEST_F(Program, WhatBeginsInTheMiddleIsNotRebuiltAndItSaysWhyAtOnce) {
  write("middle.pcap", pcap({}, {state(300, 5, 7), state(301, 5, 7)}));
  const Outcome o = capture("rebuild middle.pcap");
  EXPECT_EQ(o.status, 1);
  EXPECT_EQ(o.out, "");
  EXPECT_TRUE(
      o.err.starts_with("padr-capture: rebuild: session 5 had begun when the capture did, at tick 300: update 0 "
                        "of peer 1 is not in it, and no whole transfer to a newcomer is."))
      << o.err;
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
  // Nothing is proven where no hash is reached.
  write("begin.pcap", pcap({}, {state(1)}));
  EXPECT_EQ(capture("rebuild begin.pcap --scenario arena --wait-peers 2").status, 1);
}

TEST_F(Program, FollowsAPipeAndAFileThatGrows) {
  write("a.pcap", pcap({}, {state(1), state(2)}));
  const Outcome piped = capture("follow - <a.pcap");
  EXPECT_EQ(piped.status, 0);
  EXPECT_NE(piped.out.find("peer 1 -> 192.0.2.2:4002: tick 2, mark"), std::string::npos) << piped.out;
  const Outcome grown = shell("head -c 150 a.pcap >b.pcap; (sleep 0.3; tail -c +151 a.pcap >>b.pcap) & " +
                              std::string(PADR_CAPTURE) + " follow b.pcap --idle 1.5");
  EXPECT_EQ(grown.status, 0) << grown.err;
  EXPECT_EQ(grown.out, piped.out);
  const Outcome idle = capture("follow - --idle 3 <a.pcap");
  EXPECT_EQ(idle.status, 2);
  EXPECT_EQ(
      idle.err,
      "padr-capture: --idle does not go with standard input, which ends by itself; leave it out, or name a file\n");
}

}  // namespace
}  // namespace padr
