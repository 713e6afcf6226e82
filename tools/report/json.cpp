#include "shell/json.h"
#include "shell/measures_json.h"

#include <algorithm>

#include "common/sync/validation.h"
#include "shell/revision.h"
#include "shell/technique_text.h"
#include "shell/text.h"
#include "tools/report/outputs.h"
#include "tools/report/rates.h"

namespace padr::report {
namespace {

using shell::Json;

void put(Json& j, const trace::Inconsistency& i) {
  j.field("mean_m", i.mean_m).field("avatar_mean_m", i.avatar_mean_m).field("body_mean_m", i.body_mean_m);
  j.field("p95_m", i.p95_m).field("p99_m", i.p99_m).field("peak_m", i.peak_m);
  j.field("area_ms", i.area_ms).field("final_m", i.final_m);
  j.field("shown_mean_m", i.shown_mean_m).field("shown_peak_m", i.shown_peak_m).field("measured_ticks", i.ticks);
}

/// The same names and meanings as in padr-lab's summary; `updates_by_cause` is per second and peer.
void put(Json& j, const Traffic& t, double seconds) {
  const Rates rates = rates_of(t, seconds);
  j.field("updates_per_s", rates.updates_per_s).field("datagrams_per_s", rates.datagrams_per_s);
  j.field("wire_kbps", rates.wire_kbps).field("repeats_per_s", rates.repeats_per_s);
  j.key("updates_by_cause").begin_object();
  for (std::size_t c = 0; c < sync::kCauses; ++c) j.field(sync::kCauseNames[c], per_second(t.updates[c], seconds));
  j.end_object();
  j.key("totals").begin_object();
  j.field("datagrams", t.datagrams).field("wire_bytes", t.wire_bytes).field("updates", t.all_updates());
  j.field("repeats", t.repeats).key("updates_by_cause").begin_object();
  for (std::size_t c = 0; c < sync::kCauses; ++c) j.field(sync::kCauseNames[c], t.updates[c]);
  j.end_object().end_object();
}

void put_provenance(Json& j, const Peer& p) {
  const trace::Header& h = p.header;
  j.key("provenance").begin_object();
  j.field("program", h.program).field("revision", h.revision);
  j.key("command").begin_array();
  for (const std::string& word : h.command) j.value(word);
  j.end_array();
  j.field("scenario", h.scenario).field("scenario_seed", h.scenario_seed);
  j.field("netem", h.netem).field("netem_seed", h.netem_seed).field("input", h.input);
  j.field("start_unix_us", h.start_unix_us).end_object();
}

void put_reasons(Json& j, const std::vector<std::uint64_t>& dropped) {
  j.begin_object();
  for (std::size_t d = 1; d < std::min(dropped.size(), sync::kDropReasons); ++d)
    j.field(sync::kDropNames[d], dropped[d]);
  j.end_object();
}

void put_drops(Json& j, const Peer& p) {
  j.key("dropped");
  if (p.dropped.empty())
    j.null();
  else
    put_reasons(j, p.dropped);
  j.key("drops").begin_array();
  for (const Drops& d : p.drops) {
    j.begin_object().field("of", int{d.of}).field("cut_off", d.cut_offs).key("by_reason");
    put_reasons(j, d.by_reason);
    j.end_object();
  }
  j.end_array();
}

void put_carried(Json& j, const Peer& p) {
  j.key("carried").begin_array();
  for (const Carried& c : p.carried)
    j.begin_object()
        .field("to", int{c.to})
        .field("by", int{c.by})
        .field("from_tick", c.from)
        .field("until_tick", c.until)
        .end_object();
  j.end_array();
}

void put_peer(Json& j, const Report& r, const Peer& p) {
  j.begin_object();
  j.field("peer", p.header.peer).field("name", p.name).field("incarnation", p.header.incarnation);
  j.field("trace", p.label).field("clean_end", p.clean).field("superseded", p.superseded);
  j.field("came_tick", p.came).field("went_tick", p.went());
  j.field("technique", p.header.technique.name).field("knobs", shell::describe(p.header.technique));
  j.field("ticks", p.last_tick)
      .field("left_at_tick", p.left_at)
      .field("seconds", p.seconds())
      .field("confirmed_tick", p.last_confirmed);
  put(j, p.inconsistency);
  if (r.fidelity_known) {
    put(j, p.fidelity);
    if (r.is_seen(p)) put(j, p.pcc);
    j.field("deeds", p.deeds);
  }
  put(j, p.traffic, p.seconds());
  j.field("replay_steps_per_tick", per_tick(p.replayed_steps, p.last_tick - p.first_tick));
  j.field("threshold_mean_m", p.threshold_mean_m);
  j.field("snaps", p.snaps).field("snap_m", p.snap_m);
  if (r.fidelity_known) put(j, p.shown);
  j.field("late_ticks", p.late_ticks).field("worst_lateness_us", p.worst_lateness);
  j.field("damaged_datagrams_received", p.damaged);
  put_drops(j, p);
  put_carried(j, p);
  j.key("interference").begin_object();
  j.field("knobs_turned", p.retunes).field("pushes", p.pushes).field("links_and_pauses", p.remarks);
  if (p.technique_last) j.field("knobs_last", shell::describe(*p.technique_last));
  j.end_object();
  put_provenance(j, p);
  j.end_object();
}

void put_link(Json& j, const Link& l) {
  j.begin_object();
  j.field("from", l.from).field("to", l.to).field("from_name", l.from_name).field("to_name", l.to_name);
  j.field("sent", l.sent).field("received", l.received).field("judged", l.judged).field("lost", l.lost);
  j.field("loss_percent", l.loss_percent()).field("duplicates", l.duplicates).field("reordered", l.reordered);
  j.field("reordered_percent", l.reordered_percent());
  j.field("delay_mean_ms", l.delay_mean_ms).field("delay_p50_ms", l.delay_p50_ms).field("delay_p95_ms", l.delay_p95_ms);
  j.field("jitter_ms", l.jitter_ms).end_object();
}

void put_hand_overs(Json& j, const Report& r) {
  j.field("takeovers", r.hand_overs.takeovers).field("flips", r.hand_overs.flips);
  j.key("takeovers_by_body").begin_array();
  for (const auto& [body, n] : r.hand_overs_by_body)
    j.begin_object().field("body", int{body}).field("takeovers", n.takeovers).field("flips", n.flips).end_object();
  j.end_array();
}

void put_groups(Json& j, const Report& r) {
  j.key("by_technique").begin_array();
  for (const Group& g : r.groups) {
    j.begin_object().field("knobs", g.technique).key("peers").begin_array();
    for (const std::size_t i : g.peers) j.value(r.peers[i].name);
    j.end_array();
    put(j, g.inconsistency);
    if (r.fidelity_known) put(j, g.fidelity);
    put(j, g.traffic, g.seconds);
    j.end_object();
  }
  j.end_array();
}

}  // namespace

std::string json(const Report& r, const std::vector<std::string>& command) {
  const trace::Header& h = r.peers.front().header;
  Json j;
  j.begin_object().field("revision", shell::revision());
  j.key("command").begin_array();
  for (const std::string& word : command) j.value(word);
  j.end_array();
  j.field("scenario", h.scenario).field("scenario_seed", h.scenario_seed).field("scene_hash", shell::hex(h.scene_hash));
  j.field("peers", r.peers_at_start()).field("lives", r.peers.size()).field("session", h.session);
  j.field("noise_m", trace::kNoiseMetres);
  j.key("notes").begin_array();
  for (const std::string& n : r.notes) j.value(n);
  j.end_array();
  j.field("confirmed_ticks", r.confirmed.ticks).field("confirmed_mismatches", r.confirmed.mismatches);
  j.field("first_mismatch_tick", r.confirmed.first_mismatch).field("first_mismatch_peers", r.confirmed.who);
  j.field("given_up_ticks", r.confirmed.given_up).field("given_up_unlike", r.confirmed.given_up_unlike);
  put_hand_overs(j, r);
  put(j, r.overall.inconsistency);
  if (r.fidelity_known) {
    put(j, r.overall.fidelity);
    j.field("fidelity_left_out", r.left_out);
  }
  put(j, r.overall.traffic, r.overall.seconds);
  put_groups(j, r);
  j.key("by_peer").begin_array();
  for (const Peer& p : r.peers) put_peer(j, r, p);
  j.end_array();
  j.key("links").begin_array();
  for (const Link& l : r.links) put_link(j, l);
  j.end_array();
  j.end_object();
  return j.text();
}

}  // namespace padr::report
