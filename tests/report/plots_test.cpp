#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tools/report/outputs.h"
#include "tools/report/report.h"

namespace padr::report {
namespace {

/// Sends 1000 bytes a second from `came` to `went`, seconds of the session.
Peer peer(const std::string& name, std::size_t came, std::size_t went) {
  Peer p;
  p.name = name;
  p.came = static_cast<Tick>(came) * kTicksPerSecond;
  p.last_tick = static_cast<Tick>(went) * kTicksPerSecond;
  p.per_second.resize(went);
  for (std::size_t s = came; s < went; ++s) p.per_second[s].wire_bytes = 1000;
  return p;
}

/// kbit/s of a bar's whole pile, by its middle as the file writes it; -1: no such bar.
double kbps_at(const Report& r, const std::string& middle) {
  for (const NamedText& f : plot_files(r)) {
    if (f.name != "traffic.dat") continue;
    std::istringstream lines(f.text);
    for (std::string line; std::getline(lines, line);)
      if (line.rfind(middle + " ", 0) == 0) return std::stod(line.substr(middle.size()));
  }
  return -1;
}

TEST(TrafficPlot, GoesOnWhereAPeerCameLate) {
  Report r;
  r.peers = {peer("0", 30, 60)};
  EXPECT_DOUBLE_EQ(kbps_at(r, "29.50"), 0) << "nobody is there yet";
  EXPECT_DOUBLE_EQ(kbps_at(r, "30.50"), 8);
  EXPECT_DOUBLE_EQ(kbps_at(r, "59.50"), 8);
}

TEST(TrafficPlot, GoesOnForTheLastOfMany) {
  Report r;
  for (const char* name : {"0", "1", "2", "3", "4"}) r.peers.push_back(peer(name, 0, 20));
  r.peers.push_back(peer("5", 10, 40));
  EXPECT_DOUBLE_EQ(kbps_at(r, "5.50"), 8);
  EXPECT_DOUBLE_EQ(kbps_at(r, "15.50"), 8) << "the mean of six";
  EXPECT_DOUBLE_EQ(kbps_at(r, "39.50"), 8) << "of one";
}

TEST(TrafficPlot, LeavesOutARestOfASecond) {
  Report r;
  r.peers = {peer("0", 0, 10)};
  r.peers[0].last_tick += kTicksPerSecond / 10;
  r.peers[0].per_second.resize(11);
  r.peers[0].per_second[10].wire_bytes = 1000;
  EXPECT_DOUBLE_EQ(kbps_at(r, "9.50"), 8);
  EXPECT_DOUBLE_EQ(kbps_at(r, "10.50"), 0);
}

}  // namespace
}  // namespace padr::report
