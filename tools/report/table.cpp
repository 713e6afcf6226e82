#include <algorithm>
#include <map>

#include "common/sync/validation.h"
#include "shell/technique_text.h"
#include "shell/text.h"
#include "tools/report/outputs.h"
#include "tools/report/rates.h"

namespace padr::report {
namespace {

using shell::fixed;
using shell::Table;

// Nobody reads a longer table of links.
constexpr std::size_t kMostLinks = 30;

std::string count(std::uint64_t n) {
  return std::to_string(n);
}

std::vector<std::string> inconsistency_row(const std::string& name, const trace::Inconsistency& i) {
  std::vector<std::string> row{name};
  for (const double v : {i.mean_m, i.avatar_mean_m, i.body_mean_m, i.p95_m, i.p99_m, i.peak_m, i.final_m})
    row.push_back(fixed(v, 3));
  row.push_back(fixed(i.area_ms, 2));
  row.push_back(fixed(i.shown_mean_m, 3));
  row.push_back(fixed(i.shown_peak_m, 3));
  return row;
}

std::vector<std::string> fidelity_row(const std::string& name, const trace::Fidelity& f) {
  std::vector<std::string> row{name};
  for (const double v : {f.mean_m, f.own_mean_m, f.others_mean_m, f.nobody_mean_m, f.p95_m, f.peak_m})
    row.push_back(fixed(v, 3));
  return row;
}

std::vector<std::string> traffic_row(const std::string& name, const Traffic& t, double seconds) {
  const Rates rates = rates_of(t, seconds);
  std::vector<std::string> row{name, fixed(rates.updates_per_s, 2), fixed(rates.datagrams_per_s, 1),
                               fixed(rates.wire_kbps, 2)};
  for (const std::uint64_t n : t.updates) row.push_back(count(n));
  row.push_back(count(t.repeats));
  return row;
}

/// One row per peer, per technique if there are several, and overall.
template <typename Row>
void rows(Table& table, const Report& r, Row row) {
  for (const Peer& p : r.peers) {
    Group alone;
    alone.inconsistency = p.inconsistency;
    alone.fidelity = p.fidelity;
    alone.traffic = p.traffic;
    alone.seconds = p.seconds();
    table.row(row("peer " + p.name, alone));
  }
  if (r.groups.size() > 1)
    for (std::size_t g = 0; g < r.groups.size(); ++g)
      table.row(row("technique " + std::string(1, static_cast<char>('A' + g % 26)), r.groups[g]));
  if (r.peers.size() > 1) table.row(row("overall", r.overall));
}

/// s, from the begin of play
double length_of(const Report& r) {
  Tick begin = r.peers.front().came;
  Tick end = 0;
  for (const Peer& p : r.peers) {
    begin = std::min(begin, p.came);
    end = std::max(end, p.went());
  }
  return static_cast<double>(end - begin) / kTicksPerSecond;
}

bool comings_and_goings(const Report& r) {
  return std::any_of(r.peers.begin(), r.peers.end(), [&r](const Peer& p) { return r.came_later(p); });
}

std::string people(const Report& r) {
  const auto watching = std::count_if(r.peers.begin(), r.peers.end(), [](const Peer& p) { return p.header.spectates; });
  const auto later = std::count_if(r.peers.begin(), r.peers.end(),
                                   [&r](const Peer& p) { return !p.header.spectates && r.came_later(p); });
  std::string s = shell::counted(r.peers_at_start(), "peer");
  if (later > 0) s += " at the start, " + shell::counted(later, "trace") + " of who came later";
  if (watching > 0) s += ", " + shell::counted(watching, "trace") + " of who only watched";
  return s;
}

std::string heading(const Report& r) {
  const trace::Header& h = r.peers.front().header;
  std::string s = "Session " + std::to_string(h.session) + ": " + h.scenario + " (seed " +
                  std::to_string(h.scenario_seed) + "), " + std::to_string(h.bodies) + " bodies, " + people(r) + ", " +
                  fixed(length_of(r), 1) + " s\n";
  const bool retuned = std::any_of(r.peers.begin(), r.peers.end(), [](const Peer& p) { return p.technique_last; });
  for (std::size_t g = 0; g < r.groups.size(); ++g) {
    s += r.groups.size() > 1 ? "Technique " + std::string(1, static_cast<char>('A' + g % 26)) : "Technique";
    s += std::string(retuned ? " at the beginning" : "") + ": " + r.groups[g].technique + "\n";
    if (r.groups.size() == 1) continue;
    s += "  peers";
    for (const std::size_t i : r.groups[g].peers) s += " " + r.peers[i].name;
    s += "\n";
  }
  for (const Peer& p : r.peers)
    if (p.technique_last)
      s += "Technique of peer " + p.name + ", changed while it played, at last: " + shell::describe(*p.technique_last) +
           "\n";
  std::map<std::string, std::string> netems;  // and whose they are
  for (const Peer& p : r.peers) {
    std::string& who = netems[p.header.netem];
    who += (who.empty() ? " of peer " : ", ") + p.name;
  }
  const bool changed = std::any_of(r.peers.begin(), r.peers.end(), [](const Peer& p) { return p.netem_last; });
  for (const auto& [netem, who] : netems)
    s += "Network" + (netems.size() > 1 ? who : "") + (changed ? " at the beginning" : "") + ": " +
         (netem.empty() ? "not shaped by the peers" : netem) + "\n";
  for (const Peer& p : r.peers)
    if (p.netem_last) s += "Network of peer " + p.name + ", changed while it played, at last: " + *p.netem_last + "\n";
  return s;
}

std::string fidelity_table(const Report& r) {
  if (!r.fidelity_known) return "";
  Table f({"fidelity error", "mean m", "own m", "others m", "nobody's m", "p95 m", "peak m"});
  rows(f, r, [](const std::string& name, const Group& g) { return fidelity_row(name, g.fidelity); });
  Table c({"physics-consistency-cost", "mean m", "peak m", "mean bodies", "most bodies", "deeds"});
  bool any = false;
  for (const Peer& p : r.peers) {
    if (!r.is_seen(p)) continue;
    any = true;
    c.row({"avatar " + p.name, fixed(p.pcc.mean_m, 3), fixed(p.pcc.peak_m, 3), fixed(p.pcc.bodies_mean, 2),
           std::to_string(p.pcc.bodies_peak), count(p.deeds)});
  }
  return "\nFidelity error: distance between bodies and the result of the players' deeds alone, summed, by whose "
         "deeds.\n"
         "Left out are bodies that several players shared: " +
         fixed(100 * r.left_out, 1) + " % of body time (docs/metrics.md).\n" + f.text() +
         (any ? "\nPhysics-consistency-cost: error of the bodies that the avatar disturbed, in others' views; bodies: "
                "off by over 5 cm.\n" +
                    c.text()
              : "");
}

std::string links_table(const Report& r) {
  if (r.links.empty()) return "";
  std::vector<Link> links = r.links;
  std::string which = "Links";
  if (links.size() > kMostLinks) {
    std::stable_sort(links.begin(), links.end(),
                     [](const Link& a, const Link& b) { return a.loss_percent() > b.loss_percent(); });
    links.resize(kMostLinks);
    which = "Links: of " + count(r.links.size()) + " the " + count(kMostLinks) +
            " with the highest loss (--csv and --json have all)";
  }
  Table g({"link", "sent", "received", "lost", "of", "loss %", "duplicates", "reordered %", "delay mean ms", "p50 ms",
           "p95 ms", "jitter ms"});
  for (const Link& l : links)
    g.row({l.from_name + " -> " + l.to_name, count(l.sent), count(l.received), count(l.lost), count(l.judged),
           fixed(l.loss_percent(), 2), count(l.duplicates), fixed(l.reordered_percent(), 2),
           shell::fixed_or_dash(l.delay_mean_ms, 1), shell::fixed_or_dash(l.delay_p50_ms, 1),
           shell::fixed_or_dash(l.delay_p95_ms, 1), shell::fixed_or_dash(l.jitter_ms, 1)});
  return "\n" + which +
         ". Column `of`: the datagrams that were sent at least 1 s before the end of the receiver's trace. Lost: those "
         "of\n"
         "them that are not in that trace. Delay: from the start of the sending tick (sender's session clock) until "
         "arrival\n"
         "(receiver's session clock).\n" +
         g.text();
}

std::string peers_table(const Report& r) {
  Table g({"peer", "ticks", "confirmed to", "late ticks", "worst ms", "replayed steps/tick", "mean threshold m",
           "snaps", "snap m", "damaged in"});
  for (const Peer& p : r.peers)
    g.row({"peer " + p.name, std::to_string(p.last_tick), std::to_string(p.last_confirmed), count(p.late_ticks),
           fixed(static_cast<double>(p.worst_lateness) / 1000, 1),
           fixed(per_tick(p.replayed_steps, p.last_tick - p.first_tick), 2), fixed(p.threshold_mean_m, 3),
           count(p.snaps), fixed(p.snap_m, 2), count(p.damaged)});
  return "\nPeers. Late: begun more than a tick (16.7 ms) after its time. Snap: shown position jumped by over 3 cm.\n" +
         g.text();
}

std::vector<std::string> shown_row(const std::string& name, const trace::ShownMotion& s) {
  return {name,
          fixed(s.stride_change_m_per_s(), 2),
          fixed(s.unexplained_m_per_s(), 2),
          count(s.stops),
          fixed(s.overshoot_mean_m(), 3),
          fixed(s.overshoot_peak_m, 3),
          fixed(s.overlap_mean_m(), 4),
          fixed(s.overlap_made_mean_m(), 4),
          fixed(s.overlap_peak_m, 3),
          fixed(s.freezes_per_s(), 2),
          fixed(s.longest_freeze_s(), 2)};
}

std::string shown_table(const Report& r) {
  if (!r.fidelity_known) return "";
  Table g({"shown", "steps change m/s", "unexplained", "stops", "overshot mean m", "peak m", "overlap mean m", "made m",
           "peak m", "freezes/s", "longest s"});
  trace::ShownMotion all;
  for (const Peer& p : r.peers) {
    g.row(shown_row("peer " + p.name, p.shown));
    all.add(p.shown);
  }
  if (r.peers.size() > 1) g.row(shown_row("overall", all));
  return "\nHow shown positions move (docs/metrics.md). Unexplained: not by velocities. Overlap: beyond that of the "
         "live\nworld. Made: by showing.\n" +
         g.text();
}

/// What is said twice or late is nobody's fault.
bool is_network(std::size_t why) {
  return why == static_cast<std::size_t>(sync::DropReason::kDuplicate) ||
         why == static_cast<std::size_t>(sync::DropReason::kForeign);
}

/// Only where there is something besides what any network does.
std::string drops_table(const Report& r) {
  Table g({"at", "of", "cut off", "dropped by reason"});
  bool any = false;
  for (const Peer& p : r.peers)
    for (const Drops& d : p.drops) {
      std::string reasons;
      bool blamed = d.cut_offs > 0;
      for (std::size_t why = 1; why < std::min(d.by_reason.size(), sync::kDropReasons); ++why) {
        if (d.by_reason[why] == 0) continue;
        reasons += (reasons.empty() ? "" : ", ") + count(d.by_reason[why]) + " " + std::string(sync::kDropNames[why]);
        blamed = blamed || !is_network(why);
      }
      if (!blamed) continue;
      any = true;
      g.row({"peer " + p.name, "slot " + std::to_string(d.of), d.cut_offs == 0 ? "-" : count(d.cut_offs),
             reasons.empty() ? "not told" : reasons});
    }
  return any ? "\nDatagrams dropped for their content, and peers cut off, for ever or for a while.\n" + g.text() : "";
}

std::string in_seconds(Tick t) {
  return fixed(static_cast<double>(t) / kTicksPerSecond, 2);
}

std::string carried_table(const Report& r) {
  Table g({"from", "to", "by", "from s", "to s"});
  bool any = false;
  for (const Peer& p : r.peers)
    for (const Carried& c : p.carried) {
      any = true;
      g.row({"peer " + p.name, "slot " + std::to_string(c.to), "slot " + std::to_string(c.by), in_seconds(c.from),
             in_seconds(c.until)});
    }
  return any ? "\nLinks that did not work, and who carried for them.\n" + g.text() : "";
}

std::string lives_table(const Report& r) {
  if (!comings_and_goings(r)) return "";
  Table g({"who", "came s", "went s", "how", "trace"});
  for (const Peer& p : r.peers) {
    const char* how = p.left_at >= 0 ? "left" : p.superseded ? "began anew" : p.clean ? "ended" : "broke off";
    g.row({"peer " + p.name, in_seconds(p.came), in_seconds(p.went()), how, p.label});
  }
  return "\nWho came and went.\n" + g.text();
}

std::string hand_overs_line(const Report& r) {
  return "\nAuthority: bodies were taken over from another peer " + count(r.hand_overs.takeovers) + " times, " +
         count(r.hand_overs.flips) + " of them flips (within a second of the last).\n";
}

std::string verdict(const Report& r) {
  const ConfirmedCheck& c = r.confirmed;
  if (r.peers.size() < 2) return "";
  std::string given_up;
  if (c.given_up > 0)
    given_up = " Of " + count(c.given_up) + " worlds of peers that were declared gone later, " +
               count(c.given_up_unlike) + " differ from the session's.";
  if (c.mismatches == 0 && c.ticks == 0)
    return "\nConfirmed worlds: not compared, as no tick was confirmed by two peers or more that stayed together." +
           given_up + "\n";
  if (c.mismatches == 0)
    return "\nConfirmed worlds: identical at all " + count(c.ticks) + " ticks compared." + given_up + "\n";
  return "\nCONFIRMED WORLDS DIFFER at " + count(c.mismatches) + " of " + count(c.ticks) + " ticks, first at tick " +
         std::to_string(c.first_mismatch) + " (" + fixed(static_cast<double>(c.first_mismatch) / kTicksPerSecond, 2) +
         " s): " + c.who + "\n";
}

}  // namespace

std::string table(const Report& r) {
  std::string s = heading(r);
  Table inconsistency({"inconsistency", "mean m", "avatars m", "bodies m", "p95 m", "p99 m", "peak m", "final m",
                       "area m*s", "shown mean m", "shown peak m"});
  rows(inconsistency, r,
       [](const std::string& name, const Group& g) { return inconsistency_row(name, g.inconsistency); });
  s += "\nCombined inconsistency, all entities summed; below about 5 mm it is noise.\n" + inconsistency.text();
  s += fidelity_table(r);
  std::vector<std::string> causes{"traffic", "updates/s", "datagrams/s", "kbit/s"};
  causes.insert(causes.end(), sync::kCauseNames.begin(), sync::kCauseNames.end());
  causes.emplace_back("repeats");
  Table traffic(causes);
  rows(traffic, r, [](const std::string& name, const Group& g) { return traffic_row(name, g.traffic, g.seconds); });
  s +=
      "\nTraffic until the peer leaves. Rates of a peer, with IPv4 and UDP headers; then entity updates by cause, each "
      "counted once.\n" +
      traffic.text();
  s += links_table(r) + peers_table(r) + shown_table(r) + drops_table(r) + carried_table(r) + lives_table(r) +
       hand_overs_line(r);
  for (const std::string& n : r.notes) s += "\nNote: " + n + "\n";
  return s + verdict(r);
}

}  // namespace padr::report
