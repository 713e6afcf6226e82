#include "common/membership/last_heard.h"

#include <algorithm>

namespace padr::node {

bool is_heard(const LastHeard& h) {
  // A mark older than the machine's refusal proves nothing.
  const Tick alive = std::max(h.now - kHeardLately, h.refused.value_or(-1));
  return std::any_of(h.heard.begin(), h.heard.end(),
                     [alive](const std::optional<Tick>& heard) { return heard && *heard > alive; });
}

namespace {

Tick silent(const LastHeard& h) {
  return h.refused ? kSilence + h.now - *h.refused : h.unanswered;
}

}  // namespace

bool stays_by_word(const LastHeard& h) {
  return !h.given_up && !h.deaf && silent(h) < kBelieved && is_heard(h);
}

bool may_evict(const LastHeard& h) {
  if (h.given_up) return true;
  if (silent(h) < kSilence || stays_by_word(h)) return false;
  const auto answered = [](const std::optional<Tick>& heard) { return heard.has_value(); };
  const Tick asked_for = std::min(h.refused ? h.now - *h.refused : h.unanswered - kDoubt,
                                  h.taken_back ? h.now - *h.taken_back : kAnswerPatience);
  return asked_for >= kAnswerPatience || std::all_of(h.heard.begin(), h.heard.end(), answered);
}

}  // namespace padr::node
