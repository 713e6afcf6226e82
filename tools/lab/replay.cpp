#include "tools/lab/replay.h"

#include <algorithm>
#include <cstdio>
#include <deque>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/model/user_error.h"
#include "common/replica/replica.h"
#include "common/scenarios/scenarios.h"
#include "common/trace/truth.h"
#include "common/wire/membership_codec.h"
#include "common/wire/transfer_codec.h"
#include "common/world/fingerprint.h"
#include "shell/files.h"

namespace padr::lab {
namespace {

// Hours of a busy session.
constexpr std::size_t kMostBytes = std::size_t{4} << 30U;

Scene scene_of(const trace::TraceReader& t) {
  const trace::Header& h = t.header();
  Scene scene = scenarios::load(h.scenario_text, t.label() + " (its scenario " + h.scenario + ")", h.scenario_seed);
  if (scene_hash(scene) != h.scene_hash || static_cast<int>(scene.bodies.size()) != h.bodies)
    throw UserError(t.label() + ": its scenario makes another scene here than where it was recorded (revision " +
                    (h.revision.empty() ? "unknown" : h.revision) + ")");
  if (static_cast<int>(scene.avatar.spawns.size()) < h.slots)
    throw UserError(t.label() + ": has more avatar slots than its scenario");
  const std::string differs = world::physics_difference(h.fingerprint, world::physics_fingerprint(),
                                                        "the machine that recorded it", "this one");
  if (!differs.empty()) throw UserError(t.label() + ": physics plays out differently here: " + differs);
  return scene;
}

node::ReplicaConfig config_of(const trace::Header& h) {
  node::ReplicaConfig c;
  c.self = h.peer;
  c.peers = h.peers;
  c.wanted = h.wanted;
  c.slots = h.slots;
  c.incarnation = h.incarnation;
  c.session = h.session;
  c.session_id = h.session_id;
  c.spectates = h.spectates;
  c.technique = h.technique;
  return c;
}

struct ConfirmedWorld {
  trace::Confirmed tick;
  trace::Truth truth;
};

bool same(const ConfirmedWorld& a, const ConfirmedWorld& b) {
  return a.tick.tick == b.tick.tick && a.tick.hash == b.tick.hash && a.truth.owner == b.truth.owner &&
         a.truth.present == b.truth.present && a.truth.agreed == b.truth.agreed;
}

}  // namespace

/// The replica that does it all again, and what it and the trace say that has not been compared yet.
class Replay::Again {
 public:
  Again(const trace::TraceReader& t, node::Replica::ConfirmedSink on_confirmed)
      : scene_(scene_of(t)), label_(t.label()), header_(t.header()), on_confirmed_(std::move(on_confirmed)) {
    if (header_.incarnation == 0) replica_.emplace(scene_, config(), sink());
  }

  void take(const trace::Begin& b) {
    const auto start = wire::decode_transfer(b.transfer, scene_, header_.slots);
    if (!start || start->state.tick != b.confirmed)
      throw UserError(label_ + ": the agreed world that it begins with does not decode");
    replica_.emplace(scene_, config(), *start, b.tick, sink());
    replica_->catch_up(std::max(0, b.tick - b.confirmed));
  }
  void take(const trace::Received& r) {
    compare_rest();
    ++result_.datagrams_in;
    replica_->receive(r.datagram, r.at);
  }
  void take(const trace::Order& o) {
    const auto message = wire::decode_membership(o.fetched);
    const auto* fetched = message ? std::get_if<wire::Fetched>(&*message) : nullptr;
    if (fetched == nullptr || fetched->updates.size() != 1)
      throw UserError(label_ + ": an order after tick " + std::to_string(replica_->now()) + " does not decode");
    replica_->order(fetched->updates[0]);
  }
  void take(const trace::Relayed& r) {
    const auto message = wire::decode_membership(r.fetched);
    const auto* fetched = message ? std::get_if<wire::Fetched>(&*message) : nullptr;
    if (fetched == nullptr)
      throw UserError(label_ + ": what was relayed after tick " + std::to_string(replica_->now()) + " does not decode");
    replica_->relay(fetched->slot, fetched->incarnation, fetched->updates, kNoPeer);
  }
  void take(const trace::Freeze& f) { replica_->freeze(f.peer, f.frozen); }
  void take(const trace::GiveUp& g) { replica_->give_up(g.peer, true); }
  void take(const trace::Excuse&) { replica_->excuse_tick(); }
  void take(const trace::Retune& r) { replica_->retune(r.technique); }
  void take(const trace::Push& p) { replica_->push(p.body, p.velocity); }
  void take(const trace::Remark&) {}
  void take(const trace::Footer&) {}
  void take(const trace::Confirmed& c, const trace::Truth& truth) {
    compare_rest();
    recorded_.push_back({c, truth});
  }
  void take(const trace::Step& s, const trace::LiveView& live) {
    compare_rest();
    if (s.leaving) replica_->leave();
    signature_ = s.signature.value_or(sync::Signature{});
    if (stepped_) replica_->step(s.target);
    result_.ticks = s.tick;
    if (replica_->now() != s.tick)
      differ("the trace steps to it, the replay is at tick " + std::to_string(replica_->now()));
    compare_live(s, live);
    compare_confirmed();
    next_out_ = 0;
    stepped_ = true;
  }
  void take(const trace::Sent& s) {
    const auto out = replica_->outgoing();
    const std::string what =
        "datagram " + std::to_string(next_out_ + 1) + " of the tick, to peer " + std::to_string(s.to);
    if (s.tick != replica_->now()) return differ(what + ", bears tick " + std::to_string(s.tick));
    if (next_out_ >= out.size()) return differ(what + ", is not sent again");
    const node::Outgoing& o = out[next_out_++];
    if (o.to != s.to) return differ(what + ", goes to peer " + std::to_string(o.to) + " now");
    if (!std::equal(o.bytes.begin(), o.bytes.end(), s.datagram.begin(), s.datagram.end()))
      return differ(what + ", has other bytes");
    ++result_.datagrams_out;
  }
  /// What the last step sent beyond what was recorded.
  void compare_rest() {
    if (stepped_ && next_out_ < replica_->outgoing().size())
      differ("the replay sends " + std::to_string(replica_->outgoing().size()) + " datagrams, " +
             std::to_string(next_out_) + " were recorded");
  }

  ReplayResult& result() { return result_; }
  const Scene& scene() const { return scene_; }
  const node::Replica* replica() const { return replica_ ? &*replica_ : nullptr; }
  std::vector<node::MemberChange> take_changes() {
    return replica_ ? replica_->take_changes() : std::vector<node::MemberChange>{};
  }

 private:
  node::ReplicaConfig config() {
    node::ReplicaConfig c = config_of(header_);
    if (header_.is_signed) c.sign = [this](const sync::Bundle&) { return signature_; };
    return c;
  }
  node::Replica::ConfirmedSink sink() {
    return [this](const sync::FoldState& s, const sync::LazyHash& hash) {
      ours_.push_back({{s.tick, hash}, trace::truth_of(s, header_.technique.authority)});
      if (on_confirmed_) on_confirmed_(s, hash);
    };
  }

  void differ(const std::string& what) {
    if (result_.difference.empty()) result_.difference = "tick " + std::to_string(replica_->now()) + ": " + what;
  }

  void compare_live(const trace::Step& s, const trace::LiveView& live) {
    const world::View& w = replica_->live().world();
    if (replica_->live_hash() != s.live_hash) {
      for (std::size_t i = 0; i < live.states.size(); ++i) {
        const auto e = static_cast<EntityId>(i);
        if (w.state(e) == live.states[e]) continue;
        const bool avatar = w.is_avatar(e);
        return differ("live world differs, first in " + std::string(avatar ? "avatar " : "body ") +
                      std::to_string(avatar ? e - w.bodies() : e));
      }
      return differ("live hash differs");
    }
    if (stepped_ && replica_->shown().positions() != live.shown) differ("shown positions differ");
  }

  void compare_confirmed() {
    while (!ours_.empty() && !recorded_.empty()) {
      if (!same(ours_.front(), recorded_.front()))
        return differ("confirmed world of tick " + std::to_string(recorded_.front().tick.tick) + " differs");
      ours_.pop_front();
      recorded_.pop_front();
      ++result_.confirmed;
    }
    if (!ours_.empty()) differ("the replay confirms tick " + std::to_string(ours_.front().tick.tick) + ", too early");
    if (!recorded_.empty()) differ("the replay does not confirm tick " + std::to_string(recorded_.front().tick.tick));
  }

  std::deque<ConfirmedWorld> ours_;  ///< before the replica, which confirms tick 0 while it is built
  std::deque<ConfirmedWorld> recorded_;
  Scene scene_;
  std::string label_;
  trace::Header header_;
  node::Replica::ConfirmedSink on_confirmed_;
  std::optional<node::Replica> replica_;
  sync::Signature signature_{};  ///< of what the step to come publishes
  bool stepped_ = false;         ///< the first step of a trace is the state before any
  std::size_t next_out_ = 0;
  ReplayResult result_;
};

Replay::Replay(trace::TraceReader& trace, node::Replica::ConfirmedSink on_confirmed)
    : trace_(trace), again_(std::make_unique<Again>(trace, std::move(on_confirmed))) {}

Replay::~Replay() = default;

std::optional<trace::Event> Replay::next() {
  if (!again_->result().identical()) return std::nullopt;
  auto event = trace_.next();
  if (!event) {
    // A trace that broke off may lack what its last step sent.
    if (trace_.clean()) again_->compare_rest();
    again_->result().truncated = !trace_.clean();
    again_->result().has_rest = trace_.clean() && trace_.truncated();
    return std::nullopt;
  }
  std::visit(
      [&](const auto& e) {
        using E = std::decay_t<decltype(e)>;
        if constexpr (std::is_same_v<E, trace::Confirmed>) {
          again_->take(e, trace_.truth());
        } else if constexpr (std::is_same_v<E, trace::Step>) {
          again_->take(e, trace_.live());
        } else {
          again_->take(e);
        }
      },
      *event);
  return again_->result().identical() ? event : std::nullopt;
}

const Scene& Replay::scene() const {
  return again_->scene();
}
const node::Replica* Replay::replica() const {
  return again_->replica();
}
std::vector<node::MemberChange> Replay::take_changes() {
  return again_->take_changes();
}
const ReplayResult& Replay::result() const {
  return again_->result();
}

ReplayResult replay(trace::TraceReader& trace) {
  Replay r(trace);
  while (r.next()) {
  }
  while (trace.next()) {  // what a damaged byte does is no difference: the reader refuses it
  }
  return r.result();
}

std::string read_trace_file(const std::string& file) {
  return shell::read_file("TRACE", file, kMostBytes);
}

int run_replay(const std::string& file) {
  const std::string text = read_trace_file(file);
  trace::TraceReader reader(std::as_bytes(std::span(text)), file);
  const ReplayResult r = replay(reader);
  if (!r.identical()) {
    std::printf("%s: DIFFERS at %s\n", file.c_str(), r.difference.c_str());
    return 1;
  }
  std::printf("%s: identical: peer %d, %d ticks, %llu confirmed worlds, %llu datagrams in, %llu out%s\n", file.c_str(),
              reader.header().peer, r.ticks, static_cast<unsigned long long>(r.confirmed),
              static_cast<unsigned long long>(r.datagrams_in), static_cast<unsigned long long>(r.datagrams_out),
              r.truncated  ? " (the trace breaks off: the program did not end well, or is still running)"
              : r.has_rest ? " (something follows the end that is no part of a trace)"
                           : "");
  return 0;
}

}  // namespace padr::lab
