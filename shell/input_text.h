#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/model/scene.h"
#include "common/scenarios/input.h"

namespace padr::shell {

/// What an input specification needs to know beside itself.
struct InputContext {
  const Scene& scene;
  int slot = 0;            ///< avatar slot, 0 .. spawns-1: where the avatar starts
  std::uint64_t seed = 0;  ///< of generated input that names no seed of its own; slots draw different numbers from it
  /// Reads the file of a path. Its errors are its own: it should throw UserError that names the file.
  std::function<std::string(const std::string& file)> read;
};

/// What `path:FILE` or `path:FILE,loop` says.
struct PathText {
  std::string file;
  bool loop = false;
};
/// Nothing for input that is no path.
std::optional<PathText> path_text(std::string_view spec);

/// The input that `spec` names:
///   `path:FILE`       the recorded path in FILE (CSV, see path_csv.h), staying at its end
///   `path:FILE,loop`  the same, over and over
///   `wander`          made-up human motion all over the play area (see wander.h)
///   `wander:SEED`     the same from a seed of its own, 0 .. 2^64-1
///   `rest`            the avatar's start position, always
/// Throws UserError for anything else, for a slot the scene does not have, and for what is wrong with FILE.
std::unique_ptr<scenarios::InputSource> make_input(std::string_view spec, const InputContext& context);

}  // namespace padr::shell
