#include "shell/netem_text.h"

#include <gtest/gtest.h>

#include <string>
#include <tuple>
#include <vector>

#include "common/link/shim.h"
#include "common/model/user_error.h"
#include "tests/link/harness.h"

namespace padr::shell {
namespace {

using link::NetemSpec;

/// The one line of the error; a failure if there is none.
std::string error_of(std::string_view text) {
  try {
    const NetemSpec spec = parse_netem(text);
    ADD_FAILURE() << "accepted: " << text << " as " << to_string(spec);
  } catch (const UserError& e) {
    return e.what();
  }
  return {};
}

std::vector<std::string> warnings_of(std::string_view text) {
  std::vector<std::string> warnings;
  parse_netem(text, &warnings);
  return warnings;
}

struct Accepted {
  const char* text;
  const char* canonical;
};

// Each of these was given to iproute2 6.1's tc, which takes it too, but for those at the end.
constexpr Accepted kAccepted[] = {
    {"", ""},
    {"   \t\n ", ""},
    {"delay 100ms", "delay 100ms"},
    {"latency 100ms", "delay 100ms"},
    {"delay 10", "delay 10us"},
    {"delay 1.5ms", "delay 1500us"},
    {"delay .5s", "delay 500ms"},
    {"delay 1e1ms", "delay 10ms"},
    {"delay 10MS", "delay 10ms"},
    {"delay 1sec", "delay 1s"},
    {"delay 2secs", "delay 2s"},
    {"delay 1msecs", "delay 1ms"},
    {"delay 7msec", "delay 7ms"},
    {"delay 3usec", "delay 3us"},
    {"delay 3usecs", "delay 3us"},
    {"delay 3nsec", "delay 3ns"},
    {"delay 3nsecs", "delay 3ns"},
    {"delay 1000ns", "delay 1us"},
    {"delay 10ms 5ms", "delay 10ms 5ms"},
    {"delay 10ms 5ms 25%", "delay 10ms 5ms 25%"},
    {"delay 10ms 5ms 25", "delay 10ms 5ms 25%"},
    {"delay 0 1ms", "delay 0s 1ms"},
    {"delay 10ms 5ms distribution normal", "delay 10ms 5ms distribution normal"},
    {"dist pareto delay 10ms 5ms", "delay 10ms 5ms distribution pareto"},
    {"delay 10ms 5ms di paretonormal", "delay 10ms 5ms distribution paretonormal"},
    {"d 10ms", "delay 10ms"},
    {"del 10ms", "delay 10ms"},
    {"l 10", "limit 10"},
    {"lo 1", "loss 1%"},
    {"dr 1", "loss 1%"},
    {"drop 1%", "loss 1%"},
    {"la 5ms", "delay 5ms"},
    {"delay 10ms r 5", "delay 10ms reorder 5%"},
    {"delay 10ms re 5", "delay 10ms reorder 5%"},
    {"du 1 2", "duplicate 1% 2%"},
    {"c 1", "corrupt 1%"},
    {"ra 1mbit", "rate 1mbit"},
    {"s 10ms", "slot 10ms"},
    {"loss 5", "loss 5%"},
    {"loss 5%", "loss 5%"},
    {"loss 0.5 25%", "loss 0.5% 25%"},
    {"loss 100", "loss 100%"},
    {"loss 0", ""},
    {"loss random 5% 25%", "loss 5% 25%"},
    {"loss state 1", "loss state 1%"},
    {"loss state 1 20", "loss state 1% 20%"},
    {"loss state 1 20 3 40", "loss state 1% 20% 3% 40%"},
    {"loss state 1 2 3 4 5", "loss state 1% 2% 3% 4% 5%"},
    {"loss state 100", "loss state 100%"},
    {"loss state 10", "loss state 10%"},
    {"loss state 1 2 0 100 5", "loss state 1% 2% 0% 100% 5%"},
    {"loss gemodel 1%", "loss gemodel 1%"},
    {"loss gemodel 1% 30%", "loss gemodel 1% 30%"},
    {"loss gemodel 1% 30% 70%", "loss gemodel 1% 30% 70%"},
    {"loss gemodel 1% 30% 70% 0.1%", "loss gemodel 1% 30% 70% 0.1%"},
    {"corrupt 1 25", "corrupt 1% 25%"},
    {"duplicate 0", ""},
    {"delay 10ms reorder 25% 50%", "delay 10ms reorder 25% 50%"},
    {"delay 10ms reorder 25% gap 1", "delay 10ms reorder 25%"},
    {"reorder 25% 50% gap 5 delay 10ms", "delay 10ms reorder 25% 50% gap 5"},
    {"gap 3 delay 10ms reorder 5", "delay 10ms reorder 5% gap 3"},
    {"delay 10ms reorder 5% 50% gap 0", "delay 10ms reorder 5% 50%"},
    {"rate 1000", "rate 1kbit"},
    {"rate 1mbit", "rate 1mbit"},
    {"rate 1Mbit", "rate 1mbit"},
    {"rate 1MiBit", "rate 1048576bit"},
    {"rate 1e3kbit", "rate 1mbit"},
    {"rate 1kbps", "rate 8kbit"},
    {"rate 1kbps -14", "rate 8kbit -14"},
    {"rate 1mbit 20", "rate 1mbit 20"},
    {"rate 1mbit 20 48 5", "rate 1mbit 20 48 5"},
    {"rate 1mbit 20 48 -5", "rate 1mbit 20 48 -5"},
    {"rate 1gbit 0 48", "rate 1gbit 0 48"},
    {"rate 1mbit 20 -48", "rate 1mbit 20"},
    {"rate 0", ""},
    {"slot 10ms", "slot 10ms"},
    {"slot 10", "slot 10us"},
    {"slot 10ms 20ms", "slot 10ms 20ms"},
    {"slot 10ms 20ms packets 3 bytes 500", "slot 10ms 20ms packets 3 bytes 500"},
    {"slot 10ms p 3 b 1k", "slot 10ms packets 3 bytes 1024"},
    {"slot distribution normal 10ms 5ms", "slot distribution normal 10ms 5ms"},
    {"slot 0", ""},
    {"limit 0", "limit 0"},
    {"limit 1k", "limit 1024"},
    {"limit 5.5", "limit 5"},
    {"limit 1000", ""},
    {"delay 5us delay 6us", "delay 6us"},
    {"delay 100ms 20ms loss 1% duplicate 1% corrupt 0.1% reorder 5% rate 1mbit limit 50",
     "delay 100ms 20ms loss 1% corrupt 0.1% duplicate 1% reorder 5% rate 1mbit limit 50"},
    // Beyond that tc:
    {"delay 10ms 5ms distribution uniform", "delay 10ms 5ms"},
    {"seed 5", "seed 5"},
    {"seed 18446744073709551615", "seed 18446744073709551615"},
    {"loss .5", "loss 0.5%"},
    {"trace mobile", "trace mobile"},
    {"trace mobile 0", "trace mobile"},
    {"tr uplink 1.5s", "trace uplink 1500ms"},
    {"trace satellite random", "trace satellite random"},
    {"trace mobile delay 40ms loss 1% limit 50", "delay 40ms loss 1% trace mobile limit 50"},
    {"rate 0 slot 0 trace mobile", "trace mobile"},
    {"trace uplink 5s trace mobile", "trace mobile"},
};

TEST(NetemText, AcceptsWhatTcAccepts) {
  for (const Accepted& a : kAccepted) {
    SCOPED_TRACE(a.text);
    NetemSpec spec;
    ASSERT_NO_THROW(spec = parse_netem(a.text));
    EXPECT_EQ(to_string(spec), a.canonical);
    EXPECT_EQ(parse_netem(a.canonical), spec);
  }
}

struct Rejected {
  const char* text;
  const char* where;  ///< how the message names the word
  const char* says;   ///< and what else it contains
};

constexpr Rejected kRejected[] = {
    {"reorder 5", "word 1 \"reorder\" (column 1)", "needs a delay above 0"},
    {"delay 0 reorder 5", "word 3 \"reorder\" (column 9)", "needs a delay above 0"},
    {"gap 5", "word 1 \"gap\"", "needs a reorder chance"},
    {"delay 10ms gap 5", "word 3 \"gap\" (column 12)", "needs a reorder chance"},
    {"delay 10ms reorder 0 gap 5", "word 5 \"gap\"", "needs a reorder chance"},
    {"distribution normal", "word 1 \"distribution\"", "needs a delay with TIME and JITTER"},
    {"delay 10ms dist normal", "word 3 \"dist\"", "needs a delay with TIME and JITTER"},
    {"delay 10ms distribution normal 5ms", "word 5 \"5ms\"", "unknown"},
    {"delay 10ms 5ms distribution gauss", "word 5 \"gauss\" (column 29)", "allowed: uniform"},
    {"delay 10ms 5ms distribution experimental", "word 5 \"experimental\"", "paretonormal"},
    {"ecn", "word 1 \"ecn\"", "no ECN"},
    {"loss 1 ecn", "word 3 \"ecn\" (column 8)", "no ECN"},
    {"loss 1% loss 2%", "word 3 \"loss\"", "a second loss"},
    {"loss 1% drop gemodel 1%", "word 3 \"drop\"", "a second loss"},
    {"loss 101", "word 2 \"101\" (column 6)", "0% to 100%"},
    {"loss 100.0001%", "word 2 \"100.0001%\"", "0% to 100%"},
    {"loss -1", "word 2 \"-1\"", "random, state, gemodel"},
    {"loss 1%%", "word 2 \"1%%\"", "0% to 100%"},
    {"loss 5%x", "word 2 \"5%x\"", "0% to 100%"},
    {"loss 1.5.", "word 2 \"1.5.\"", "0% to 100%"},
    {"loss nan", "word 2 \"nan\"", "random, state, gemodel"},
    {"loss", "word 1 \"loss\"", "followed by nothing"},
    {"loss random", "word 2 \"random\"", "followed by nothing"},
    {"loss state", "word 2 \"state\"", "P13"},
    {"loss gemodel", "word 2 \"gemodel\"", "P, a percentage"},
    {"loss gem 5", "word 2 \"gem\"", "in full"},
    {"loss r 5", "word 2 \"r\"", "in full"},
    {"loss 5 random", "word 3 \"random\"", "unknown"},
    {"loss random 5% 25% 3", "word 5 \"3\"", "unknown"},
    {"loss state 1 2 3 4 5 6", "word 8 \"6\"", "unknown"},
    {"loss state 60 10 10 10 50", "word 2 \"state\"", "P13 + P14"},
    {"loss state 10 60 50", "word 2 \"state\"", "P31 + P32"},
    {"loss 1 25 gap", "word 4 \"gap\"", "followed by nothing"},
    {"delay", "word 1 \"delay\"", "followed by nothing"},
    {"delay 20mss", "word 2 \"20mss\" (column 7)", "s, ms, us or ns"},
    {"delay 1m", "word 2 \"1m\"", "s, ms, us or ns"},
    {"delay -1ms", "word 2 \"-1ms\"", "0 to 4294s"},
    {"delay 10ms -5ms", "word 3 \"-5ms\"", "unknown"},
    {"delay 10ms 5ms 25% 3", "word 5 \"3\"", "unknown"},
    {"delay 10000s", "word 2 \"10000s\"", "0 to 4294s"},
    {"delay inf", "word 2 \"inf\"", "0 to 4294s"},
    {"delay nan", "word 2 \"nan\"", "0 to 4294s"},
    {"DELAY 10ms", "word 1 \"DELAY\"", "unknown"},
    {"delayed 10ms", "word 1 \"delayed\"", "unknown; allowed here: limit"},
    {"delay 1 s", "word 3 \"s\"", "is a unit; write it right behind its number"},
    {"delay 100 ms", "word 3 \"ms\"", "is a unit; write it right behind its number"},
    {"packets 5", "word 1 \"packets\"", "right after slot"},
    {"slot 10ms bytes 5 packets 5", "word 5 \"packets\"", "packets before bytes"},
    {"slot", "word 1 \"slot\"", "followed by nothing"},
    {"slot 10ms 5ms", "word 3 \"5ms\"", "less than MIN"},
    {"slot 10ms foo 5", "word 3 \"foo\"", "unknown"},
    {"slot dist normal 10ms 1ms", "word 2 \"dist\"", "not a slot"},
    {"slot distribution normal 10ms", "word 2 \"distribution\"", "NAME DELAY JITTER"},
    {"slot distribution normal 10ms 0", "word 5 \"0\"", "JITTER"},
    {"slot 10ms packets x", "word 4 \"x\"", "from 0 to 2147483647"},
    {"limit -1", "word 2 \"-1\"", "0 to 4294967295"},
    {"limit 5000000000", "word 2 \"5000000000\"", "0 to 4294967295"},
    {"gap x", "word 2 \"x\"", "whole number"},
    {"gap 1.5", "word 2 \"1.5\"", "whole number"},
    {"rate fast", "word 2 \"fast\"", "mbit"},
    {"rate 100%", "word 2 \"100%\"", "interface's speed"},
    {"rate 0.5bit", "word 2 \"0.5bit\"", "1bit to 10tbit"},
    {"rate 1mbit 20 48 5 6", "word 6 \"6\"", "unknown"},
    {"rate 1mbit 20x", "word 3 \"20x\"", "-65535 to 65535"},
    {"rate 1mbit foo", "word 3 \"foo\"", "unknown"},
    {"seed x", "word 2 \"x\"", "whole number"},
    {"seed -1", "word 2 \"-1\"", "whole number"},
    {"trace", "word 1 \"trace\" (column 1)", "a built-in link trace (mobile, satellite, uplink) or a file must follow"},
    {"trace mobil", "word 2 \"mobil\" (column 7)",
     "not one of mobile, satellite, uplink; files can be named on a command"},
    {"trace /etc/passwd", "word 2 \"/etc/passwd\" (column 7)", "files can be named on a command line only"},
    {"trace mobile 5parsecs", "word 3 \"5parsecs\"", "not a valid START; allowed: 0 to 4294s"},
    {"trace mobile rand", "word 3 \"rand\"", "unknown"},
    {"trace mobile 5s random", "word 4 \"random\"", "unknown"},
    {"rate 1mbit trace mobile", "word 3 \"trace\"", "not allowed with rate: both say when packets leave"},
    {"trace mobile slot 10ms", "word 1 \"trace\"", "not allowed with slot"},
    {"delay \x01\xff", "word 2 \"\\x01\\xff\"", "s, ms, us or ns"},
};

TEST(NetemText, RejectsAndNamesTheWord) {
  for (const Rejected& r : kRejected) {
    SCOPED_TRACE(r.text);
    const std::string message = error_of(r.text);
    EXPECT_EQ(message.rfind("word ", 0), 0U) << message;
    EXPECT_NE(message.find(r.where), std::string::npos) << message;
    EXPECT_NE(message.find(r.says), std::string::npos) << message;
  }
}

NetemSpec with_file(const std::string& text, const std::string& netem = "trace my.link") {
  return parse_netem(netem, nullptr, [&text](const std::string& file) {
    if (file != "my.link") throw UserError("as a file: cannot read '" + file + "': No such file or directory");
    return text;
  });
}

TEST(NetemText, LinkTracesFromFiles) {
  using Times = std::vector<std::uint32_t>;
  EXPECT_EQ(*with_file("0\n0\n7\n4294967295\n").trace.opportunities, (Times{0, 0, 7, 4294967295}));
  EXPECT_EQ(*with_file("5").trace.opportunities, Times{5});
  EXPECT_EQ(*with_file("5\r\n6\r\n").trace.opportunities, (Times{5, 6}));

  const NetemSpec spec = with_file("5\n6", "delay 1ms trace my.link 2s");
  EXPECT_EQ(to_string(spec), "delay 1ms trace my.link 2s");
  EXPECT_EQ(with_file("5\n6", to_string(spec)), spec);
  EXPECT_NE(with_file("5\n7", to_string(spec)), spec);
  EXPECT_NE(with_file("5\n6", "delay 1ms"), spec);
  EXPECT_EQ(with_file("5", "trace mobile"), parse_netem("trace mobile"));  // what is built in comes first
}

TEST(NetemText, WhatIsWrongWithALinkTraceIsNamedByLine) {
  const auto error_of_file = [](const std::string& text, const char* netem = "trace my.link") -> std::string {
    try {
      with_file(text, netem);
    } catch (const UserError& e) {
      return e.what();
    }
    ADD_FAILURE() << "accepted: " << text;
    return {};
  };
  const std::string begin = "word 2 \"my.link\" (column 7): my.link:";
  const std::string allowed = " is no time, allowed: a whole number of milliseconds, 0 to 4294967295";
  EXPECT_EQ(error_of_file(""), begin + "1: the file is empty, allowed: lines with a time in milliseconds each");
  EXPECT_EQ(error_of_file("0\n0\n"), begin + "2: the last time is 0, allowed: 1 or later, as the trace is so long");
  EXPECT_EQ(error_of_file("5\n4\n"), begin + "2: 4 after 5, allowed: the time of the line before, or later");
  EXPECT_EQ(error_of_file("5\n\n6\n"), begin + "2: \"\"" + allowed);
  EXPECT_EQ(error_of_file("# mine\n5\n"), begin + "1: \"# mine\"" + allowed);
  EXPECT_EQ(error_of_file("5\n-6\n"), begin + "2: \"-6\"" + allowed);
  EXPECT_EQ(error_of_file("5\n6.5\n"), begin + "2: \"6.5\"" + allowed);
  EXPECT_EQ(error_of_file("5\n4294967296\n"), begin + "2: \"4294967296\"" + allowed);
  EXPECT_EQ(error_of_file("5 \n"), begin + "1: \"5 \"" + allowed);
  EXPECT_EQ(error_of_file("\x01\xff\n"), begin + "1: \"\\x01\\xff\"" + allowed);
  EXPECT_EQ(error_of_file("5", "trace mobil"),
            "word 2 \"mobil\" (column 7): not one of mobile, satellite, uplink; as a file: cannot read 'mobil': No "
            "such file or directory");
}

/// They last as long as the recipes say, and carry what these say.
TEST(NetemText, BuiltInLinkTraces) {
  for (const auto& [name, seconds, kbit] :
       {std::tuple{"mobile", 120.0, 757.0}, {"satellite", 60.0, 1197.0}, {"uplink", 60.0, 557.0}}) {
    SCOPED_TRACE(name);
    const NetemSpec spec = parse_netem(std::string("trace ") + name);
    const std::vector<std::uint32_t>& times = *spec.trace.opportunities;
    EXPECT_EQ(times.back(), seconds * 1'000);
    EXPECT_NEAR(static_cast<double>(times.size() * link::kOpportunityBytes * 8) / seconds / 1e3, kbit, 1);
  }
}

TEST(NetemText, ValuesAreFixedPoint) {
  const NetemSpec spec = parse_netem("loss 50% corrupt 100%");
  EXPECT_EQ(std::get<link::Knob>(spec.loss).chance, 0x80000000U);
  EXPECT_EQ(spec.corrupt.chance, link::kAlways);
}

TEST(NetemText, WarnsOfWhatIsRarelyMeant) {
  struct Case {
    const char* text;
    const char* says;
  };
  for (const Case& c :
       {Case{"delay 100", "100ms if milliseconds"}, Case{"delay 1ms 100", "word 3"}, Case{"slot 5", "microseconds"},
        Case{"loss 5% 25%", "gemodel"}, Case{"delay 10ms 5ms 25%", "hardly"}, Case{"rate 10kbps", "BYTES"},
        Case{"rate 1mbit 20 -48", "without a CELL"}, Case{"limit 0", "every packet"},
        Case{"duplicate 5% 25%", "correlated duplication does not keep its mean"},
        Case{"corrupt 5% 25%", "correlated corruption does not keep its mean"},
        Case{"delay 10ms reorder 5% 25%", "correlated reordering does not keep its mean"},
        Case{"delay 5us delay 6us", "given twice"}, Case{"delay 5s 3s", "2.147483647s"},
        Case{"delay 5ms 6ms", "below 0"}, Case{"trace mobile 5", "5ms if milliseconds"}}) {
    SCOPED_TRACE(c.text);
    const auto warnings = warnings_of(c.text);
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_NE(warnings[0].find(c.says), std::string::npos) << warnings[0];
  }
  for (const char* quiet :
       {"", "delay 0", "delay 100ms 20ms distribution normal", "loss gemodel 1% 30%", "delay 10ms reorder 25% gap 5",
        "rate 1mbit", "duplicate 5%", "corrupt 100% 25%", "delay 10ms reorder 0% 25%"}) {
    EXPECT_TRUE(warnings_of(quiet).empty()) << quiet;
  }
}

/// Words of the grammar and noise, in any order: a specification that reads back as itself and that a shim can run,
/// or one printable line.
TEST(NetemText, SurvivesGarbage) {
  const char* const kWords[] = {"limit",   "delay",  "latency", "loss",    "drop",  "random",    "state",
                                "gemodel", "ecn",    "reorder", "corrupt", "gap",   "duplicate", "distribution",
                                "normal",  "pareto", "uniform", "rate",    "slot",  "packets",   "bytes",
                                "seed",    "1ms",    "20ms",    "5%",      "100%",  "25",        "0",
                                "-3",      "1mbit",  "trace",   "uplink",  "8kbps", "9e99",      ".",
                                "1.2.3",   "0x10",   "%",       "1e",      "d",     "r",         "\xC3\xA4"};
  Rng rng(link::testing::seed());
  int accepted = 0;
  for (std::uint32_t i = 0; i < 50'000; ++i) {
    std::string text;
    const auto words = rng.below(12);
    for (std::uint32_t w = 0; w < words; ++w) {
      if (rng.chance(0.05)) {
        for (auto n = rng.below(20); n > 0; --n) text += static_cast<char>(rng.below(256));
      } else {
        text += kWords[rng.below(std::size(kWords))];
      }
      text += ' ';
    }
    SCOPED_TRACE(link::testing::seed_note() + " text: " + text);
    try {
      const NetemSpec spec = parse_netem(text);
      ++accepted;
      ASSERT_EQ(parse_netem(to_string(spec)), spec) << to_string(spec);
      link::Shim shim(spec, i);
      for (int n = 0; n < 5; ++n) shim.accept(n * 1000, link::testing::numbered(7));
      while (shim.release(Micros{1} << 50U)) continue;
      ASSERT_EQ(shim.in_flight(), 0U);
    } catch (const UserError& e) {
      for (const char c : std::string_view(e.what())) ASSERT_TRUE(c >= 0x20 && c < 0x7F) << e.what();
      ASSERT_LT(std::string_view(e.what()).size(), 500U);
    }
  }
  EXPECT_GT(accepted, 1'000);
}

}  // namespace
}  // namespace padr::shell
