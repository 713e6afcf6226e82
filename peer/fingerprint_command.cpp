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
#include "shell/files.h"
#include "shell/run_main.h"

namespace padr::peer {
namespace {

#ifdef __clang__
constexpr const char* kCompiler = "";  // its version names it
#else
constexpr const char* kCompiler = "g++ ";
#endif
constexpr std::string_view kLine = "fingerprint: ";

/// The 16 digits, or the whole line as it is printed.
std::uint64_t parsed(std::string_view text) {
  if (text.starts_with(kLine)) text.remove_prefix(kLine.size());
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
  if (argc == 3 && other.empty()) throw UserError("fingerprint: OTHER is empty; give a fingerprint, or leave it out");
  const std::uint64_t theirs = other.empty() ? 0 : parsed(other);
  const std::uint64_t ours = world::physics_fingerprint();
  std::string text = std::string(kLine) + hex(ours) + "\ncomputed by: " + processor() + ", " + kCompiler + __VERSION__ +
                     ", Box2D from " + PADR_BOX2D_ORIGIN + "\n";
  const std::string habits = world::habits_text(ours);
  if (!habits.empty()) text += "this program " + habits + "\n";
  const std::string differs =
      other.empty() ? habits : world::physics_difference(ours, theirs, "this one", "the other one");
  if (!other.empty())
    text += differs.empty() ? "the other one's physics is the same\n" : "they differ: " + differs + "\n";
  shell::write_text("fingerprint", "-", text);
  return differs.empty() ? shell::kExitFine : shell::kExitFailure;
}

}  // namespace padr::peer
