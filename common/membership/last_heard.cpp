#include "common/membership/last_heard.h"

#include <algorithm>

namespace padr::node {

bool is_heard(const LastHeard& h) {
  // What was heard before its machine said that nobody listens says nothing.
  const Tick alive = std::max(h.now - kHeardLately, h.refused.value_or(-1));
  return std::any_of(h.heard.begin(), h.heard.end(),
                     [alive](const std::optional<Tick>& heard) { return heard && *heard > alive; });
}

bool may_evict(const LastHeard& h) {
  if (h.given_up) return true;
  const Tick silent = h.refused ? kSilence + h.now - *h.refused : h.unanswered;
  if (silent < kSilence) return false;
  if (!h.deaf && silent < kBelieved && is_heard(h)) return false;
  const auto answered = [](const std::optional<Tick>& heard) { return heard.has_value(); };
  const Tick asked_for = h.refused ? h.now - *h.refused : h.unanswered - kDoubt;
  return asked_for >= kAnswerPatience || std::all_of(h.heard.begin(), h.heard.end(), answered);
}

}  // namespace padr::node
