#include "tests/membership/party.h"
#include "tools/lab/chaos/play.h"
#include "tools/lab/chaos/shrink.h"

namespace padr::test {
namespace {

lab::ChaosPlay small_play() {
  lab::ChaosPlay how;
  how.scene = party_config(2, "", 1, 12).scene;
  how.technique = technique_by_name("full");
  return how;
}

class Chaos : public testing::TestWithParam<int> {};

TEST_P(Chaos, Holds) {
  const auto seed = static_cast<std::uint64_t>(GetParam());
  const lab::ChaosScript script = lab::make_script(seed, seconds(40), 8);
  const lab::ChaosOutcome outcome = lab::play(small_play(), script);
  EXPECT_EQ(outcome.violation, "") << lab::describe(script);
  EXPECT_GT(outcome.compared, 0U);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Chaos, testing::Range(9001, 9011));

// Scripts that once went wrong, and why.
INSTANTIATE_TEST_SUITE_P(
    Once, Chaos,
    testing::Values(4,     // a founding peer that came back was told the founder's clock
                    6,     // two who took each other for the winning side waited for each other
                    11,    // who came back at an address was knocked for there
                    38,    // probes that were on their way before an admission
                    46,    // two sides alike in number and lowest slot; newcomers who never knew the lost
                    56,    // updates of ticks before the own admission
                    62));  // two lost at once, declared gone at different ticks

class ChaosInFull : public testing::TestWithParam<int> {};

// As `padr-lab chaos --seed N` plays it.
void play_in_full(std::uint64_t seed, wire::SealMode seal) {
  lab::ChaosPlay how = small_play();
  how.scene = party_config(2, "", seed, 12).scene;
  how.slots = static_cast<int>(how.scene.avatar.spawns.size());
  how.seal = seal;
  const lab::ChaosOutcome outcome = lab::play(how, lab::make_script(seed, seconds(120), 12));
  EXPECT_EQ(outcome.violation, "");
  EXPECT_GT(outcome.compared, 10'000U);
}

TEST_P(ChaosInFull, Holds) {
  play_in_full(static_cast<std::uint64_t>(GetParam()), wire::SealMode::kNone);
}

// What the new coordinator passed on of somebody came before the word of the old one that had let it in.
TEST(ChaosSealed, Holds6037) {
  play_in_full(6037, wire::SealMode::kAuth);
}

// A newcomer was given the address of a machine that was asleep and woke up elsewhere.
TEST(ChaosSealed, Holds760019) {
  play_in_full(760019, wire::SealMode::kAuth);
}

// After a suspension of 1.8 s a peer took its link for one of 60 bytes a second, and sent nothing but marks.
TEST(Chaos, Holds852030) {
  play_in_full(852030, wire::SealMode::kNone);
}

// A carrier told a member that had gone of those for which it had carried, at no address.
TEST(ChaosSealed, Holds500016) {
  play_in_full(500016, wire::SealMode::kAuth);
}

// Whoever had stood still took an honest asker for a liar, and thawed the peer whose eviction was under way.
TEST(ChaosSealed, Holds820007) {
  play_in_full(820007, wire::SealMode::kAuth);
}

INSTANTIATE_TEST_SUITE_P(
    Once, ChaosInFull,
    testing::Values(
        41,     // what was passed on of the lost closed a hole beyond which there was more
        171,    // the same, and to newcomers
        280,    // an update that only newcomers had, in a state and not in their logs;
                // who was never told of the other side's addresses
        368,    // somebody removed while a newcomer waited, whose updates all had but the newcomer
        126,    // who was held up while it asked what others have of the lost took them for keeping it back
        1981,   // who had been let in by the lost alone was not asked, and did not believe that the lost was lost
        410,    // who was held up, and only then missed the lost, was taken for one who keeps things back
        529,    // the same, after a short partition
        562));  // whose own updates were passed on did not believe that it had said them

TEST(ChaosScripts, TheSameSeedPlaysTheSame) {
  const lab::ChaosScript script = lab::make_script(77, seconds(20), 6);
  const lab::ChaosOutcome a = lab::play(small_play(), script);
  const lab::ChaosOutcome b = lab::play(small_play(), script);
  EXPECT_EQ(a.compared, b.compared);
  EXPECT_EQ(a.incarnations, b.incarnations);
}

TEST(ChaosScripts, AFailingScriptShrinks) {
  // Too little quiet for anybody to be declared gone: a script with a kill near its end goes wrong.
  lab::ChaosPlay how = small_play();
  how.quiet = seconds(1);
  lab::ChaosScript script;
  script.seed = 6;  // even: nobody is told that nobody listens there any more
  script.founders = 3;
  script.length = seconds(9);
  using Kind = lab::ChaosEvent::Kind;
  for (const auto& [at, kind] :
       {std::pair{5.0, Kind::kFight}, {6.0, Kind::kShape}, {7.0, Kind::kFight}, {8.5, Kind::kKill}})
    script.events.push_back({kind, seconds(at), seconds(0.5), 7});
  ASSERT_NE(lab::play(how, script).violation, "");
  const lab::ChaosScript shortest = lab::shrink(how, script, 50);
  ASSERT_EQ(shortest.events.size(), 1U);
  EXPECT_EQ(shortest.events.front().kind, Kind::kKill);
}

}  // namespace
}  // namespace padr::test
