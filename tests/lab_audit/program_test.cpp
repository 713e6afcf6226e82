// padr-lab audit as a user meets it.
#include <nlohmann/json.hpp>

#include "tests/lab_audit/lies.h"
#include "tests/shell.h"

namespace padr::test {
namespace {

class AuditProgram : public Shell {
 protected:
  Outcome lab(const std::string& words) const { return shell(std::string("'") + PADR_LAB + "' " + words); }
  void record(const std::string& words) const {
    const Outcome o = lab("run --seconds 4 --fidelity off " + words);
    ASSERT_EQ(o.status, 0) << o.err;
  }
};

TEST_F(AuditProgram, HonestTracesSayNothing) {
  record("--peers 3 --netem 'delay 60ms 20ms loss 5%' --trace t");
  const Outcome o = lab("audit t/*");
  EXPECT_EQ(o.status, 0) << o.out << o.err;
  EXPECT_TRUE(o.out.starts_with("nothing found: 3 traces, ")) << o.out;
  const Outcome json = lab("audit t/* --json -");
  EXPECT_EQ(json.status, 0);
  const auto j = nlohmann::json::parse(json.out);
  EXPECT_TRUE(j["findings"].empty());
  EXPECT_GT(j["judged"], 20);
  EXPECT_GT(j["closest"]["avatar_speed"]["measured"], 0);
  EXPECT_TRUE(j["closest"]["body_jump"]["measured"].is_null() || j["closest"]["body_jump"]["allowed"] > 0);
  record("--peers 1 --technique avatar-only --trace alone");
  const auto none = nlohmann::json::parse(lab("audit alone/* --json -").out)["closest"]["claim"];
  EXPECT_TRUE(none["measured"].is_null() && none["allowed"].is_null()) << "nobody claims anything";
}

TEST_F(AuditProgram, WhatFollowsTheEndOfATraceIsNoted) {
  record("--peers 1 --trace t");
  const std::string whole = read("t/peer0.trace");
  write("long.trace", whole + "\x50 and more");
  for (const char* words : {"audit long.trace", "replay long.trace"}) {
    const Outcome o = lab(words);
    EXPECT_EQ(o.status, 0) << o.err;
    EXPECT_NE(o.out.find("that is no part of a trace"), std::string::npos) << o.out;
  }
  EXPECT_EQ(lab("audit t/peer0.trace").out.find("Note"), std::string::npos);
}

TEST_F(AuditProgram, ALiarHasItsParagraphAndEverythingIsInTheFile) {
  LiarTrial t(601, "delay 30ms 5ms loss 1%");
  t.trial().party().net().attract(Vec2{10, 7});
  tell_one_otherwise(t, 0.5F);
  t.run(6);
  const lab::audit::Report r = t.report();
  ASSERT_GT(LiarTrial::count(r, lab::audit::Kind::kTwoUpdates), 1);
  for (const auto& text : t.recorder().traces({t.trial().person(LiarTrial::kLiar)}))
    write(text.label, std::string(reinterpret_cast<const char*>(text.bytes.data()), text.bytes.size()));
  const Outcome o = lab("audit *.trace --worst 1 --json all.json");
  EXPECT_EQ(o.status, 1) << o.err;
  EXPECT_NE(o.out.find("slot 2, incarnation "), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("PROOF: it signed both [person"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find(" more of the kind two_updates\n"), std::string::npos) << o.out;
  const auto j = nlohmann::json::parse(read("all.json"));
  EXPECT_EQ(j["findings"].size(), r.findings.size());
  EXPECT_EQ(j["findings"][0]["slot"], 2);
  EXPECT_EQ(j["findings"][0]["signed"], true);
  EXPECT_EQ(j["findings"][0]["key"].get<std::string>().size(), 64U);
}

// Each would otherwise work for up to hours first.
TEST_F(AuditProgram, NoCommandBeginsWithoutThePlaceForItsResult) {
  record("--peers 2 --trace t");
  for (const char* words : {"audit t/peer0.trace", "run --seconds 80000 --trace none", "crowd --peers 1000",
                            "chaos --runs 100000", "run --seconds 80000 --csv no/such.csv"}) {
    const Outcome o = lab(std::string(words) + " --json no/such.json");
    EXPECT_EQ(o.status, 2) << words;
    EXPECT_NE(o.err.find("cannot write 'no/such."), std::string::npos) << words << "\n" << o.err;
  }
  write("old.json", "{}");
  EXPECT_EQ(lab("audit none.trace --json old.json").status, 2);
  EXPECT_EQ(read("old.json"), "{}") << "a mistake leaves it as it is";
}

TEST_F(AuditProgram, WhatItCannotUseHasOneLineAndExit2) {
  record("--peers 2 --seed 1 --trace a");
  record("--peers 2 --seed 2 --trace b");
  const std::string whole = read("a/peer0.trace");
  write("cut.trace", whole.substr(0, 20));
  write("bent.trace", whole.substr(0, whole.size() / 2) + std::string(3, '\xFF') + whole.substr(whole.size() / 2));
  for (const char* words : {"audit", "audit none.trace", "audit cut.trace", "audit a/peer0.trace b/peer1.trace",
                            "audit bent.trace", "audit a/peer0.trace --worst 0", "audit a/peer0.trace a/peer0.trace"}) {
    const Outcome o = lab(words);
    EXPECT_EQ(o.status, 2) << words << "\n" << o.out;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << words << "\n" << o.err;
  }
  EXPECT_NE(lab("audit a/peer0.trace a/peer0.trace").err.find("is a trace of peer 0, and so is a/peer0.trace"),
            std::string::npos);
  write("short.trace", whole.substr(0, whole.size() / 2));
  EXPECT_NE(lab("audit short.trace").out.find("Note: short.trace breaks off"), std::string::npos);
  EXPECT_NE(lab("audit a/peer0.trace b/peer1.trace").err.find("is of another session than a/peer0.trace"),
            std::string::npos);
}

}  // namespace
}  // namespace padr::test
