#include "tools/capture/rebuild.h"

#include <algorithm>
#include <iterator>

#include "common/sync/state_hash.h"
#include "common/wire/transfer_codec.h"
#include "tools/capture/counted_updates.h"

namespace padr::capture {
namespace {

class Rebuilder {
 public:
  Rebuilder(const SessionLog& session_log, const Setting& setting, Tick until, const WorldSink& sink)
      : session_log_(session_log), setting_(setting), until_(until), sink_(sink) {
    for (const SessionLog::Check& c : session_log.checks) checks_.emplace(c.tick, &c);
    for (const auto& [key, pieces] : session_log.transfers) {
      if (!pieces.complete()) continue;
      auto t = wire::decode_transfer(pieces.joined(), setting.scene, setting.slots);
      if (t) {
        transfers_.emplace(t->state.tick, std::move(*t));
      } else {
        ++out_.bad_transfers;
      }
    }
  }

  Rebuilt run() {
    Tick reached = -1;
    CountedUpdates c(session_log_, setting_.scene, setting_.slots);
    c.begin(setting_.peers);
    // Of a capture that begins later a transfer may know more.
    if (setting_.wanted > 0 && (transfers_.empty() || begins_at_0(c))) {
      sync::Fold fold(setting_.scene, setting_.slots, setting_.peers, setting_.authority, setting_.wanted);
      reached = follow(c, fold, {0, false, 0, "", false});
    }
    for (auto next = transfers_.upper_bound(reached); next != transfers_.end();
         next = transfers_.upper_bound(reached)) {
      CountedUpdates later(session_log_, setting_.scene, setting_.slots);
      later.begin(next->second);
      sync::Fold fold(setting_.scene, setting_.slots, 0, setting_.authority);
      fold.restore(next->second.state);
      reached = follow(later, fold, {next->first, true, 0, "", false});
    }
    if (!out_.stretches.empty())
      out_.before =
          static_cast<std::uint64_t>(std::distance(checks_.begin(), checks_.lower_bound(out_.stretches.front().from)));
    out_.unreached = session_log_.checks.size() - compared_ - out_.before;
    return std::move(out_);
  }

 private:
  bool begins_at_0(const CountedUpdates& c) const {
    for (PeerId p = 0; p < setting_.peers; ++p)
      if (c.complete({p, 0}) < 0) return false;
    return true;
  }

  /// Folds as far as the log is known; the last tick reached.
  Tick follow(const CountedUpdates& c, sync::Fold& fold, Stretch stretch) {
    sync::FoldState state;
    while (true) {
      fold.save(state);
      look_at(c, state);
      if (!may_step(c, state, stretch)) break;
      for (const sync::Bundle& b : c.at(state.tick)) fold.apply(b);
      fold.step();
    }
    stretch.to = state.tick;
    out_.stretches.push_back(stretch);
    out_.unbelievable += c.unbelievable();
    return state.tick;
  }

  void look_at(const CountedUpdates& c, const sync::FoldState& state) {
    const std::uint64_t hash = sync::hash_of(state);
    const auto [first, last] = checks_.equal_range(state.tick);
    for (auto it = first; it != last; ++it) {
      ++compared_;
      if (c.counts(*it->second)) {
        out_.hashes.push_back({*it->second, it->second->hash == (static_cast<std::uint32_t>(hash) | 1U)});
      } else {
        ++out_.given_up;
      }
    }
    sink_(state, hash);
  }

  bool may_step(const CountedUpdates& c, const sync::FoldState& state, Stretch& stretch) const {
    bool anybody = false;
    for (PeerId p = 0; p < state.members.size(); ++p) {
      if (!state.members[p].present) continue;
      anybody = true;
      const Incarnation who{p, state.members[p].incarnation};
      if (c.complete(who) >= state.tick) continue;
      stretch.why = c.lacks(who, stretch.gap);
      return false;
    }
    if (state.tick < std::max(session_log_.newest, until_)) return true;
    stretch.why = anybody ? "the capture has no more" : "all peers have left";
    return false;
  }

  const SessionLog& session_log_;
  const Setting& setting_;
  Tick until_;
  const WorldSink& sink_;
  std::multimap<Tick, const SessionLog::Check*> checks_;
  std::map<Tick, sync::Transfer> transfers_;
  std::uint64_t compared_ = 0;
  Rebuilt out_;
};

}  // namespace

std::uint64_t Rebuilt::agreeing() const {
  return static_cast<std::uint64_t>(
      std::count_if(hashes.begin(), hashes.end(), [](const Hash& h) { return h.agrees; }));
}

bool Rebuilt::got_anywhere() const {
  return std::any_of(stretches.begin(), stretches.end(), [](const Stretch& s) { return s.to > s.from; });
}

Rebuilt rebuild(const SessionLog& session_log, const Setting& setting, Tick until, const WorldSink& sink) {
  return Rebuilder(session_log, setting, until, sink).run();
}

}  // namespace padr::capture
