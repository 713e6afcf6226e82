#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/delivery/link_rate.h"
#include "common/model/ring.h"
#include "common/sync/bundle_pool.h"
#include "common/sync/packet.h"

namespace padr::sync {

/// When and what to send on one directed link, so that its receiver gets every update of ours, soon, and with few
/// bytes: new updates at once, unacknowledged ones once more with whatever goes out next, lost ones again as soon as
/// their loss shows, and a mark now and then when there is nothing to say. A link that has fallen silent is probed more
/// often, and with each datagram one update is repeated, until it answers: what arrives there is not known.
class OutLink {
 public:
  /// To or of somebody who has just come in. `acked`: the receiver has our updates below this already.
  explicit OutLink(std::uint32_t acked) : acked_(acked), fresh_(true) {}
  OutLink() = default;

  /// What this peer says on the link besides its updates.
  struct Context {
    Tick now = 0;
    std::uint32_t have = 0;  ///< of the receiver's updates
    std::uint32_t have_beyond = 0;
    bool gap = false;    ///< the receiver has promised updates that are not here
    bool calm = false;   ///< its datagrams are known to arrive, and neither end waits for the other's last words
    bool quiet = false;  ///< nobody has had anything to tell lately, and neither end waits for last words
    Tick phase = 0;      ///< of this peer's marks among others', so that not everybody sends them at once
    bool again = false;  ///< the receiver has sent something again, as it has not heard that it is here
  };

  using SizeOf = std::function<std::size_t(const Bundle&)>;
  /// The packet to send this tick, good until the next call, updates and marks filled in; null: none. `own`: this
  /// peer's log, `own.front()` numbered `first`. `size_of` gives the bytes an update takes, `room` those that updates
  /// may take in all.
  StatePacket* compose(const Context& c, const Ring<Bundle>& own, std::uint32_t first, const SizeOf& size_of,
                       std::size_t room);
  /// What compose() gave left as a datagram of so many bytes, IP and UDP headers included. `late`: see
  /// LinkRate::sent().
  void left(std::size_t bytes, Tick now, bool late = false);
  /// Takes in what a datagram from the receiver says about ours. `now`: when it came, no earlier than the last
  /// compose() and perhaps later than the next.
  void on_packet(const StatePacket& p, Tick now);

  /// Our updates 0 .. acked-1 have arrived there.
  std::uint32_t acked() const { return acked_; }
  /// Smoothed round trip in ticks, its acknowledgement delay taken out; a guess until the first measurement.
  float round_trip() const { return srtt_; }
  std::uint32_t sent() const { return seq_; }
  /// How much the link carries.
  const LinkRate& rate() const { return rate_; }
  LinkRate& rate() { return rate_; }
  /// Ticks since the receiver last said that something new of ours has arrived.
  Tick unanswered(Tick now) const { return answered_at_ == kNever ? 0 : std::max(0, now - answered_at_); }
  /// Unanswered for so long, a link is sent one repeat with each datagram, and no others; and after less if an update
  /// is under way.
  static constexpr Tick kSilent = 3 * kTicksPerSecond;
  /// Updates sent more than once, counted by repetition.
  std::uint64_t repeats() const { return repeats_; }

 private:
  static constexpr Tick kNever = -1000;
  struct Flight {
    Tick sent = -1;  ///< tick of the last transmission, -1 before the first
    int times = 0;
  };
  /// A datagram from the receiver.
  struct Heard {
    std::uint32_t seq = 0;
    Tick at = 0;
  };
  void tell_heard(Tick now);
  bool arrived(std::uint32_t index) const;
  /// What hardly any answer takes longer than, the queue included, ticks.
  Tick slow_round_trip() const;
  bool is_silent(const Context& c, const Ring<Bundle>& own, std::uint32_t first) const;
  bool lost(const Flight& f, Tick now) const;
  bool echoes(const Flight& f, Tick now) const;
  /// Updates in the order in which they are considered for a packet.
  void line_up(std::uint32_t oldest, std::uint32_t end);
  /// Chooses what goes out, and what goes along with it. Returns whether it has to go out now.
  bool choose(const Context& c, const Ring<Bundle>& own, std::uint32_t first, const SizeOf& size_of, std::size_t room);
  /// Nothing goes out with the mark, or one update where marks are as far apart as they ever are.
  void choose_least();
  /// Whether an update of so many bytes goes into the datagram, too.
  bool fits(std::size_t bytes, std::size_t room);
  void begin_marks(Tick now);
  bool mark_is_due(const Context& c) const;
  Tick interval(const Context& c, std::uint32_t end) const;
  Flight& flight(std::uint32_t index);
  void empty_packet();
  void take_chosen(Tick now, const Ring<Bundle>& own, std::uint32_t first);
  /// Whether the link itself took so long.
  bool sample(float rtt);
  bool last_were_missed(Tick now) const;

  std::uint32_t seq_ = 0;
  StatePacket packet_;
  BundlePool pool_;                       ///< for packet_
  std::vector<std::uint32_t> repeated_;   ///< scratch
  std::vector<std::uint32_t> lined_up_;   ///< scratch
  std::vector<std::uint32_t> chosen_;     ///< scratch
  std::size_t used_ = 0;                  ///< bytes of the updates that go out
  bool left_out_ = false;                 ///< some update did not fit
  bool oldest_first_ = false;             ///< the oldest update is considered first
  std::optional<std::uint32_t> stalest_;  ///< on a silent link: the one that was sent longest ago
  std::size_t mark_bytes_ = 60;           ///< of the last datagram without updates
  LinkRate rate_;
  std::uint32_t acked_ = 0;
  std::uint32_t acked_beyond_ = 0;
  bool fresh_ = false;          ///< begun with an admission
  bool missed_ = false;         ///< the receiver has spoken since, and does not know of our last datagrams
  Tick newest_seen_sent_ = -1;  ///< when the newest datagram known to have arrived was sent
  std::uint32_t newest_seen_ = 0;
  Tick answered_at_ = kNever;
  Ring<Flight> flights_{32};  ///< updates acked_ + i
  Tick last_sent_ = kNever;
  Tick interval_ = 15;   ///< between marks
  bool marked_ = false;  ///< the last datagram had nothing but its mark
  Tick gap_since_ = -1;
  Heard heard_;             ///< the newest from the receiver
  Heard due_;               ///< the eldest of which it has not been told
  Heard told_;              ///< the newest of which it has
  std::uint32_t loss_ = 0;  ///< per cent, as the receiver told last
  float srtt_ = 12;
  float rttvar_ = 6;
  bool measured_ = false;
  int standstills_ = 0;  ///< round trips in a row that were left out
  std::uint64_t repeats_ = 0;
};

}  // namespace padr::sync
