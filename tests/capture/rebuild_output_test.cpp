#include "tools/capture/rebuild_output.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "common/sync/fold.h"
#include "shell/files.h"
#include "tools/plot/palette.h"

namespace padr::capture {
namespace {

TEST(WorldPicture, GivesAvatarsAndOwnedBodiesTheColourOfTheirPeer) {
  Setting setting;
  setting.scene.bodies.resize(2);
  sync::FoldState s;
  s.world.entities.resize(4);
  s.avatars.resize(2);
  s.avatars[1].present = true;
  s.authority = {{}, {.owner = 1, .released = false}};
  WorldPicture picture;
  picture.add(s);
  const std::string svg = picture.svg(setting);
  std::size_t painted = 0;
  const std::string paint = "fill=\"" + std::string(plot::colour_by_number(1)) + "\"";
  for (std::size_t at = svg.find(paint); at != std::string::npos; at = svg.find(paint, at + 1)) ++painted;
  EXPECT_EQ(painted, 4U * 2 + 1) << "an avatar and a body in four frames, and the key\n" << svg;
  EXPECT_NE(svg.find(">peer 1<"), std::string::npos) << svg;
  EXPECT_EQ(svg.find(plot::colour_by_number(0)), std::string::npos) << "of a peer that is not there\n" << svg;
}

// Peer 0 is a member, and its avatar is away. Once, picture and rows had an avatar for it.
TEST(RebuiltWorld, ASpectatorHasNoAvatar) {
  Setting setting;
  sync::FoldState s;
  s.world.entities.resize(2);
  s.members = {{.present = true}, {.present = true}};
  s.avatars.resize(2);
  s.avatars[1].present = true;
  WorldPicture picture;
  picture.add(s);
  const std::string svg = picture.svg(setting);
  EXPECT_EQ(svg.find(">peer 0<"), std::string::npos) << svg;
  EXPECT_NE(svg.find(">peer 1<"), std::string::npos) << svg;

  const std::string file = ::testing::TempDir() + "spectator.csv";
  StatesCsv csv(file);
  csv.add(s);
  csv.close();
  const std::string rows = shell::read_file("--csv", file);
  std::remove(file.c_str());
  EXPECT_EQ(rows.find("\n0,0,"), std::string::npos) << rows;
  EXPECT_NE(rows.find("\n0,1,"), std::string::npos) << rows;
}

}  // namespace
}  // namespace padr::capture
