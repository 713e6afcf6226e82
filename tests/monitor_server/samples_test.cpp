#include "tools/monitor/samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

namespace padr::monitor {
namespace {

TEST(Samples, NamesArePlainAndDiffer) {
  std::set<std::string_view> names;
  for (const Sample& s : samples()) {
    EXPECT_TRUE(names.insert(s.name).second) << s.name;
    EXPECT_TRUE(std::all_of(s.name.begin(), s.name.end(), [](unsigned char c) {
      return std::islower(c) != 0 || std::isdigit(c) != 0 || c == '-';
    })) << s.name;
    EXPECT_EQ(find_sample(s.name), &s);
  }
  EXPECT_EQ(find_sample(""), nullptr);
  EXPECT_EQ(find_sample("nothing"), nullptr);
}

TEST(Samples, TheCommandSaysAllThatItTakes) {
  EXPECT_EQ(lab_command(*find_sample("bad-network-full")),
            "padr-lab run --scenario arena --peers 4 --technique full --input wander --netem \"delay 100ms 50ms loss "
            "10%\" --seconds 20 --seed 1");
}

TEST(Samples, AreTheSameEachTime) {
  for (const Sample& s : samples()) {
    if (s.peers > 2) continue;  // take long with sanitizers
    const Film one = film_sample(s);
    const Film two = film_sample(s);
    EXPECT_EQ(one.first(), 1) << s.name;
    EXPECT_EQ(one.last(), s.seconds * kTicksPerSecond) << s.name;
    ASSERT_EQ(one.moments.size(), two.moments.size()) << s.name;
    for (std::size_t i = 0; i < one.moments.size(); ++i) {
      ASSERT_EQ(one.moments[i].pictures.size(), two.moments[i].pictures.size()) << s.name << ", moment " << i;
      for (std::size_t k = 0; k < one.moments[i].pictures.size(); ++k)
        ASSERT_EQ(*one.moments[i].pictures[k].bytes, *two.moments[i].pictures[k].bytes) << s.name << ", moment " << i;
    }
    // What was recorded replays as it was recorded.
    for (const SessionEvent& e : one.session->events())
      EXPECT_EQ(e.event.text.find("differently"), std::string::npos) << s.name << ": " << e.event.text;
  }
}

// Peers at rest say little: while nothing new is confirmed, the last inconsistency stands.
TEST(Samples, HaveAnInconsistencyFromTheFirstSecondOn) {
  for (const SeriesPoint& point : film_sample(*find_sample("stop-short")).series)
    for (const auto& peer : point.peers)
      EXPECT_TRUE(peer.inconsistency || point.tick < kTicksPerSecond) << "tick " << point.tick;
}

// Once, the figure below a picture that stood was that of a moment before.
TEST(Samples, HaveTheErrorOfTheVeryTickThatIsShown) {
  const Film film = film_sample(*find_sample("stop-short"));
  Screen screen(film);
  const auto points = [&](Tick tick) {
    screen.go_to(tick);
    return nlohmann::json::parse(screen.series())["peers"];
  };
  for (const Tick tick : {120, 301, 300, 450})
    for (const auto& p : points(tick)) {
      EXPECT_EQ(p["at_tick"], tick);
      const auto& all = film.errors.at(p["slot"]);
      const auto at = std::find_if(all.begin(), all.end(), [&](const auto& e) { return e.tick == tick; });
      ASSERT_NE(at, all.end());
      EXPECT_NEAR(p["combined_m"], at->combined(), 1e-3);
    }
  // The last ticks were never confirmed.
  for (const auto& p : points(film.last())) EXPECT_EQ(p["at_tick"], film.errors.at(p["slot"]).back().tick);
  EXPECT_LT(film.errors.at(0).back().tick, film.last());
}

// What a story claims to show is in it.
TEST(Samples, ShowWhatTheySay) {
  const auto most_off = [](const char* name, PeerId slot) {
    float most = 0;
    for (const SeriesPoint& point : film_sample(*find_sample(name)).series)
      for (const auto& peer : point.peers)
        if (peer.slot == slot && peer.inconsistency) most = std::max(most, peer.inconsistency->combined());
    return most;
  };
  EXPECT_GT(most_off("stop-short", 1), 5);
  EXPECT_LT(most_off("predictor", 1), 1);
  EXPECT_GT(most_off("bad-network-fixed", 3), 2 * most_off("bad-network-full", 3));
}

}  // namespace
}  // namespace padr::monitor
