#include "tools/report/analysis.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <memory>
#include <set>
#include <string_view>
#include <utility>

#include "common/model/user_error.h"
#include "common/replica/replica.h"
#include "common/scenarios/scenarios.h"
#include "common/trace/fidelity.h"
#include "common/trace/trace_reader.h"
#include "common/wire/codec.h"
#include "tools/report/confirmed_ticks.h"
#include "tools/report/link_meter.h"
#include "tools/report/summary.h"
#include "tools/report/traffic.h"

namespace padr::report {
namespace {

constexpr Tick kOpen = -1;  ///< still carried

/// A state datagram's packet; nothing if it is damaged or of another kind.
std::optional<std::pair<PeerId, sync::StatePacket>> packet_of(std::span<const std::byte> datagram) {
  wire::SealError error{};
  const auto opened = wire::open(datagram, error);
  if (!opened || opened->header.kind != wire::Kind::kState) return std::nullopt;
  auto packet = wire::decode_state(opened->payload, opened->header.sender);
  if (!packet) return std::nullopt;
  return std::pair{opened->header.sender, std::move(*packet)};
}

/// What the session was played in; nothing if the trace does not say it as it was.
std::optional<Scene> scene_of(const trace::Header& h) {
  try {
    Scene scene = scenarios::load(h.scenario_text, h.scenario, h.scenario_seed);
    if (scene_hash(scene) == h.scene_hash) return scene;
  } catch (const UserError&) {
  }
  return std::nullopt;
}

/// One trace on its way to its end.
struct Cursor {
  Cursor(const TraceBytes& t, std::size_t number, const Survey& s)
      : reader(t.bytes, t.label), incarnation(number), about(s) {
    peer.came = s.came;
    peer.first_tick = s.first_step;
    peer.last_tick = s.first_step - 1;
  }
  trace::TraceReader reader;
  std::size_t incarnation;
  const Survey& about;
  Technique technique = reader.header().technique;  ///< as it plays now
  Peer peer;
  TrafficMeter traffic;
  std::unique_ptr<trace::ShownMeter> shown;  ///< null: the scene is not known
  std::vector<bool> present;                 ///< entities, as confirmed last
  double threshold_sum = 0;
  Vec2 target;  ///< m, of the last step
  bool ended = false;
};

class Analysis {
 public:
  /// As many of both, by slot and incarnation.
  Analysis(const std::vector<const TraceBytes*>& traces, std::vector<Survey> incarnations)
      : incarnations_(std::move(incarnations)),
        session_(incarnations_[0].header),
        meter_(slots_of(incarnations_), session_.bodies),
        flips_(session_.bodies),
        confirmed_(incarnations_),
        owner_(static_cast<std::size_t>(session_.bodies), kNoPeer) {
    for (std::size_t i = 0; i < incarnations_.size(); ++i) {
      cursors_.push_back(std::make_unique<Cursor>(*traces[i], i, incarnations_[i]));
      meter_.came(i, incarnations_[i].came);
    }
    if (const auto scene = scene_of(session_)) {
      fidelity_ = std::make_unique<trace::FidelityMeter>(*scene, session_.slots, slots_of(incarnations_));
      for (const auto& c : cursors_) c->shown = std::make_unique<trace::ShownMeter>(*scene, session_.slots);
    }
    views_.resize(incarnations_.size());
  }

  Report run() {
    // All in step, so that no more than what is not confirmed yet is kept in memory. Each goes as far as a step's tick.
    for (Tick t = 0; std::any_of(cursors_.begin(), cursors_.end(), [](const auto& c) { return !c->ended; }); ++t) {
      for (const auto& c : cursors_) advance(*c, t - 1);
      if (fidelity_) measure_fidelity(t);
    }
    return finish();
  }

 private:
  static std::vector<PeerId> slots_of(const std::vector<Survey>& incarnations) {
    std::vector<PeerId> slots;
    slots.reserve(incarnations.size());
    for (const Survey& s : incarnations) slots.push_back(s.header.peer);
    return slots;
  }

  void advance(Cursor& c, Tick until) {
    while (!c.ended && c.peer.last_tick <= until) {
      const auto event = c.reader.next();
      if (!event) {
        c.ended = true;
        meter_.gone(c.incarnation, c.peer.last_tick + 1);
        return;
      }
      std::visit([&](const auto& e) { take(c, e); }, *event);
    }
  }

  void measure_fidelity(Tick t) {
    for (const auto& c : cursors_) {
      trace::PlayerView& v = views_[c->incarnation];
      v = {!c->ended && c->peer.last_tick == t && t >= c->about.came && c->peer.left_at < 0, c->reader.live().states,
           c->target};
      v.there = v.there && !c->reader.header().spectates && trace::can_be_stepped(v);
    }
    fidelity_->tick(t, views_);
  }

  void take(Cursor& c, const trace::Step& s) {
    Peer& p = c.peer;
    p.last_tick = s.tick;
    c.target = s.target;
    if (s.tick < c.about.came) return;
    if (s.lateness > kLate) ++p.late_ticks;
    p.worst_lateness = std::max(p.worst_lateness, s.lateness);
    p.replayed_steps = s.replayed_steps;
    p.snaps = s.snaps;
    p.snap_m = s.snap_m;
    if (s.leaving && p.left_at < 0) {
      p.left_at = s.tick;
      meter_.gone(c.incarnation, s.tick);
    }
    if (p.left_at >= 0) return;
    c.threshold_sum += static_cast<double>(s.threshold);
    trace::View v;
    for (const BodyState& state : c.reader.live().states) v.live.push_back(state.position);
    v.shown = c.reader.live().shown;
    v.unowned_alone = plays_unowned_alone(c.technique);
    meter_.view(c.incarnation, s.tick, v);
    if (c.shown) c.shown->tick(c.reader.live().states, v.shown, present(c));
  }
  /// As confirmed so far; before anything is, everything is there.
  static std::vector<bool> present(const Cursor& c) {
    if (c.peer.last_confirmed >= 0) return c.reader.truth().present;
    return std::vector<bool>(c.reader.live().states.size(), true);
  }

  void take(Cursor& c, const trace::Received& r) {
    const auto packet = packet_of(r.datagram);
    if (!packet || packet->first == c.reader.header().peer || packet->first >= session_.slots) {
      ++c.peer.damaged;
      return;
    }
    heard_.insert(packet->first);
    // What is for the incarnation before, or comes from it, has numbers of its own; it may still arrive when the next
    // one has begun.
    const sync::StatePacket& p = packet->second;
    if (p.to_incarnation != c.reader.header().incarnation || p.mark_tick < c.about.came) return;
    const auto from = life_at(incarnations_, packet->first, p.incarnation, p.mark_tick);
    if (from) links_[{*from, c.incarnation}].received(p.seq, p.mark_tick, r.at);
  }

  void take(Cursor& c, const trace::Sent& s) {
    const auto packet = packet_of(s.datagram);
    if (!packet || s.to >= session_.slots)
      throw UserError(c.reader.label() + ": the datagram sent at tick " + std::to_string(s.tick) + " to peer " +
                      std::to_string(s.to) + " makes no sense");
    const auto to = life_at(incarnations_, s.to, packet->second.to_incarnation, s.tick);
    if (to && s.tick >= std::max(c.about.came, incarnations_[*to].came))
      links_[{c.incarnation, *to}].sent(packet->second.seq, s.tick);
    if (s.tick >= c.about.came && (c.peer.left_at < 0 || s.tick <= c.peer.left_at))
      c.traffic.sent(s.to, s.tick, packet->second, s.datagram.size() + node::kIpUdpBytes);
  }

  void take(Cursor& c, const trace::Confirmed& t) {
    c.peer.last_confirmed = t.tick;
    confirmed_.add(c.incarnation, t.tick, t.hash);
    if (c.about.superseded) return;  // others may have agreed on something else meanwhile
    note_gone(c, t.tick);
    // The first trace to know a tick speaks for all: they are the same, or their hashes say so.
    if (t.tick < next_truth_) return;
    next_truth_ = t.tick + 1;
    const trace::Truth& truth = c.reader.truth();
    for (std::size_t b = 0; b < owner_.size(); ++b) {
      if (truth.owner[b] == owner_[b]) continue;
      owner_[b] = truth.owner[b];
      authority_.push_back({t.tick, static_cast<EntityId>(b), owner_[b]});
    }
    flips_.owners(t.tick, truth.owner);
    meter_.truth(t.tick, truth);
  }

  /// Whose avatar is out of the session by this trace, while its own trace goes on.
  void note_gone(Cursor& c, Tick now) {
    const std::vector<bool>& present = c.reader.truth().present;
    if (present == c.present) return;
    for (const auto& other : cursors_) {
      const Survey& s = other->about;
      const std::size_t avatar = static_cast<std::size_t>(session_.bodies) + s.header.peer;
      if (other != cursors_[c.incarnation] && avatar < c.present.size() && c.present[avatar] && !present[avatar] &&
          s.came < now && now <= s.last_tick)
        gone_.push_back({other->incarnation, c.incarnation, now});
    }
    c.present = present;
  }

  static void take(Cursor& c, const trace::Retune& r) {
    c.technique = r.technique;
    c.peer.technique_last = r.technique;
    ++c.peer.retunes;
  }
  void take(Cursor& c, const trace::Push& p) {
    ++c.peer.pushes;
    if (fidelity_ && p.body < session_.bodies) fidelity_->pushed(p.body, c.peer.last_tick + 1);
  }
  static void take(Cursor& c, const trace::Remark& m) {
    // Its own decisions, and no interference.
    if (m.kind == "cut_off" && m.peer != kNoPeer)
      ++drops_of(c, m.peer).cut_offs;
    else if (m.kind == "way" && m.peer != kNoPeer)
      note_way(c, m);
    else
      note_interference(c, m);
  }
  static void note_interference(Cursor& c, const trace::Remark& m) {
    ++c.peer.remarks;
    if (m.kind != "netem") return;
    c.peer.netem_last = m.text.empty() ? "unimpaired" : m.text;
    if (m.peer != kNoPeer) *c.peer.netem_last += " (to peer " + std::to_string(m.peer) + ")";
  }
  static void note_way(Cursor& c, const trace::Remark& m) {
    std::vector<Carried>& all = c.peer.carried;
    for (Carried& one : all)
      if (one.to == m.peer && one.until == kOpen) one.until = c.peer.last_tick;
    constexpr std::string_view kBy = "by ";
    int by = -1;
    if (!m.text.starts_with(kBy)) return;
    const auto [end, wrong] = std::from_chars(m.text.data() + kBy.size(), m.text.data() + m.text.size(), by);
    if (wrong == std::errc() && end == m.text.data() + m.text.size() && by >= 0 && by < kMaxPeers)
      all.push_back({m.peer, static_cast<PeerId>(by), c.peer.last_tick, kOpen});
  }
  static void take(Cursor& c, const trace::Footer& f) {
    c.peer.dropped = f.dropped;
    for (const trace::Dropped& d : f.dropped_of) drops_of(c, d.peer).by_reason = d.by_reason;
  }
  static Drops& drops_of(Cursor& c, PeerId p) {
    std::vector<Drops>& all = c.peer.drops;
    const auto at = std::find_if(all.begin(), all.end(), [p](const Drops& d) { return d.of >= p; });
    if (at != all.end() && at->of == p) return *at;
    return *all.insert(at, {p, {}, 0});
  }

  template <typename Other>
  void take(Cursor&, const Other&) {}

  Report finish() {
    for (const auto& [incarnation, by, out] : gone_) {
      const Tick left = cursors_[incarnation]->peer.left_at;
      if (left < 0 || left > out)
        confirmed_.give_up(incarnation, by);  // it was declared gone, and has not said goodbye
    }
    Report r;
    for (const auto& c : cursors_) {
      Peer& p = c->peer;
      p.name = c->about.name;
      p.superseded = c->about.superseded;
      p.label = c->reader.label();
      p.header = c->reader.header();
      p.clean = c->reader.clean();
      p.has_rest = p.clean && c->reader.truncated();
      for (Carried& one : p.carried)
        if (one.until == kOpen) one.until = p.went();
      p.inconsistency = meter_.result(c->incarnation);
      p.series = meter_.series(c->incarnation);
      if (fidelity_) take_fidelity(*c);
      if (c->shown) p.shown = c->shown->result();
      p.traffic = c->traffic.total();
      p.per_second = c->traffic.per_second();
      p.threshold_mean_m = c->threshold_sum / (p.played() + 1);
      r.peers.push_back(std::move(p));
    }
    for (const auto& [ends, l] : links_) r.links.push_back(link(ends.first, ends.second, l));
    r.confirmed = confirmed_.compare();
    r.authority = std::move(authority_);
    r.authority_until = next_truth_;
    r.heard.assign(heard_.begin(), heard_.end());
    r.hand_overs = flips_.all();
    r.hand_overs_by_body = flips_.by_body();
    if (fidelity_) r.left_out = fidelity_->left_out();
    r.fidelity_known = fidelity_ != nullptr;
    summarize(r);
    return r;
  }

  void take_fidelity(Cursor& c) const {
    c.peer.fidelity_series = fidelity_->series(c.incarnation);
    c.peer.fidelity = fidelity_->result(c.incarnation);
    c.peer.deeds = fidelity_->deeds(c.incarnation);
    c.peer.pcc_series = fidelity_->pcc().series(c.incarnation);
    c.peer.pcc = fidelity_->pcc().result(c.incarnation);
  }

  Link link(std::size_t from, std::size_t to, const LinkMeter& meter) const {
    Link l = meter.result(incarnations_[from].header.peer, incarnations_[to].header.peer, incarnations_[to].last_tick);
    l.from_name = incarnations_[from].name;
    l.to_name = incarnations_[to].name;
    return l;
  }

  std::vector<Survey> incarnations_;
  trace::Header session_;
  trace::InconsistencyMeter meter_;
  trace::FlipMeter flips_;
  std::unique_ptr<trace::FidelityMeter> fidelity_;  ///< null: the scene is not known
  std::vector<trace::PlayerView> views_;            ///< by incarnation
  std::vector<std::unique_ptr<Cursor>> cursors_;
  std::map<std::pair<std::size_t, std::size_t>, LinkMeter> links_;  ///< by incarnations
  std::set<PeerId> heard_;
  ConfirmedTicks confirmed_;
  struct Gone {
    std::size_t incarnation;
    std::size_t by;  ///< in whose trace
    Tick out;
  };
  std::vector<Gone> gone_;  ///< whose avatar left the session
  Tick next_truth_ = 0;
  std::vector<PeerId> owner_;  ///< by body, at next_truth_ - 1
  std::vector<AuthorityChange> authority_;
};

}  // namespace

Report analyse(const std::vector<TraceBytes>& traces) {
  if (traces.empty()) throw UserError("no trace given");
  std::vector<Survey> surveys;
  for (const TraceBytes& t : traces) {
    surveys.push_back({});
    surveys.back().header = trace::TraceReader(t.bytes, t.label).header();
  }
  check_together(surveys, traces);
  std::vector<std::string> outside;
  for (std::size_t i = 0; i < traces.size(); ++i) surveys[i] = survey(traces[i]);
  std::vector<const TraceBytes*> ordered;
  std::vector<Survey> incarnations;
  for (const std::size_t i : in_order(surveys)) {
    if (surveys[i].came < 0) {
      outside.push_back(traces[i].label);
      continue;
    }
    ordered.push_back(&traces[i]);
    incarnations.push_back(std::move(surveys[i]));
  }
  if (incarnations.empty()) throw UserError(traces[0].label + ": its peer never played");
  give_names(incarnations);
  Report r = Analysis(ordered, std::move(incarnations)).run();
  for (const std::string& label : outside) r.notes.push_back(label + ": its peer never played, and is left out");
  return r;
}

}  // namespace padr::report
