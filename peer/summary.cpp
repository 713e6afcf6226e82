#include "peer/summary.h"

#include <algorithm>
#include <array>

#include "peer/status.h"
#include "shell/command_line.h"
#include "shell/json.h"
#include "shell/key_text.h"
#include "shell/netem_text.h"
#include "shell/revision.h"
#include "shell/technique_text.h"
#include "shell/text.h"

namespace padr::peer {
namespace {

using shell::Json;

void put_origin(Json& j, const Report& r) {
  const Options& o = r.options;
  j.field("program", "padr-peer").field("version", shell::version()).field("revision", shell::revision());
  j.field("command", shell::shell_line(o.command));
  j.field("scenario", o.scenario.label).field("seed", o.scenario.seed);
  j.field("technique", shell::describe(r.player.technique())).field("input", o.input);
  j.field("netem", shell::to_string(o.netem)).field("netem_seed", o.netem_seed);
  j.field("exit_code", r.exit_code).field("reason", r.reason);
}

void put_session(Json& j, const Report& r) {
  const node::Session& session = r.player.session();
  const node::SessionStats& s = session.stats();
  j.key("session").begin_object();
  j.field("listen", to_string(r.local)).field("number", session.number());
  j.field("started", r.player.has_begun()).field("peers", session.present());
  j.field("spectators", session.spectators()).field("spectates", r.options.spectates).field("slots", session.slots());
  // To whoever let us in.
  j.field("round_trip_ms", static_cast<double>(session.round_trip()) / 1e3);
  j.key("datagrams").begin_object();
  j.field("received", s.datagrams).field("state", s.state).field("session", s.session).field("seal", s.seal);
  j.field("version", s.version).field("foreign", s.foreign).field("malformed", s.malformed);
  j.end_object().end_object();
}

void put_seal(Json& j, const Report& r) {
  const node::SecureChannels* channels = r.player.channels();
  if (channels == nullptr) return;
  const node::ChannelStats& s = channels->stats();
  j.key("seal").begin_object();
  j.field("mode", r.options.seal == wire::SealMode::kAuth ? "auth" : "encrypt");
  j.field("public_key", shell::key_text(channels->key())).field("known", channels->channels());
  j.field("received", s.datagrams)
      .field("passed", s.passed)
      .field("handshakes", s.handshakes)
      .field("rekeys", s.rekeys)
      .field("moves", s.moves)
      .field("readable", s.readable)
      .field("carried", s.carried)
      .field("carried_bytes", s.carried_bytes)
      .field("declined", s.declined);
  j.key("dropped").begin_object();
  for (std::size_t d = 0; d < node::kChannelDrops; ++d) j.field(node::kChannelDropNames[d], s.dropped[d]);
  j.end_object().end_object();
}

void put_socket(Json& j, const shell::SocketStats& s) {
  j.key("socket").begin_object();
  j.field("sent", s.sent).field("send_errors", s.send_errors).field("refused", s.refused);
  j.field("buffer_full", s.buffer_full).field("receive_errors", s.receive_errors);
  j.end_object();
}

void put_monitor(Json& j, const TellerStats& s) {
  j.key("monitor").begin_object();
  j.field("datagrams", s.datagrams).field("bytes", s.bytes).field("untold", s.untold);
  j.field("orders", s.orders).field("rejected", s.rejected);
  j.end_object();
}

void put_confirmed(Json& j, const Player& p) {
  const node::ReplicaStats stats = p.totals().replica;
  j.key("confirmed").begin_object();
  j.field("tick", p.confirmed().tick)
      .field("hash", shell::hex(p.confirmed().hash))
      .field("lag_ms", confirmed_lag_ms(p));
  j.field("checks", stats.hash_checks).field("mismatches", stats.hash_mismatches);
  j.field("first_mismatch", stats.first_mismatch);
  // By tick, so that peers can be compared wherever both have been.
  j.key("checkpoints").begin_object();
  for (const auto& [tick, hash] : p.history().checkpoints()) j.field(std::to_string(tick), shell::hex(hash));
  j.end_object().end_object();
}

void put_lives(Json& j, const Player& p) {
  j.key("lives").begin_array();
  for (const History::Incarnation& incarnation : p.history().incarnations()) {
    if (incarnation.came < 0) continue;
    j.begin_object()
        .field("peer", incarnation.peer)
        .field("incarnation", incarnation.incarnation)
        .field("came_tick", incarnation.came);
    j.field("confirmed_from", incarnation.confirmed_from).field("confirmed_to", incarnation.confirmed.tick);
    j.end_object();
  }
  j.end_array();
}

void put_others(Json& j, const Player& p) {
  j.key("others").begin_object();
  j.field("present", p.present() - 1).field("came", p.history().came()).field("left", p.history().left());
  j.field("removed", p.history().removed()).end_object();
}

void put_drops(Json& j, const std::array<std::uint64_t, sync::kDropReasons>& dropped) {
  j.key("dropped").begin_object();
  for (std::size_t d = 1; d < sync::kDropReasons; ++d) j.field(sync::kDropNames[d], dropped[d]);
  j.end_object();
}

void put_traffic(Json& j, const node::ReplicaStats& s) {
  j.key("sent").begin_object();
  j.field("updates", updates_told(s)).field("bundles", s.bundles).field("repeats", s.repeats);
  j.field("datagrams", s.datagrams_sent).field("wire_bytes", s.wire_bytes_sent);
  j.end_object();
  j.key("updates_by_cause").begin_object();
  for (std::size_t c = 0; c < sync::kCauses; ++c) j.field(sync::kCauseNames[c], s.updates_by_cause[c]);
  j.end_object();
  j.key("received").begin_object().field("datagrams", s.datagrams_received).end_object();
  put_drops(j, s.dropped);
}

void put_shim(Json& j, const link::Shim& shim) {
  const link::ShimStats& s = shim.stats();
  j.key("shim").begin_object();
  j.field("netem", shell::to_string(shim.spec())).field("accepted", s.accepted).field("released", s.released);
  j.field("lost", s.lost).field("duplicated", s.duplicated).field("corrupted", s.corrupted);
  j.field("reordered", s.reordered).field("overlimit", s.overlimit).field("in_flight", shim.in_flight());
  j.end_object();
}

void put_links(Json& j, const Report& r) {
  const Player& p = r.player;
  j.key("links").begin_array();
  for (PeerId to = 0; to < p.replica().config().slots; ++to) {
    const node::Seat& n = p.replica().seat(to);
    const node::LinkState& link = p.replica().link(to);
    if (to == p.self() || !n.at.is_set()) continue;
    j.begin_object().field("peer", to).field("incarnation", n.incarnation).field("endpoint", to_string(p.place(to)));
    j.field("left", n.presence == node::Presence::kLeft).field("lost", n.presence == node::Presence::kAbsent);
    put_drops(j, link.dropped);
    j.field("cut_off", link.cut_offs);
    j.field("rtt_ms", static_cast<double>(link.round_trip()) / 1e3);
    j.field("silence_ms", p.replica().roster().silence(to) * 1000.0 / kTicksPerSecond);
    j.field("kbit_s", link_kbit(p.replica(), to));
    j.field("queue_ms", static_cast<double>(link.out.rate().queue()) * 1000.0 / kTicksPerSecond);
    j.field("carried_by", p.carrier(to) == kNoPeer ? std::nullopt : std::optional<int>(p.carrier(to)));
    if (const link::Shim* shim = r.egress.shim(to)) put_shim(j, *shim);
    j.end_object();
  }
  j.end_array();
}

void put_ticks(Json& j, const Player& p) {
  const TickStats& t = p.ticks();
  j.field("ticks", p.replica().now()).field("first_tick", p.first_tick());
  j.field("seconds", p.has_begun() ? static_cast<double>(p.replica().now() - p.first_tick()) / kTicksPerSecond : 0.0);
  j.field("join_ms", static_cast<double>(p.joined_at()) / 1e3);
  j.field("late_ticks", t.late).field("worst_late_ms", static_cast<double>(t.lateness.worst()) / 1e3);
  j.field("late_share",
          static_cast<double>(t.late) / static_cast<double>(std::max<std::uint64_t>(1, t.lateness.count())));
  j.field("median_late_ms", static_cast<double>(t.lateness.quantile(0.5)) / 1e3);
  j.field("p99_late_ms", static_cast<double>(t.lateness.quantile(0.99)) / 1e3);
  j.field("longest_stall_ms", static_cast<double>(t.longest_stall) / 1e3).field("stalls", t.stalls);
}

void put_play(Json& j, const Report& r) {
  const Player& p = r.player;
  const Totals totals = p.totals();
  j.field("peer", p.self()).field("incarnation", p.replica().config().incarnation);
  put_ticks(j, p);
  j.field("clock_lead_ms", static_cast<double>(p.replica().clock_lead()) / 1e3);
  j.field("clock_slew_ppm", p.session().clock().slew() * 1e6);
  j.field("live_hash", shell::hex(p.replica().live_hash()))
      .field("own_error_m", static_cast<double>(p.replica().own_error()));
  j.field("replayed_steps", totals.replayed_steps).field("delivered", p.replica().delivered());
  put_lives(j, p);
  put_others(j, p);
  put_confirmed(j, p);
  put_traffic(j, totals.replica);
  put_links(j, r);
}

}  // namespace

std::string summary(const Report& r) {
  Json j;
  j.begin_object();
  put_origin(j, r);
  put_session(j, r);
  put_seal(j, r);
  put_socket(j, r.socket.stats());
  if (r.telemetry != nullptr) put_monitor(j, r.telemetry->stats());
  if (r.player.has_begun()) put_play(j, r);
  j.end_object();
  return j.text();
}

}  // namespace padr::peer
