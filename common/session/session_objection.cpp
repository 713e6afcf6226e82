#include "common/session/session_objection.h"

#include <array>
#include <cstdio>

namespace padr::node {
namespace {

std::string hex(std::uint64_t v) {
  std::array<char, 20> text{};
  const int n = std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(v));
  return {text.data(), static_cast<std::size_t>(n)};
}

std::string authority_words(bool authority) {
  return authority ? "dynamic authority" : "no authority (avatar-only)";
}

}  // namespace

std::string objection(const SessionConfig& c, const wire::Join& join) {
  if (join.fingerprint != c.fingerprint)
    return "physics differs: fingerprint " + hex(c.fingerprint) + " in the session, " + hex(join.fingerprint) +
           " in the newcomer; run the same build on the same kind of machine";
  if (join.scene_hash != c.scene_hash)
    return "scenario differs: '" + c.scenario + "' (hash " + hex(c.scene_hash) + ") in the session, '" + join.scenario +
           "' (hash " + hex(join.scene_hash) + ") in the newcomer";
  if (join.authority != c.authority)
    return "authority rule differs: " + authority_words(c.authority) + " in the session, " +
           authority_words(join.authority) + " in the newcomer";
  return "";
}

}  // namespace padr::node
