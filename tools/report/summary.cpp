#include "tools/report/summary.h"

#include <algorithm>
#include <map>

#include "shell/technique_text.h"
#include "shell/text.h"

namespace padr::report {
namespace {

Group group_of(const Report& r, const std::string& technique, const std::vector<std::size_t>& members) {
  Group g;
  g.technique = technique;
  g.peers = members;
  std::vector<trace::InconsistencySeries> series;
  std::vector<trace::FidelitySeries> fidelity;
  for (const std::size_t i : members) {
    const Peer& p = r.peers[i];
    series.push_back(p.series);
    fidelity.push_back(p.fidelity_series);
    g.traffic += p.traffic;
    g.seconds += p.seconds();
  }
  g.inconsistency = trace::summarize_all(series);
  g.fidelity = trace::summarize_all(fidelity);
  return g;
}

void note_missing(Report& r) {
  std::string missing;
  int count = 0;
  for (PeerId p = 0; p < r.peers.front().header.slots; ++p) {
    const bool was_there = p < r.peers_at_start() || std::count(r.heard.begin(), r.heard.end(), p) > 0;
    if (was_there && std::none_of(r.peers.begin(), r.peers.end(), [p](const Peer& x) { return x.header.peer == p; }))
      missing += (count++ == 0 ? " " : ", ") + std::to_string(p);
  }
  if (count == 0) return;
  const std::string whose = count == 1 ? "its" : "their";
  r.notes.push_back("no trace of peer" + (count == 1 ? "" : std::string("s")) + missing + ": " + whose +
                    " entities are measured against the agreed world, and " + whose + " links are left out");
}

void note_ends(Report& r) {
  for (const Peer& p : r.peers)
    if (p.has_rest) r.notes.push_back(p.label + " has something behind its end that is no part of a trace");
  for (const Peer& p : r.peers)
    if (!p.clean)
      r.notes.push_back(p.label + " breaks off at tick " + std::to_string(p.last_tick) +
                        ": the program crashed or is still running");
}

// What the trace's header says of the technique and the network is then true of its beginning only.
void note_interference(Report& r) {
  for (const Peer& p : r.peers)
    if (p.retunes + p.pushes + p.remarks > 0)
      r.notes.push_back("peer " + p.name + " was interfered with while it played: knobs turned " +
                        shell::counted(p.retunes, "time") + ", bodies pushed " + std::to_string(p.pushes) +
                        ", links impaired or cut or the peer paused " + std::to_string(p.remarks) +
                        "; the report names technique and network as they were at the beginning" +
                        (p.technique_last || p.netem_last ? ", and what was changed as it was at last" : "") +
                        (p.technique_last ? "; the figures by technique go by the one at the beginning" : ""));
}

void note_confirmed(Report& r) {
  if (r.peers.size() < 2)
    r.notes.push_back(
        "a single trace: there is nothing to compare its confirmed worlds with, and no view of others to measure the "
        "physics-consistency-cost in");
  for (const Peer& p : r.peers)
    if (!p.superseded && p.last_tick - p.last_confirmed > 10 * kTicksPerSecond)
      r.notes.push_back(p.label + ": its confirmed world is " +
                        std::to_string((p.last_tick - p.last_confirmed) / kTicksPerSecond) + " s behind at the end");
}

}  // namespace

void summarize(Report& r) {
  std::map<std::string, std::vector<std::size_t>> by_technique;
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < r.peers.size(); ++i) {
    by_technique[shell::describe(r.peers[i].header.technique)].push_back(i);
    all.push_back(i);
  }
  for (const auto& [technique, members] : by_technique) r.groups.push_back(group_of(r, technique, members));
  r.overall = group_of(r, by_technique.size() == 1 ? by_technique.begin()->first : "several", all);
  note_missing(r);
  note_ends(r);
  note_interference(r);
  note_confirmed(r);
  if (!r.fidelity_known)
    r.notes.push_back("the traces do not hold the scenario as it was played: fidelity and PCC are not measured");
}

}  // namespace padr::report
