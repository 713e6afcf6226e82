#include "common/paths/introductions.h"

#include <algorithm>

#include "common/model/observed_address.h"

namespace padr::node {

void Introductions::note(std::vector<Introduction>& all, const Introduction& one) {
  std::erase_if(all, [&](const Introduction& i) { return i.newcomer.key == one.newcomer.key; });
  if (all.size() >= kMost) all.erase(all.begin());
  all.push_back(one);
}

void Introductions::redirect(const Endpoint& from, const wire::Join& join, const Endpoint& coordinator, Micros local,
                             Commands& out) {
  if (!out.may_answer(local)) return;
  out.send(from, wire::Redirect{join.nonce, coordinator});
  out.send(coordinator, wire::Newcomer{from});
  if (session_.config.sealed) note(redirected_, {from, coordinator, local});
}

// In a session with a key the channel to the newcomer, which knows by now whom to expect, sends something there.
void Introductions::on_newcomer(const Endpoint& by, const wire::Newcomer& newcomer, Micros local, Commands& out) {
  if (newcomer.at.has_key() != session_.config.sealed || !out.may_answer(local)) return;
  const Endpoint at = as_seen_from(newcomer.at, by);
  if (!session_.config.sealed) return out.send(at, wire::Newcomer{at});
  note(introduced_, {at, by, local});
}

bool Introductions::may_carry(const Endpoint& from, const Endpoint& to) const {
  return std::any_of(redirected_.begin(), redirected_.end(), [&](const Introduction& i) {
    return (i.newcomer == from && i.other == to) || (i.newcomer == to && i.other == from);
  });
}

void Introductions::advance(Micros local) {
  for (auto* all : {&redirected_, &introduced_})
    std::erase_if(*all, [local](const Introduction& i) { return local - i.since > kLease; });
}

}  // namespace padr::node
