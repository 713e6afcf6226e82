#include "common/session/session_objection.h"

#include <array>
#include <charconv>

#include "common/model/hash.h"
#include "common/world/fingerprint.h"

namespace padr::node {
namespace {

std::string authority_words(bool authority) {
  return authority ? "dynamic authority" : "no authority (avatar-only)";
}

}  // namespace

std::string objection(const SessionConfig& c, const wire::Join& join) {
  if (join.fingerprint != c.fingerprint)
    return "physics differs: fingerprint " + hex(c.fingerprint) + " in the session, " + hex(join.fingerprint) +
           " in the newcomer: " +
           world::physics_difference(c.fingerprint, join.fingerprint, "the session", "the newcomer");
  if (join.scene_hash != c.scene_hash)
    return "scenario differs: '" + c.scenario + "' (hash " + hex(c.scene_hash) + ") in the session, '" + join.scenario +
           "' (hash " + hex(join.scene_hash) + ") in the newcomer";
  if (join.authority != c.authority)
    return "authority rule differs: " + authority_words(c.authority) + " in the session, " +
           authority_words(join.authority) + " in the newcomer";
  return "";
}

std::string no_admission(const Endpoint& by, Micros within, const std::string& why) {
  return "no admission by " + to_string(by) + " within " + in_seconds(within) + ": " +
         (why.empty() ? "a member answered, but its world did not come through in time"
                      : why + "; another member may let it in");
}

std::string in_seconds(Micros t) {
  std::array<char, 32> text{};
  constexpr Micros kHundredth = kMicrosPerSecond / 100;
  const Micros shown = t < kMicrosPerSecond ? t : (t + kHundredth / 2) / kHundredth * kHundredth;
  const double s = static_cast<double>(shown) / static_cast<double>(kMicrosPerSecond);
  return std::string(text.data(), std::to_chars(text.data(), text.data() + text.size(), s).ptr) + " s";
}

}  // namespace padr::node
