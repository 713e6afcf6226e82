#include "tools/lab/run_summary.h"

#include <fmt/printf.h>

#include <algorithm>

#include "common/model/hash.h"
#include "shell/command_line.h"
#include "shell/json.h"
#include "shell/measures_json.h"
#include "shell/revision.h"
#include "shell/technique_text.h"
#include "tools/lab/rates.h"

namespace padr::lab {
namespace {

using shell::Json;

void put(Json& j, const trace::Inconsistency& i) {
  j.field("mean_m", i.mean_m).field("avatar_mean_m", i.avatar_mean_m).field("body_mean_m", i.body_mean_m);
  j.field("p95_m", i.p95_m).field("p99_m", i.p99_m).field("peak_m", i.peak_m).field("final_m", i.final_m);
  j.field("area_ms", i.area_ms).field("shown_mean_m", i.shown_mean_m).field("shown_peak_m", i.shown_peak_m);
}

void put(Json& j, const Rates& r) {
  j.field("updates_per_s", r.updates).field("datagrams_per_s", r.datagrams).field("wire_kbps", r.kbps);
  j.field("repeats_per_s", r.repeats);
  j.key("updates_by_cause").begin_object();
  for (std::size_t c = 0; c < sync::kCauses; ++c) j.field(sync::kCauseNames[c], r.by_cause[c]);
  j.end_object();
  j.field("snaps_per_s", r.snaps).field("snap_m_per_s", r.snap_m).field("snap_peak_m", r.snap_peak_m);
  put(j, r.shown);
  j.field("replay_steps_per_tick", r.replay_steps_per_tick);
  j.field("lookahead_steps_per_tick", r.lookahead_steps_per_tick).field("lookahead_share", r.lookahead_share());
}

void put(Json& j, const trace::FlipMeter& m) {
  j.field("takeovers", m.all().takeovers).field("flips", m.all().flips);
  j.key("takeovers_by_body").begin_array();
  for (const auto& [body, n] : m.by_body())
    j.begin_object().field("body", int{body}).field("takeovers", n.takeovers).field("flips", n.flips).end_object();
  j.end_array();
}

/// What of authority passed from hand to hand; the body that did so most is named.
std::string authority_line(const trace::FlipMeter& m) {
  if (m.all().takeovers == 0) return "authority: no body was taken over from another peer\n";
  const auto most = std::max_element(m.by_body().begin(), m.by_body().end(), [](const auto& a, const auto& b) {
    return a.second.takeovers < b.second.takeovers;
  });
  return fmt::sprintf(
      "authority: %llu takeovers, %llu flips (within a second of the last); most often body %d: %llu, %llu\n",
      static_cast<unsigned long long>(m.all().takeovers), static_cast<unsigned long long>(m.all().flips),
      int{most->first}, static_cast<unsigned long long>(most->second.takeovers),
      static_cast<unsigned long long>(most->second.flips));
}

/// Whether views, or the one that counts, show what the players did, and what each avatar's model error cost.
std::string fidelity_table(const trace::FidelityMeter& m, int peers, std::optional<PeerId> watched) {
  std::string out =
      "\n       fidelity error (m)                                         physics-consistency-cost (m)\n";
  out += "peer    mean    own   others  nobody    p95   peak  deeds          mean   peak  bodies  most\n";
  const auto left = [&out](const char* name, const trace::Fidelity& f) {
    out += fmt::sprintf("%-6s %5.3f  %5.3f    %5.3f   %5.3f  %5.2f  %5.2f", name, f.mean_m, f.own_mean_m,
                        f.others_mean_m, f.nobody_mean_m, f.p95_m, f.peak_m);
  };
  for (PeerId p = 0; p < peers; ++p) {
    if (watched && p != *watched) continue;
    left(std::to_string(p).c_str(), m.result(p));
    const trace::Pcc c = m.pcc().result(p);
    out += fmt::sprintf("  %5llu         %5.3f  %5.2f   %5.2f  %4d\n", static_cast<unsigned long long>(m.deeds(p)),
                        c.mean_m, c.peak_m, c.bodies_mean, c.bodies_peak);
  }
  if (!watched) {
    left("all", m.overall());
    out += "\n";
  }
  if (watched) out += fmt::sprintf("physics-consistency-cost: of avatar %d's model, in the others' views\n", *watched);
  return out +
         fmt::sprintf("bodies that several players had to do with are left out of fidelity: %.1f %% of the time\n",
                      100 * m.left_out());
}

/// Of all views, or of the one that counts.
trace::Inconsistency overall(const Simulation& s, const RunFacts& f) {
  return f.watched ? trace::summarize(s.seen_with_input(*f.watched)) : s.meter().overall();
}

/// What viewers see of corrections.
std::string shown_lines(const trace::Inconsistency& i, const Rates& r) {
  const trace::ShownMotion& m = r.shown;
  return fmt::sprintf(
             "shown: inconsistency %.3f m, snaps (jumps by over 3 cm) %.2f/s a peer of %.3f m, the largest %.2f m\n",
             i.shown_mean_m, r.snaps, r.snaps > 0 ? r.snap_m / r.snaps : 0.0, r.snap_peak_m) +
         fmt::sprintf(
             "  steps change by %.2f m/s, %.2f of that unexplained; %llu stops overshot by %.3f m, at most %.3f;\n"
             "  overlap beyond the live world's %.4f m, %.4f of that made by showing; freezes %.2f/s\n",
             m.stride_change_m_per_s(), m.unexplained_m_per_s(), static_cast<unsigned long long>(m.stops),
             m.overshoot_mean_m(), m.overshoot_peak_m, m.overlap_mean_m(), m.overlap_made_mean_m(), m.freezes_per_s());
}

}  // namespace

std::string json_summary(const Simulation& s, const RunFacts& f) {
  Json j;
  const double virtual_seconds = static_cast<double>(s.now()) / kTicksPerSecond;
  j.begin_object().field("program", "padr-lab").field("revision", shell::revision());
  j.field("command", shell::shell_line(f.command)).field("seed", f.seed).field("netem_seed", f.netem_seed);
  j.field("scenario", f.scenario).field("peers", s.peers()).field("technique", shell::describe(f.technique));
  j.field("netem", f.netem).field("seconds", virtual_seconds);
  put(j, overall(s, f));
  if (f.watched) j.field("watched_peer", int{*f.watched});
  if (s.fidelity() != nullptr) {
    put(j, f.watched ? s.fidelity()->result(*f.watched) : s.fidelity()->overall());
    j.field("fidelity_left_out", s.fidelity()->left_out());
  }
  put(j, rates_of(s, 0, s.peers()));
  j.field("confirmed_ticks", s.confirmed_ticks()).field("confirmed_mismatches", s.confirmed_mismatches());
  j.field("confirmed_hash", hex(s.last_confirmed_hash()));
  put(j, s.flips());
  if (s.first_mismatch() >= 0) j.field("first_mismatch_tick", s.first_mismatch());
  j.field("realtime_factor", virtual_seconds / f.wall_seconds);
  j.key("by_peer").begin_array();
  for (PeerId p = 0; p < s.peers(); ++p) {
    j.begin_object().field("peer", int{p}).field("input", f.inputs[p % f.inputs.size()]);
    put(j, s.meter().result(p));
    if (s.fidelity() != nullptr) {
      put(j, s.fidelity()->result(p));
      put(j, s.fidelity()->pcc().result(p));
      j.field("deeds", s.fidelity()->deeds(p));
    }
    put(j, rates_of(s, p, 1));
    j.field("contests_lost", s.replica(p).reporter().contests_lost());
    j.field("snaps", s.replica(p).shown().snaps()).field("snap_m", s.replica(p).shown().snap_metres());
    j.end_object();
  }
  return j.end_array().end_object().text();
}

std::string table_summary(const Simulation& s, const RunFacts& f) {
  std::string out = fmt::sprintf("%s, %d peers, %.0f s, seed %llu, netem \"%s\"\n", f.scenario.c_str(), s.peers(),
                                 static_cast<double>(s.now()) / kTicksPerSecond,
                                 static_cast<unsigned long long>(f.seed), f.netem.c_str());
  out += shell::describe(f.technique) + "\n\n";
  out += "       combined inconsistency (m)                    per second      wire   replayed    ahead\n";
  out += "peer    mean  avatars  bodies    p95    p99   peak   updates  dgrams  kbit/s  steps/tick  share\n";
  const auto row = [&out](const char* name, const trace::Inconsistency& i, const Rates& r) {
    out +=
        fmt::sprintf("%-6s %5.3f    %5.3f   %5.3f  %5.2f  %5.2f  %5.2f    %6.2f  %6.1f  %6.1f      %6.2f  %3.0f %%\n",
                     name, i.mean_m, i.avatar_mean_m, i.body_mean_m, i.p95_m, i.p99_m, i.peak_m, r.updates, r.datagrams,
                     r.kbps, r.replay_steps_per_tick, 100 * r.lookahead_share());
  };
  if (f.watched) {
    row(std::to_string(*f.watched).c_str(), overall(s, f), rates_of(s, 0, s.peers()));
  } else {
    for (PeerId p = 0; p < s.peers(); ++p) row(std::to_string(p).c_str(), s.meter().result(p), rates_of(s, p, 1));
    row("all", overall(s, f), rates_of(s, 0, s.peers()));
  }
  if (s.fidelity() != nullptr) out += fidelity_table(*s.fidelity(), s.peers(), f.watched);
  out += fmt::sprintf("\nconfirmed worlds: %llu ticks compared, %llu differ%s\n",
                      static_cast<unsigned long long>(s.confirmed_ticks()),
                      static_cast<unsigned long long>(s.confirmed_mismatches()),
                      s.confirmed_mismatches() == 0 ? "" : " - THEY MUST NOT");
  if (f.watched) out += "inconsistency: what this peer sees while there is input; updates and bytes: of all peers\n";
  out += shown_lines(overall(s, f), rates_of(s, 0, s.peers()));
  out += authority_line(s.flips());
  out += fmt::sprintf("below %.0f mm inconsistency is noise; %.0f times real time\n", trace::kNoiseMetres * 1000,
                      static_cast<double>(s.now()) / kTicksPerSecond / f.wall_seconds);
  return out;
}

std::string csv_series(const Simulation& s) {
  const trace::FidelityMeter* deeds = s.fidelity();
  std::string out = "tick,peer,avatars_m,bodies_m,combined_m,shown_m";
  out += deeds != nullptr ? ",fidelity_m,pcc_m,pcc_bodies\n" : "\n";
  for (PeerId p = 0; p < s.peers(); ++p)
    for (const trace::InconsistencyPoint& i : s.meter().series(p)) {
      out += fmt::sprintf("%d,%d,%.6g,%.6g,%.6g,%.6g", i.tick, int{p}, static_cast<double>(i.avatars_m),
                          static_cast<double>(i.bodies_m), static_cast<double>(i.combined()),
                          static_cast<double>(i.shown_m));
      if (deeds != nullptr) {
        const auto tick = static_cast<std::size_t>(i.tick);
        const trace::PccPoint& cost = deeds->pcc().series(p)[tick];
        out += fmt::sprintf(",%.6g,%.6g,%d", static_cast<double>(deeds->series(p)[tick].error_m()),
                            static_cast<double>(cost.cost_m), int{cost.bodies});
      }
      out += "\n";
    }
  return out;
}

}  // namespace padr::lab
