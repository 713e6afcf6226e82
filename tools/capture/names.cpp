#include "tools/capture/names.h"

#include <array>

namespace padr::capture {

std::string_view name_of(wire::SealError why) {
  constexpr std::array<std::string_view, 7> kNames{"", "short", "long", "magic", "version", "kind", "tag"};
  return kNames[static_cast<std::size_t>(why)];
}

std::string_view name_of(wire::Kind kind) {
  constexpr std::array<std::string_view, 3> kNames{"state", "session", "membership"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::string_view name_of(const wire::SessionMessage& message) {
  constexpr std::array<std::string_view, std::variant_size_v<wire::SessionMessage>> kNames{
      "join", "welcome", "redirect", "refuse", "ping", "pong", "ask", "tell"};
  return kNames[message.index()];
}

std::string_view name_of(const wire::MembershipMessage& message) {
  constexpr std::array<std::string_view, std::variant_size_v<wire::MembershipMessage>> kNames{
      "pull", "piece", "enter", "poll", "answer", "fetch", "fetched", "probe", "reach", "newcomer"};
  return kNames[message.index()];
}

}  // namespace padr::capture
