#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "common/model/ids.h"
#include "common/model/ring.h"

namespace padr::sync {

/// What a directed link carries, and whether it may be sent something now. The acknowledgements show by how much each
/// datagram was later than the quickest of late. A queue of what we have sent explains that for exactly one rate of the
/// link: the estimate. Nothing but marks is sent while that queue, as the estimate has it, is not empty, so what is
/// sent is never older than the link makes it. While something is held back, the estimate grows if datagrams come
/// earlier than it explains; and, seconds apart, on trial.
///
/// Over seconds less is to be sent than the link carries, and no more than a share of a budget: see `ahead`.
///
/// Rates are in bytes per second, IP and UDP headers included.
class LinkRate {
 public:
  /// No limit: 100 Mbit/s.
  static constexpr double kMost = 1.25e7;
  /// Marks come so often on any link, ticks.
  static constexpr Tick kLongestMarkInterval = kTicksPerSecond;
  /// Longest that may be sent ahead, s.
  static constexpr double kMostAhead = 2;
  /// From now on no more may be unacknowledged than a few datagrams, and twice as much with each round trip, until the
  /// link has shown what it carries, or that it is wide enough not to matter.
  void begin_window() {
    if (!window_) window_ = kFirstWindow;
  }
  /// What is told over seconds is to keep within this.
  void bound(double most) { most_ = most; }

  /// The next datagram, of `bytes`, leaves at `now`. `late`: really later, as this peer was held up, so when it arrives
  /// shows nothing of the link.
  void sent(std::size_t bytes, Tick now, bool late = false);
  /// Datagrams whose sending is remembered.
  std::size_t remembered() const { return sent_.size(); }
  /// When the datagram was sent that was followed by `later` others, less than remembered().
  Tick sent_at(std::size_t later) const { return sent_[sent_.size() - 1 - later].at; }
  /// That datagram, the newest so far, has arrived: the window widens.
  void acknowledged(std::size_t later);
  /// The link itself took so long: it arrived at `received` by the receiver's session clock. `loss`: the part of what
  /// was sent lately that did not arrive, 0 to 1.
  void arrived(std::size_t later, Tick received, Tick now, float round_trip, double loss = 0);
  /// Whether a datagram may be sent now. If not, what was to be sent counts as held back.
  bool may_send(Tick now);
  /// Whether new updates may be made for it: neither its queue nor its bound is against it.
  bool may_tell(Tick now);
  double rate() const { return rate_; }
  /// Whether the link was found to carry less than was sent.
  bool is_limited() const { return rate_ < kMost; }
  /// Whether that has held something back of late.
  bool holds_back(Tick now) const { return is_limited() && now - held_at_ < kSpan; }
  /// How long nothing would have to be sent for all that was sent to keep within what is meant for this link, s, from 0
  /// to kMostAhead: its bound, or most of what it carries.
  double ahead(Tick now) const;
  /// Queueing delay that the last acknowledgement showed, ticks; 0 on a link without limit.
  float queue() const { return is_limited() ? queue_ : 0; }
  /// Bytes that take half a second.
  std::size_t half_second() const { return static_cast<std::size_t>(rate() / 2); }
  /// Ticks between marks of `bytes` that take an eighth of the rate, or a second, if that is shorter. While the window
  /// is full, nobody knows how little the link carries: a second.
  Tick mark_interval(std::size_t bytes) const;

 private:
  struct Sent {
    Tick at = 0;
    std::size_t bytes = 0;
    bool late = false;
  };
  struct Receipt {
    std::size_t number = 0;  ///< of the datagram, among all that were sent
    Tick transit = 0;        ///< by two session clocks
  };
  /// Of late, the datagram that was quickest.
  struct Quickest {
    Tick transit = 0;
    std::size_t bytes = 0;
  };
  // The quickest datagram is that of one to two such spans.
  static constexpr Tick kSpan = 10 * kTicksPerSecond;
  static constexpr Tick kNever = -1'000'000;
  // Datagrams whose time of sending is remembered: 4 s at one a tick.
  static constexpr std::size_t kRemembered = 256;
  static constexpr std::size_t kReceipts = 8;
  static constexpr double kFirstWindow = 350;   ///< bytes
  static constexpr double kLastWindow = 4'000;  ///< from here on there is none

  void drain(Tick now);
  bool window_is_full() const { return window_ && unacknowledged_ >= *window_; }
  double meant() const;
  void note_transit(const Quickest& q, Tick now);
  const Quickest& quickest() const;
  float lateness(const Receipt& r) const;
  double explains(const Receipt& r) const;
  float predicted(const Receipt& r, double rate) const;
  double came_through() const;
  float unexplained(double rate) const;
  float longer() const;
  double growth(float longer) const;
  void set_rate(double rate, Tick now);

  Ring<Sent> sent_{kRemembered + 1};
  std::size_t forgotten_ = 0;  ///< datagrams sent before those
  double rate_ = kMost;        ///< the estimate; no limit until a queue shows
  double most_ = kMost;
  std::optional<double> window_;   ///< bytes that may be unacknowledged; nothing: any
  double unacknowledged_ = 0;      ///< bytes sent after what had arrived when there last was a window
  double queued_ = 0;              ///< bytes that wait in the link's queue, by the estimate
  double passed_ = 1;              ///< part of what is sent that the link has carried of late
  double ahead_ = kMostAhead / 4;  ///< s; a beginning is told roughly
  Tick drained_ = 0;               ///< when those were last computed
  Quickest now_quickest_;          ///< in the span that began at span_, and in the one before
  Quickest was_quickest_;
  Tick span_ = kNever;
  float queue_ = 0;
  Ring<Receipt> receipts_{kReceipts + 1};  ///< the latest
  float jitter_ = 0;                       ///< what no rate has explained of them of late, ticks
  int judged_ = 0;                         ///< receipts that went into that
  int too_quick_ = 0;                      ///< receipts in a row that came too quickly to be believed
  Tick changed_ = kNever;                  ///< when the estimate last did
  Tick until_trial_ = 0;                   ///< time without a change after which it grows on trial, ticks
  bool held_back_ = false;                 ///< since the rate last grew
  Tick held_at_ = kNever;                  ///< when something was, last
};

}  // namespace padr::sync
