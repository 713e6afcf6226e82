#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/model/scene.h"
#include "tools/monitor/agreement.h"
#include "tools/monitor/blocks.h"
#include "tools/monitor/gauge.h"
#include "tools/monitor/peer_record.h"
#include "tools/monitor/series.h"
#include "tools/monitor/view_source.h"

namespace padr::monitor {

/// What makes a session the one it is.
struct SessionKey {
  std::uint16_t number = 0;
  std::uint64_t scene_hash = 0;
  friend auto operator<=>(const SessionKey&, const SessionKey&) = default;
};

/// An event with who told it.
struct SessionEvent {
  PeerId by = kNoPeer;
  std::uint64_t process = 0;
  Event event;
};

/// Contacts, authority and driving: so many that they would leave no room for the rest, so each of the two is bounded
/// by itself.
bool is_frequent(EventKind kind);

/// A session as its peers tell it: the newest of each, and what follows from putting them side by side. Has no clock:
/// `now` is microseconds of whatever clock the caller keeps.
class ObservedSession : public ViewSource {
 public:
  ObservedSession(SessionKey key, Scene scene, std::string scenario, std::uint64_t seed, int slots, Micros now);

  /// Something that a peer of this session has told. `from`: where it came from.
  void take(const Told& told, const Endpoint& from, Micros now);
  /// The agreed world by itself, of nobody in particular.
  void show_agreed(const Agreed& agreed);
  /// Forgets who has been gone for long; every now and then.
  void advance(Micros now);

  const SessionKey& key() const { return key_; }
  const Scene& scene() const { return scene_; }
  const std::string& scenario() const { return scenario_; }
  std::uint64_t seed() const { return seed_; }
  int slots() const { return slots_; }
  Micros began() const { return began_; }
  /// The newest tick that anybody told of.
  Tick tick() const { return tick_; }

  /// By ascending slot: who sits there, or sat there last.
  std::vector<const PeerRecord*> peers() const;
  /// By process; null if it is not known.
  const PeerRecord* process(std::uint64_t process) const;
  /// Null if there is nobody.
  const PeerRecord* peer(PeerId slot) const;
  bool alive(Micros now) const;

  const Agreement& agreement() const { return agreement_; }
  /// The newest measured of this slot; not while it is cut off or apart from the others.
  std::optional<trace::InconsistencyPoint> inconsistency(PeerId slot) const;

  /// What was measured of a tick beside what peers tell.
  void measured(PeerId slot, float fidelity_m, float pcc_m);
  /// Makes a point of what was measured since the last.
  const SeriesPoint& sample(Micros now);
  const Series& series() const { return series_; }
  /// What was measured since the point before the newest, by ascending tick; not of peers whose error is not known.
  const std::vector<Gauge::Measured>& newest_measured() const { return newest_measured_; }

  /// The newest events, oldest first; each has a number, counted from 0.
  const std::deque<SessionEvent>& events() const { return events_; }
  std::uint64_t events_ever() const { return events_ever_; }
  /// The newest `n` of those of frequent kinds, and of the others; oldest first.
  std::vector<SessionEvent> newest_events(std::size_t n) const;
  static constexpr std::size_t kEvents = 5000;  ///< kept of frequent kinds, and of the others

  std::uint64_t serial() const override { return serial_; }
  std::vector<View> views(unsigned views, std::uint64_t since) override;

  static constexpr std::size_t kProcesses = 128;
  static constexpr Micros kForgetAfter = 60 * kMicrosPerSecond;

 private:
  void take(PeerRecord& p, const Hello& h, Micros now);
  void take(PeerRecord& p, const Frame& f, Micros now);
  void take(PeerRecord& p, const Agreed& a, Micros now);
  void take(PeerRecord& p, const Status& s, Micros now);
  void take(PeerRecord& p, const Events& e, Micros now);
  void take(PeerRecord&, const ScenarioPart&, Micros) {}
  PeerRecord* record_of(const Origin& origin, Micros now);
  bool holds_slot(const PeerRecord& p) const;
  /// Whether p counts q among its members, as far as p has told.
  bool counts(const PeerRecord& p, const PeerRecord& q) const;
  /// Whether it and all whose world is held to be right are no longer in one part of the session.
  bool is_apart(const PeerRecord& p) const;
  /// Apart from the others a peer confirms a world of its own, and to compare with that one says nothing.
  bool error_known(const PeerRecord& p) const;
  void leave_slot(PeerId slot);
  void put(const Block& head, std::shared_ptr<const Frame> frame, std::shared_ptr<const Agreed> agreed);
  void put_frame(const PeerRecord& p);
  void put_authority(Tick tick);
  void gather(const PeerRecord& p, Micros now);

  /// The newest of a kind, made bytes of when somebody wants them.
  struct Newest {
    std::uint64_t serial = 0;
    Block head;
    std::shared_ptr<const Frame> frame;    ///< or
    std::shared_ptr<const Agreed> agreed;  ///< this
    Shared bytes;
  };
  static std::string encode(const Newest& n);

  SessionKey key_;
  Scene scene_;
  std::string scenario_;
  std::uint64_t seed_;
  int slots_;
  std::size_t entities_;
  Micros began_;
  Tick tick_ = 0;
  std::map<std::uint64_t, PeerRecord> peers_;  ///< by process
  std::map<PeerId, std::uint64_t> sits_;       ///< process by slot
  Agreement agreement_;
  Gauge gauge_;
  struct Sum {
    int n = 0;
    trace::InconsistencyPoint sum;
    trace::InconsistencyPoint last;
    trace::InconsistencyPoint told;  ///< mean in the newest point that had any
  };
  std::map<PeerId, Sum> measured_;  ///< since the last point
  std::vector<Gauge::Measured> newest_measured_;
  struct Deeds {
    int n = 0;
    float fidelity_m = 0;
    float pcc_m = 0;
  };
  std::map<PeerId, Deeds> deeds_;  ///< likewise, sums
  Series series_;
  std::deque<SessionEvent> events_;
  std::array<std::size_t, 2> events_kept_{};  ///< of them by is_frequent()
  std::uint64_t events_ever_ = 0;
  std::uint64_t serial_ = 0;
  std::map<std::pair<PeerId, Which>, Newest> views_;
  std::map<Tick, std::map<PeerId, std::shared_ptr<const Frame>>> recent_;  ///< frames by tick, for the authority's view
  Tick authority_at_ = -1;
};

}  // namespace padr::monitor
