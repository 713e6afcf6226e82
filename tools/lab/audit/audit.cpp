#include "tools/lab/audit/audit.h"

#include <algorithm>
#include <map>
#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>

#include "common/model/user_error.h"
#include "tools/lab/audit/judge.h"
#include "tools/lab/audit/margins.h"
#include "tools/lab/audit/two_updates.h"
#include "tools/lab/replay.h"

namespace padr::lab::audit {
namespace {

/// Whose hashes the replica has found to differ.
void note_other_worlds(const node::Replica& replica, const Members& members, std::size_t trace,
                       std::vector<OtherWorld>& out) {
  for (PeerId p = 0; p < replica.config().slots; ++p) {
    if (!replica.seat(p).there() || !replica.seat(p).differs) continue;
    const auto who = members.sitter(trace, p, replica.seat(p).incarnation);
    const bool known =
        std::any_of(out.begin(), out.end(), [&](const OtherWorld& o) { return o.who == who && o.trace == trace; });
    if (who && !known) out.push_back({*who, trace, replica.now()});
  }
}

void replay_to(Judge& judge, const TraceText& text, std::size_t number, Report& report) {
  trace::TraceReader reader(text.bytes, text.label);
  const Replay* playing = nullptr;
  Replay replay(reader, [&](const sync::FoldState& s, const sync::LazyHash& /*hash*/) {
    const node::Replica* replica = playing != nullptr ? playing->replica() : nullptr;
    judge.take(s, replica != nullptr ? &replica->agreed().log() : nullptr);
  });
  playing = &replay;
  while (const auto event = replay.next())
    if (std::holds_alternative<trace::Step>(*event))
      note_other_worlds(*replay.replica(), report.evidence.members, number, report.other_worlds);
  if (replay.result().truncated) report.truncated.push_back(text.label);
  if (replay.result().has_rest) report.with_rest.push_back(text.label);
  if (!replay.result().identical())
    throw UserError(text.label + ": does not do again what it did, at " + replay.result().difference +
                    "; padr-lab replay says the same");
}

template <typename T>
auto key_of(const T& t) {
  if constexpr (std::is_same_v<T, Finding>)
    return std::tuple(t.who, t.index, t.body, t.kind);
  else
    return std::tuple(t.who, t.index, t.body);
}

/// What stands in several traces is told once.
template <typename T>
std::vector<T> merged(const std::vector<T>& all) {
  std::map<decltype(key_of(std::declval<T>())), T> by_key;
  for (const T& t : all) {
    const auto [place, fresh] = by_key.try_emplace(key_of(t), t);
    if (fresh) continue;
    std::vector<std::size_t>& traces = place->second.traces;
    traces.insert(traces.end(), t.traces.begin(), t.traces.end());
    std::sort(traces.begin(), traces.end());
    traces.erase(std::unique(traces.begin(), traces.end()), traces.end());
  }
  std::vector<T> out;
  out.reserve(by_key.size());
  for (auto& [key, t] : by_key) out.push_back(std::move(t));
  return out;
}

/// What a trace and its copy say would count twice.
void check_apart(const std::vector<TraceText>& texts) {
  std::vector<trace::Header> seen;
  for (const TraceText& t : texts) {
    const trace::Header h = trace::TraceReader(t.bytes, t.label).header();
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (same_incarnation(seen[i], h))
        throw UserError(t.label + ": is a trace of peer " + std::to_string(h.peer) + ", and so is " + texts[i].label);
    seen.push_back(h);
  }
}

/// Whoever was told two things may have believed the other one.
bool may_be_misled(const Finding& f, const std::vector<Finding>& two) {
  return std::any_of(two.begin(), two.end(), [&f](const Finding& lie) {
    return lie.who != f.who && lie.tick <= f.tick && f.tick - lie.tick <= kMisled;
  });
}

}  // namespace

float severity(const Finding& f) {
  return f.measured / std::max(f.allowed, 0.1F);
}

Report audit(const std::vector<TraceText>& texts, const Options& options) {
  check_apart(texts);
  trace::TraceReader first(texts.front().bytes, texts.front().label);
  const Replay setting(first);  // refuses a trace of another build
  const Limits limits(setting.scene(), first.header().slots);
  Report r{{}, {}, {}, read_evidence(texts, setting.scene()), {}, {}, {}, {}, 0, 0};
  for (const TraceText& t : texts) r.labels.push_back(t.label);
  const std::vector<Finding> two = find_two_updates(r.evidence, r.labels);
  std::vector<Finding> physics;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    Judge judge(r.evidence, i, limits, options.pushes);
    replay_to(judge, texts[i], i, r);
    for (const Finding& f : judge.findings())
      if (!may_be_misled(f, two)) physics.push_back(f);
    r.pushes.insert(r.pushes.end(), judge.pushes().begin(), judge.pushes().end());
    r.judged += judge.judged();
    for (std::size_t k = 0; k < kKinds; ++k) r.closest[k] = nearer(r.closest[k], judge.closest()[k]);
  }
  r.findings = merged(physics);
  r.pushes = merged(r.pushes);
  r.findings.insert(r.findings.end(), two.begin(), two.end());
  std::stable_sort(r.findings.begin(), r.findings.end(), [](const Finding& a, const Finding& b) {
    return std::tuple(a.who, a.kind, !a.is_signed, -severity(a), a.tick) <
           std::tuple(b.who, b.kind, !b.is_signed, -severity(b), b.tick);
  });
  r.updates = r.evidence.ledger.all().size();
  return r;
}

}  // namespace padr::lab::audit
