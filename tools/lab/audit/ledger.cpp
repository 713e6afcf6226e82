#include "tools/lab/audit/ledger.h"

#include <algorithm>

namespace padr::lab::audit {
namespace {

float fastest_in(const sync::Bundle& b) {
  float fastest = b.avatar ? length(b.avatar->velocity) : 0;
  for (const sync::BodyUpdate& u : b.bodies)
    if (u.has_state) fastest = std::max(fastest, length(u.state.velocity));
  return fastest;
}

void insert(std::vector<std::size_t>& into, std::size_t trace) {
  const auto place = std::lower_bound(into.begin(), into.end(), trace);
  if (place == into.end() || *place != trace) into.insert(place, trace);
}

}  // namespace

bool same_content(const sync::Bundle& a, const sync::Bundle& b) {
  if (a.tick != b.tick || a.avatar != b.avatar || a.bodies != b.bodies) return false;
  sync::Bundle as_b = a;
  as_b.signature = b.signature;
  return as_b == b;
}

void Ledger::add(std::size_t trace, MemberId author, const sync::Bundle& update, PeerId passed_on_by) {
  std::vector<Version>& versions = all_[{author, update.index}];
  auto v = std::find_if(versions.begin(), versions.end(),
                        [&](const Version& known) { return same_content(known.update, update); });
  if (v == versions.end()) {
    versions.push_back({update, {}, false, passed_on_by});
    v = versions.end() - 1;
    if (const float speed = fastest_in(update); speed > 0) speeds_[update.tick].push_back({author, speed});
  }
  if (!v->update.signature) v->update.signature = update.signature;
  v->direct |= passed_on_by == kNoPeer;
  insert(v->traces, trace);
}

float Ledger::fastest_said(Tick from, Tick to, MemberId but) const {
  float fastest = 0;
  for (auto t = speeds_.lower_bound(from); t != speeds_.end() && t->first <= to; ++t)
    for (const SaidSpeed& s : t->second)
      if (s.by != but) fastest = std::max(fastest, s.speed);
  return fastest;
}

}  // namespace padr::lab::audit
