#include "peer/crowd_summary.h"

#include <algorithm>

#include "shell/command_line.h"
#include "shell/json.h"
#include "shell/netem_text.h"
#include "shell/revision.h"
#include "shell/technique_text.h"
#include "shell/text.h"

namespace padr::peer {
namespace {

using shell::Json;

std::string name_of(crowd::Region r) {
  return std::to_string(r.x) + "," + std::to_string(r.y);
}

void put_crowd_origin(Json& j, const CrowdReport& r) {
  const Options& o = r.options;
  j.field("program", "padr-peer").field("version", shell::version()).field("revision", shell::revision());
  j.field("command", shell::shell_line(o.command));
  j.field("seed", o.crowd->plane.seed).field("region_side_m", static_cast<double>(o.crowd->plane.side));
  j.field("technique", shell::describe(o.technique)).field("input", o.input);
  j.field("netem", shell::to_string(o.netem)).field("netem_seed", o.netem_seed);
  j.field("exit_code", r.exit_code).field("reason", r.reason).field("listen", to_string(r.local));
}

void put_finding(Json& j, const crowd::Finder& f) {
  const crowd::FinderStats& s = f.stats();
  j.key("finding").begin_object();
  j.field("asks", s.asks).field("tells", s.tells).field("wire_bytes", s.bytes).field("known", f.acquaintances());
  j.key("dropped").begin_object();
  j.field("malformed", s.malformed).field("strange", s.strange).field("too_many", s.unanswered);
  j.end_object().end_object();
}

void put_regions(Json& j, const CrowdRecord& r) {
  j.key("regions").begin_array();
  for (const CrowdRecord::Place& p : r.places) {
    j.begin_object().field("region", name_of(p.region)).field("slot", p.slot).field("incarnation", p.incarnation);
    j.field("confirmed_tick", p.confirmed).field("checks", p.checks).field("mismatches", p.mismatches);
    j.key("others").begin_array();
    for (const Endpoint& other : p.others) j.value(to_string(other));
    j.end_array().end_object();
  }
  j.end_array();
}

void put_checkpoints(Json& j, const CrowdRecord& r) {
  j.key("checkpoints").begin_object();
  for (const auto& [region, ticks] : r.checkpoints) {
    j.key(name_of(region)).begin_object();
    for (const auto& [tick, hash] : ticks) j.field(std::to_string(tick), shell::hex(hash));
    j.end_object();
  }
  j.end_object();
}

void put_crowd_play(Json& j, const CrowdRecord& r, const crowd::CrowdPeer& peer) {
  const crowd::CrowdStats& s = peer.stats();
  j.field("first_tick", r.first_tick).field("last_tick", r.last_tick);
  j.field("join_ms", static_cast<double>(r.joined_at) / 1e3);
  j.field("home", name_of(r.home));
  j.key("position_m").begin_array();
  j.value(static_cast<double>(r.position.x)).value(static_cast<double>(r.position.y)).end_array();
  j.field("handovers", s.handovers).field("entered", s.entered).field("founded", s.founded).field("failed", s.failed);
  j.field("merged", s.merged).field("ticks_not_in_yet", s.late).field("region_ticks", s.node_ticks);
  j.field("bodies_in", peer.handover().entries()).field("bodies_out", peer.handover().exits());
  j.key("sent").begin_object();
  j.field("updates", peer.updates()).field("datagrams", s.datagrams).field("wire_bytes", s.wire_bytes).end_object();
  j.field("late_ticks", r.late).field("worst_late_ms", static_cast<double>(r.lateness.worst()) / 1e3);
  put_regions(j, r);
  put_checkpoints(j, r);
}

}  // namespace

void CrowdRecord::confirm(crowd::Region r, Tick tick, std::uint64_t hash) {
  if (tick % kTicksPerSecond != 0 || (checkpoints.size() >= kRegions && !checkpoints.contains(r))) return;
  auto& ticks = checkpoints[r];
  ticks[tick] = hash;
  if (ticks.size() > kCheckpoints) ticks.erase(ticks.begin());
}

void CrowdRecord::look(const crowd::CrowdPeer& peer) {
  last_tick = peer.now();
  home = peer.home();
  position = peer.avatar().position;
  places.clear();
  for (const crowd::Post& post : peer.posts()) {
    const node::Replica& n = post.peer->replica();
    Place& p = places.emplace_back();
    p.region = post.region;
    p.slot = n.self();
    p.incarnation = n.config().incarnation;
    p.confirmed = n.agreed().confirmed().tick;
    p.checks = n.stats().hash_checks;
    p.mismatches = n.stats().hash_mismatches;
    for (PeerId other = 0; other < n.config().slots; ++other)
      if (other != n.self() && n.seat(other).there()) p.others.push_back(n.seat(other).at);
  }
}

std::string summary(const CrowdReport& report) {
  Json j;
  j.begin_object();
  put_crowd_origin(j, report);
  put_finding(j, report.peer.finder());
  j.key("socket").begin_object();
  const shell::SocketStats& socket = report.socket;
  j.field("sent", socket.sent).field("send_errors", socket.send_errors).field("refused", socket.refused);
  j.field("buffer_full", socket.buffer_full).field("receive_errors", socket.receive_errors).end_object();
  if (report.record.first_tick >= 0) put_crowd_play(j, report.record, report.peer);
  j.end_object();
  return j.text();
}

}  // namespace padr::peer
