#include "shell/input_text.h"

#include <algorithm>
#include <charconv>

#include "common/model/rng.h"
#include "common/model/user_error.h"
#include "common/scenarios/path.h"
#include "common/scenarios/wander.h"
#include "shell/path_csv.h"

namespace padr::shell {
namespace {

class Rest : public scenarios::InputSource {
 public:
  explicit Rest(Vec2 where) : where_(where) {}
  Vec2 target(Tick /*tick*/) override { return where_; }

 private:
  Vec2 where_;
};

class PathInput : public scenarios::InputSource {
 public:
  PathInput(scenarios::Path path, bool loop) : path_(std::move(path)), loop_(loop) {}
  Vec2 target(Tick tick) override { return path_.at(static_cast<double>(tick) / kTicksPerSecond, loop_); }

 private:
  scenarios::Path path_;
  bool loop_;
};

[[noreturn]] void refuse(std::string_view spec, const std::string& why) {
  throw UserError("input: \"" + std::string(spec) + "\" " + why);
}

std::unique_ptr<scenarios::InputSource> path_input(std::string_view spec, const PathText& path,
                                                   const InputContext& context) {
  if (path.file.empty()) refuse(spec, "names no file, allowed: path:FILE or path:FILE,loop");
  if (!context.read) refuse(spec, "needs a file, and files cannot be read here, allowed: wander, wander:SEED or rest");
  return std::make_unique<PathInput>(parse_path_csv(context.read(path.file), path.file), path.loop);
}

std::uint64_t seed_of(std::string_view spec, std::string_view text) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc() || end != text.data() + text.size()) {
    refuse(spec, "has no seed after the colon, allowed: wander:0 .. wander:18446744073709551615");
  }
  return seed;
}

}  // namespace

std::optional<PathText> path_text(std::string_view spec) {
  constexpr std::string_view kPath = "path:";
  constexpr std::string_view kLoop = ",loop";
  if (!spec.starts_with(kPath)) return std::nullopt;
  spec.remove_prefix(kPath.size());
  const bool loop = spec.ends_with(kLoop);
  if (loop) spec.remove_suffix(kLoop.size());
  return PathText{std::string(spec), loop};
}

std::unique_ptr<scenarios::InputSource> make_input(std::string_view spec, const InputContext& context) {
  const std::vector<Vec2>& spawns = context.scene.avatar.spawns;
  if (context.slot < 0 || static_cast<std::size_t>(context.slot) >= spawns.size()) {
    refuse(spec, "is for avatar slot " + std::to_string(context.slot) + ", allowed in scenario " + context.scene.name +
                     ": 0 .. " + std::to_string(static_cast<int>(spawns.size()) - 1));
  }
  constexpr std::string_view kWanderSeed = "wander:";
  if (spec == "rest") return std::make_unique<Rest>(spawns[static_cast<std::size_t>(context.slot)]);
  if (spec == "wander")
    return std::make_unique<scenarios::Wander>(scenarios::wander_options(context.scene, context.slot), context.seed);
  if (spec.starts_with(kWanderSeed)) {
    const std::uint64_t seed = seed_of(spec, spec.substr(kWanderSeed.size()));
    return std::make_unique<scenarios::Wander>(scenarios::wander_options(context.scene, context.slot), seed);
  }
  if (const auto path = path_text(spec)) return path_input(spec, *path, context);
  refuse(spec, "is no input, allowed: path:FILE, path:FILE,loop, wander, wander:SEED or rest");
}

}  // namespace padr::shell
