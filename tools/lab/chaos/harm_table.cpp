#include "tools/lab/chaos/harm_table.h"

#include <algorithm>

#include "shell/text.h"
#include "tools/lab/chaos/lies.h"

namespace padr::lab {
namespace {

double in_seconds(Micros t) {
  return static_cast<double>(t) / kMicrosPerSecond;
}

std::string tenths(Micros t) {
  return shell::fixed(in_seconds(t), 1);
}

/// Place in the list of --help.
std::ptrdiff_t rank(std::string_view name) {
  const auto all = behaviours();
  return std::find_if(all.begin(), all.end(), [name](const Behaviour& b) { return b.name == name; }) - all.begin();
}

}  // namespace

void HarmTable::add(std::string_view behaviour, const ChaosOutcome& o) {
  auto it = std::find_if(rows_.begin(), rows_.end(), [&](const HarmOfBehaviour& r) { return r.name == behaviour; });
  if (it == rows_.end()) {
    it = std::find_if(rows_.begin(), rows_.end(),
                      [&](const HarmOfBehaviour& r) { return rank(r.name) > rank(behaviour); });
    it = rows_.insert(it, HarmOfBehaviour{behaviour, 0, 0, {}, 0});
  }
  ++it->runs;
  if (!o.violation.empty()) ++it->violations;
  Harm& worst = it->worst;
  worst.unconfirmed = std::max(worst.unconfirmed, o.harm.unconfirmed);
  worst.out = std::max(worst.out, o.harm.out);
  worst.stalled = std::max(worst.stalled, o.harm.stalled);
  worst.evicted += o.harm.evicted;
  worst.evicted_reachable += o.harm.evicted_reachable;
  worst.begun_anew += o.harm.begun_anew;
  worst.kept_out += o.harm.kept_out;
  it->differed = std::max(it->differed, o.differed);
}

std::string HarmTable::text() const {
  if (rows_.empty()) return "";
  shell::Table table({"behaviour", "scripts", "violations", "unconfirmed (s)", "out (s)", "differed (s)", "stalled (s)",
                      "evicted", "begun anew", "kept out"});
  for (const HarmOfBehaviour& r : rows_)
    table.row({std::string(r.name), std::to_string(r.runs), std::to_string(r.violations), tenths(r.worst.unconfirmed),
               tenths(r.worst.out), tenths(r.differed), tenths(r.worst.stalled), std::to_string(r.worst.evicted),
               std::to_string(r.worst.begun_anew), std::to_string(r.worst.kept_out)});
  return "Harm to the honest: the longest times, and how often\n" + table.text();
}

void tell_harm(const Harm& harm, Micros differed, shell::Json& j) {
  j.field("unconfirmed_s", in_seconds(harm.unconfirmed)).field("out_s", in_seconds(harm.out));
  j.field("differed_s", in_seconds(differed)).field("stalled_s", in_seconds(harm.stalled));
  j.field("evicted", harm.evicted).field("evicted_reachable", harm.evicted_reachable);
  j.field("begun_anew", harm.begun_anew).field("kept_out", harm.kept_out);
}

void HarmTable::tell(shell::Json& j) const {
  j.begin_array();
  for (const HarmOfBehaviour& r : rows_) {
    j.begin_object().field("name", r.name).field("runs", r.runs).field("violations", r.violations);
    tell_harm(r.worst, r.differed, j);
    j.end_object();
  }
  j.end_array();
}

}  // namespace padr::lab
