#include "tools/lab/audit/two_updates.h"

#include <algorithm>
#include <optional>

#include "shell/text.h"

namespace padr::lab::audit {
namespace {

std::string place(Vec2 p) {
  return "(" + shell::fixed(static_cast<double>(p.x), 2) + ", " + shell::fixed(static_cast<double>(p.y), 2) + ")";
}

/// How far apart the two versions have something, and what.
struct Difference {
  float metres = 0;
  EntityId body = kNoEntity;
  std::string what;
};

Difference of_bodies(const sync::Bundle& a, const sync::Bundle& b) {
  Difference d{0, kNoEntity, "bodies"};
  for (const sync::BodyUpdate& u : a.bodies) {
    const auto other = std::find_if(b.bodies.begin(), b.bodies.end(), [&u](const auto& o) { return o.body == u.body; });
    if (other == b.bodies.end() || !u.has_state || !other->has_state) continue;
    const float apart = distance(u.state.position, other->state.position);
    if (u == *other || (d.body != kNoEntity && apart <= d.metres)) continue;
    d = {apart, u.body,
         "body " + std::to_string(u.body) + " at " + place(u.state.position) + " and at " +
             place(other->state.position)};
  }
  return d;
}

Difference difference(const sync::Bundle& a, const sync::Bundle& b) {
  if (a.tick != b.tick) return {0, kNoEntity, "ticks " + std::to_string(a.tick) + " and " + std::to_string(b.tick)};
  if (a.avatar && b.avatar && a.avatar->position != b.avatar->position)
    return {distance(a.avatar->position, b.avatar->position), kNoEntity,
            "avatar at " + place(a.avatar->position) + " and at " + place(b.avatar->position)};
  if (a.bodies != b.bodies) return of_bodies(a, b);
  return {0, kNoEntity, a.avatar != b.avatar ? "another motion of the avatar" : "another order"};
}

std::string where(const Version& v, const std::vector<std::string>& labels) {
  return "in " + labels[v.traces.front()] +
         (v.traces.size() > 1 ? " and " + std::to_string(v.traces.size() - 1) + " more" : "");
}

struct Judged {
  const Version* version;
  bool is_signed;
};

Finding finding_of(Ledger::Key key, const Judged& a, const Judged& b, const std::vector<std::string>& labels) {
  const Difference d = difference(a.version->update, b.version->update);
  Finding f;
  f.kind = Kind::kTwoUpdates;
  f.who = key.first;
  f.index = key.second;
  f.tick = std::min(a.version->update.tick, b.version->update.tick);
  f.body = d.body;
  f.measured = d.metres;
  f.is_signed = a.is_signed && b.is_signed;
  for (const Judged& j : {a, b}) {
    f.traces.insert(f.traces.end(), j.version->traces.begin(), j.version->traces.end());
    if (!j.version->direct && !j.is_signed) f.passed_on_by = j.version->passed_on_by;
  }
  std::sort(f.traces.begin(), f.traces.end());
  f.traces.erase(std::unique(f.traces.begin(), f.traces.end()), f.traces.end());
  f.what = d.what + ", " + where(*a.version, labels) + " and " + where(*b.version, labels);
  return f;
}

}  // namespace

std::vector<Finding> find_two_updates(const Evidence& evidence, const std::vector<std::string>& labels) {
  std::vector<Finding> found;
  for (const auto& [key, versions] : evidence.ledger.all()) {
    if (versions.size() < 2) continue;
    const bool may_be_proven = evidence.session() != SessionId{} && evidence.members[key.first].has_key();
    std::vector<Judged> count;
    for (const Version& v : versions) {
      const bool is_signed = evidence.is_signed(key.first, v.update);
      if (is_signed || v.direct || !may_be_proven) count.push_back({&v, is_signed});
    }
    std::stable_sort(count.begin(), count.end(),
                     [](const Judged& a, const Judged& b) { return a.is_signed > b.is_signed; });
    if (count.size() >= 2) found.push_back(finding_of(key, count[0], count[1], labels));
  }
  return found;
}

}  // namespace padr::lab::audit
