#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/model/scene.h"
#include "common/scenarios/path.h"

namespace padr::lab::examples {

/// What film strips show of a story.
struct Camera {
  Vec2 lower, upper;              ///< m, the part of the scene that is shown
  std::array<float, 5> frames{};  ///< s from the first true contact
  std::string_view letters = {};  ///< on the first bodies, one each
};

/// One of the paper's examples as an experiment: a scene, and what its one moving avatar does in it.
struct Story {
  std::string name;      ///< ball, dominoes, van, carton, proxy, ball-missed, ...
  std::string scenario;  ///< the built-in scenario that it plays in
  std::string title;     ///< one line for people
  Scene scene;
  float seconds = 0;  ///< with everything at rest again well before the end
  Camera camera;
};

/// The avatar stops just short of a body, and its model runs on into it. ball: the paper's Figure 2; dominoes: its
/// Figure 3; van: its large, heavy counter-example, of which it says only that the model hits it; carton, ours: the
/// same with a body of the van's size but 25 kg. proxy: its Figure 4 with one body more, where the avatar does touch.
/// Those with -missed are the converse: the avatar comes along the body, turns and touches it, which its model, going
/// straight on, misses.
std::vector<std::string> story_names();

/// Throws UserError, which begins with --stories, for a name that is not one of them. `dominoes`: how many there are in
/// that story, 1 .. 20.
Story story_by_name(const std::string& name, int dominoes = 20);

/// Where the avatar of a story is drawn towards. Take 0 is the one on film; the others, >= 1, come along a line up to
/// 15 cm beside it and up to 15 % faster or slower, and stop up to 10 cm nearer or farther, each in its own way, so
/// that no result hangs on one path.
scenarios::Path path_of(const Story& story, int take);

}  // namespace padr::lab::examples
