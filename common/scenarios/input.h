#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "common/model/ids.h"
#include "common/model/scene.h"

namespace padr::scenarios {

/// Where a user wants the avatar to be, for whom or whatever does the wanting.
class InputSource {
 public:
  virtual ~InputSource() = default;
  /// The point the avatar is drawn towards during step `tick`, m; tick 0 stands for any before it. The answer depends
  /// on the tick alone: neither on how often nor in which order ticks are asked for.
  virtual Vec2 target(Tick tick) = 0;
};

/// What an input specification needs to know beside itself.
struct InputContext {
  const Scene& scene;
  int slot = 0;            ///< avatar slot, 0 .. spawns-1: where the avatar starts
  std::uint64_t seed = 0;  ///< of generated input that names no seed of its own; slots draw different numbers from it
  /// Reads the file of a path. Its errors are its own: it should throw UserError that names the file.
  std::function<std::string(const std::string& file)> read;
};

/// The input that `spec` names:
///   `path:FILE`       the recorded path in FILE (CSV, see path.h), staying at its end
///   `path:FILE,loop`  the same, over and over
///   `wander`          made-up human motion all over the play area (see wander.h)
///   `wander:SEED`     the same from a seed of its own, 0 .. 2^64-1
///   `rest`            the avatar's start position, always
/// Throws UserError for anything else, for a slot the scene does not have, and for what is wrong with FILE.
std::unique_ptr<InputSource> make_input(std::string_view spec, const InputContext& context);

}  // namespace padr::scenarios
