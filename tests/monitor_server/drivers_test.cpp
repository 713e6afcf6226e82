#include "tools/monitor/drivers.h"

#include <gtest/gtest.h>

#include <string>

#include "shell/path_csv.h"

namespace padr::monitor {
namespace {

// Once, times were sums of fractions, such as 0.15000000000000002.
TEST(DrivenPaths, HaveTimesThatCanBeRead) {
  DrivenPaths paths;
  Frame frame;
  frame.driven = true;
  for (const Tick tick : {300, 303, 306, 309, 310, 400, 403}) {
    frame.tick = tick;
    frame.target.x += 0.5F;
    paths.take(2, frame);
  }
  const std::string csv = paths.csv(2);
  // The pause between 310 and 400 counts as half a second.
  EXPECT_EQ(csv, "t,x,y\n0,0.5,0\n0.05,1,0\n0.1,1.5,0\n0.15,2,0\n0.166666,2.5,0\n0.666666,3,0\n0.716666,3.5,0\n");
  EXPECT_EQ(shell::write_path_csv(shell::parse_path_csv(csv, "p.csv")), csv);
  EXPECT_EQ(paths.csv(1), "");
}

}  // namespace
}  // namespace padr::monitor
