// Who may be declared gone, as a table.
#include "common/membership/last_heard.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace padr::test {
namespace {

using node::LastHeard;
using Heard = std::vector<std::optional<Tick>>;
constexpr std::optional<Tick> kNoAnswer;
constexpr std::optional<Tick> kNever = -1;

struct Row {
  std::string name;
  Tick unanswered;
  std::optional<Tick> refused;
  bool given_up;
  Heard heard;  ///< at tick 10,000
  bool gone;
  bool deaf = false;
};

TEST(LastHeard, Table) {
  constexpr Tick kNow = 10'000;
  const std::optional<Tick> none;
  const std::vector<Row> rows{
      {"it answers", 10, none, false, {kNever, kNever}, false},
      {"a tick short of silence", 179, none, false, {kNever}, false},
      {"silent, and nobody else is there", 180, none, false, {}, true},
      {"silent, and nobody has ever heard it", 180, none, false, {kNever, kNever}, true},
      {"silent, and all heard it long ago", 180, none, false, {9'880, 9'000}, true},
      {"somebody has heard it just not too long ago", 180, none, false, {9'881, 9'000}, false},
      {"one of many hears it", 200, none, false, {kNever, kNever, 9'990, kNever}, false},
      {"somebody has not answered", 180, none, false, {kNever, kNoAnswer}, false},
      {"nor for a while", 191, none, false, {kNever, kNoAnswer}, false},
      {"who does not answer does not hear it", 192, none, false, {kNever, kNoAnswer}, true},
      {"somebody hears it, and another does not answer", 300, none, false, {9'999, kNoAnswer}, false},
      {"somebody says so, but no update has come", 419, none, false, {9'999}, false},
      {"nobody's word is believed for ever", 420, none, false, {9'999, 9'999}, true},
      {"it is heard here, and takes nothing though others hear it", 180, none, false, {9'999}, true, true},
      {"cut off: it does not matter who hears it", 0, none, true, {9'999}, true},
      {"its machine says that nobody listens there", 60'000, 9'995, false, {9'995, 9'990}, true},
      {"and others have not answered yet", 60'000, 9'995, false, {9'990, kNoAnswer}, false},
      {"nor for a while after that", 60'000, 9'928, false, {9'920, kNoAnswer}, true},
      {"somebody has heard it since", 60'000, 9'990, false, {9'991}, false},
      {"and goes on saying so", 60'000, 9'761, false, {9'999}, false},
      {"but not for ever", 60'000, 9'760, false, {9'999}, true},
  };
  for (const Row& r : rows)
    EXPECT_EQ(node::may_evict({kNow, r.unanswered, r.refused, r.given_up, r.deaf, r.heard, {}}), r.gone) << r.name;
}

// Else it would be asked about again at once, and frozen again before anything of it could come.
TEST(LastHeard, AfterAQuestionIsTakenBackRepliesAreWaitedForAnew) {
  constexpr Tick kNow = 10'000;
  const auto evicts = [](Tick taken_back, const Heard& heard) {
    return node::may_evict({kNow, 300, {}, false, false, heard, taken_back});
  };
  EXPECT_FALSE(evicts(kNow - 71, {kNever, kNoAnswer}));
  EXPECT_TRUE(evicts(kNow - 72, {kNever, kNoAnswer}));
  EXPECT_TRUE(evicts(kNow - 10, {kNever, kNever})) << "all have answered";
}

// By words alone: neither what this peer hears itself nor a reply that is missing.
TEST(LastHeard, StaysByWord) {
  constexpr Tick kNow = 10'000;
  const auto stays = [](const LastHeard& h) { return node::stays_by_word(h); };
  EXPECT_TRUE(stays({kNow, 180, {}, false, false, {kNever, 9'881}, {}}));
  EXPECT_FALSE(stays({kNow, 180, {}, false, false, {kNever, 9'880, kNoAnswer}, {}})) << "heard too long ago";
  EXPECT_FALSE(stays({kNow, 420, {}, false, false, {9'999}, {}})) << "nobody's word is believed for ever";
  EXPECT_FALSE(stays({kNow, 180, {}, true, false, {9'999}, {}})) << "cut off";
  EXPECT_FALSE(stays({kNow, 180, {}, false, true, {9'999}, {}})) << "takes nothing from here";
}

}  // namespace
}  // namespace padr::test
