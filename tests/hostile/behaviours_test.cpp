// The liars of `padr-lab chaos --liar`: each behaviour does lie, and a script with a liar can be repeated and
// shortened.
#include "common/scenarios/bodies.h"
#include "common/scenarios/scenarios.h"
#include "tests/membership/party.h"
#include "tools/lab/chaos/lies.h"
#include "tools/lab/chaos/play.h"
#include "tools/lab/chaos/shrink.h"

namespace padr::test {
namespace {

lab::ChaosPlay sealed_play() {
  lab::ChaosPlay how;
  how.scene = party_config(2, "", 1, 12).scene;
  how.technique = technique_by_name("full");
  how.seal = wire::SealMode::kAuth;
  how.quiet = seconds(1);
  how.differ = how.bounds.out = how.bounds.unconfirmed = seconds(1000);
  return how;
}

/// Nobody comes or goes, but one is killed and one starts.
lab::ChaosScript short_script(const lab::Behaviour* how) {
  using Kind = lab::ChaosEvent::Kind;
  lab::ChaosScript script;
  script.seed = 5;
  script.founders = 5;
  script.length = seconds(20);
  script.events = {{Kind::kStart, seconds(9), 0, 1}, {Kind::kKill, seconds(11), 0, 4}};
  return lab::with_liar(script, how);
}

class Behaviours : public testing::TestWithParam<std::size_t> {};

TEST_P(Behaviours, TellLies) {
  const lab::Behaviour& how = lab::behaviours()[GetParam()];
  std::uint64_t lies = 0;
  lab::ChaosScript script = short_script(&how);
  for (script.liar->pick = 0; lies == 0 && script.liar->pick < 5; ++script.liar->pick)
    lies += lab::play(sealed_play(), script).lies;
  EXPECT_GT(lies, 0U);
}

INSTANTIATE_TEST_SUITE_P(Each, Behaviours, testing::Range(std::size_t{0}, lab::behaviours().size()),
                         [](const auto& of) {
                           std::string name(lab::behaviours()[of.param].name);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(LyingScripts, TheSameSeedPlaysTheSame) {
  const lab::ChaosScript script = lab::with_liar(lab::make_script(31, seconds(20), 8, 4), nullptr);
  const lab::ChaosOutcome a = lab::play(sealed_play(), script);
  const lab::ChaosOutcome b = lab::play(sealed_play(), script);
  EXPECT_EQ(a.compared, b.compared);
  EXPECT_EQ(a.lies, b.lies);
  EXPECT_EQ(a.violation, b.violation);
}

TEST(LyingScripts, EveryBehaviourIsDrawn) {
  std::set<std::string_view> drawn;
  for (std::uint64_t seed = 1; seed <= 400; ++seed)
    drawn.insert(lab::with_liar(lab::make_script(seed, seconds(10), 8, 4), nullptr).liar->how->name);
  EXPECT_EQ(drawn.size(), 20U);
}

// As `padr-lab chaos --liar` plays them, from 1000 on with --spectators. In each of these an honest peer once was cut
// off by another, was shut out, stood still, stayed in another part, or ended.
class LyingSeeds : public testing::TestWithParam<std::uint64_t> {};

TEST_P(LyingSeeds, ThatHaveFailedOnce) {
  lab::ChaosPlay how;
  how.technique = sealed_play().technique;
  how.seal = wire::SealMode::kAuth;
  how.quiet = seconds(50);
  how.differ = seconds(30);
  how.spectators = GetParam() >= 1000;
  how.scene =
      scenarios::load(scenarios::with_bodies(scenarios::embedded_text("arena"), "arena", 12), "arena", GetParam());
  const auto script = lab::with_liar(lab::make_script(GetParam(), seconds(120), 8, 4), nullptr);
  EXPECT_EQ(lab::play(how, script).violation, "");
}

// Each of them has shown something else; of the rest, which are played nightly, the causes have tests of their own.
INSTANTIATE_TEST_SUITE_P(Each, LyingSeeds, testing::Values(411165, 590951, 591682, 605184, 607401),
                         testing::PrintToStringParamName());
INSTANTIATE_TEST_SUITE_P(Nightly, LyingSeeds,
                         testing::Values(123, 278, 338, 437, 597, 330320, 240250, 401108, 411211, 411184, 410354,
                                         450065, 450089, 460681, 540416, 540450, 560319, 570375, 570390, 581013, 590807,
                                         601328, 603423, 607017, 609021, 609493, 611129, 613260, 616481, 622547, 634743,
                                         636622, 672329, 676038, 870098),
                         testing::PrintToStringParamName());

// The one time in which it tells half of the members other updates is enough.
TEST(LyingScripts, AFailingOneShrinks) {
  lab::ChaosPlay how = sealed_play();
  how.differ = seconds(0.1);
  lab::ChaosScript script = short_script(lab::behaviour("equivocation"));
  script.liar->pick = 0;
  script.liar->times = {{seconds(5), seconds(6)}, {seconds(8), seconds(14)}};
  ASSERT_NE(lab::play(how, script).violation, "");
  const lab::ChaosScript shortest = lab::shrink(how, script, 50);
  EXPECT_TRUE(shortest.events.empty());
  EXPECT_EQ(shortest.liar->times.size(), 1U);
  EXPECT_NE(lab::play(how, shortest).violation, "");
}

}  // namespace
}  // namespace padr::test
