#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "common/model/scene.h"
#include "common/scenarios/path.h"

namespace padr::shell {

/// What a path asks for, beside what a scene has.
struct PathSurvey {
  std::size_t points = 0;
  double seconds = 0;
  Vec2 lower, upper;        ///< m, the box about its points
  std::size_t outside = 0;  ///< points outside the scene's play area
  /// m/s: the farthest that it gets from any of its points in the second after it. What an avatar follows is how far it
  /// has to go; a pointer's speed between two samples says little.
  double fastest = 0;
  std::size_t too_fast = 0;  ///< points after which that is more than the avatar's greatest speed
};
PathSurvey survey_path(const scenarios::Path& path, const Scene& scene);

/// Most that `padr-lab path --stretch` multiplies times by.
inline constexpr double kMostStretch = 1000;

/// For people: what the path asks for and what the world has.
struct PathNotes {
  std::string summary;
  std::vector<std::string> warnings;  ///< that its units are others, or it is of another world
};
PathNotes notes_on_path(const scenarios::Path& path, std::string_view label, const Scene& scene);

/// The path scaled alike in x and y and moved, so that its box fills the play area, less the avatar's radius, in the
/// middle; its first point is at 0 s. `turned`: y grows downwards in it, as in pictures and windows. Throws UserError,
/// which begins with `label`, if it does not move.
scenarios::Path fit_path(const scenarios::Path& path, std::string_view label, const Scene& scene, bool turned);

}  // namespace padr::shell
