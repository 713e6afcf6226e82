#include "peer/fingerprint_command.h"

#include <sys/utsname.h>

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

#include "common/model/hash.h"
#include "common/model/user_error.h"
#include "common/world/fingerprint.h"
#include "shell/run_main.h"

namespace padr::peer {
namespace {

#ifdef __clang__
constexpr const char* kCompiler = "";  // its version names it
#else
constexpr const char* kCompiler = "g++ ";
#endif

std::uint64_t parsed(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (text.size() != 16 || error != std::errc{} || end != text.data() + text.size())
    throw UserError("fingerprint: '" + std::string(text) + "' is no fingerprint, which has 16 hexadecimal digits");
  return value;
}

std::string processor() {
  utsname system{};
  return ::uname(&system) == 0 ? static_cast<const char*>(system.machine) : "unknown";
}

}  // namespace

int fingerprint_command(int argc, const char* const* argv) {
  const std::string_view other = argc > 2 ? argv[2] : "";
  if (argc == 3 && (other == "--help" || other == "-h")) {
    std::puts(
        "usage: padr-peer fingerprint [OTHER]\n\n"
        "Prints the fingerprint of physics as it comes out here. Machines with equal fingerprints can share a "
        "session.\n"
        "With OTHER, the fingerprint that another machine has printed, says what differs and what to do.\n"
        "Exit: 0 fine, 1 they differ, or this machine or build computes otherwise than every peer should, 2 usage.");
    return shell::kExitFine;
  }
  if (argc > 3)
    throw UserError("fingerprint: '" + std::string(argv[3]) + "' is not expected; give one fingerprint, or nothing");
  const std::uint64_t theirs = other.empty() ? 0 : parsed(other);
  const std::uint64_t ours = world::physics_fingerprint();
  std::printf("fingerprint: %s\n", hex(ours).c_str());
  std::printf("computed by: %s, %s%s, Box2D from %s\n", processor().c_str(), kCompiler, __VERSION__, PADR_BOX2D_ORIGIN);
  const std::string habits = world::habits_text(ours);
  if (!habits.empty()) std::printf("this program %s\n", habits.c_str());
  if (other.empty()) return habits.empty() ? shell::kExitFine : shell::kExitFailure;
  const std::string differs = world::physics_difference(ours, theirs, "this one", "the other one");
  std::printf("%s\n", differs.empty() ? "the other one's physics is the same" : ("they differ: " + differs).c_str());
  return differs.empty() ? shell::kExitFine : shell::kExitFailure;
}

}  // namespace padr::peer
