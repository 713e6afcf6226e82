#pragma once

#include <limits>
#include <string_view>
#include <vector>

#include "common/session/session_state.h"

namespace padr::node {

/// The second part of joining a session, after a Welcome: synchronises the clock with the introducer, pulls the agreed
/// world piece by piece, and then asks to be admitted. Lost messages are repeated; less and less is asked for, and ever
/// more rarely, while nothing comes: the link may be narrow.
class TransferPull {
 public:
  /// `by` has welcomed our Join.
  TransferPull(SessionState& session, const Endpoint& by, const wire::Welcome& welcome, Micros local);

  void on_pong(const Endpoint& from, const wire::Pong& pong, Micros local);
  void on_piece(const Endpoint& from, const wire::Piece& piece, Micros local);
  /// The introducer is no longer the coordinator.
  void on_redirect(const Endpoint& from, const wire::Redirect& redirect);
  /// The machine at `at` reports that nobody listens there.
  void on_unreachable(const Endpoint& at);
  void advance(Micros local);
  /// Asks for the time: often until there are enough samples, then rarely, to see whether the introducer is alive.
  void measure(Micros local);
  /// The session's clock is ahead of ours by this at least, us, whatever the introducer says.
  void clock_is_ahead(Micros at_least);
  /// Asks to be admitted from now on.
  void enter(Micros local);

  /// The transfer is complete, and the session's clock is set.
  bool ready() const { return ready_; }
  const wire::Bytes& transfer() const { return transfer_; }
  /// The introducer has ended, fallen silent, stopped sending pieces, redirected us, told times that do not fit each
  /// other, or not let us in for kLongest.
  bool lost() const { return !lost_.empty(); }
  const Endpoint& by() const { return by_; }
  Micros round_trip() const { return offset_.round_trip(); }

  static constexpr Micros kPing = 10'000;  ///< twice that, and again, after every kSamples without an answer
  static constexpr Micros kIdlePing = 500'000;
  static constexpr Micros kOldestPong = 5'000'000;
  static constexpr std::size_t kSamples = 8;
  static constexpr Micros kAgain = 50'000;    ///< between the first Enters, and from the last piece to a Pull at least
  static constexpr Micros kRarely = 200'000;  ///< between two Enters after kOften of them
  static constexpr int kOften = 4;
  static constexpr std::size_t kDoublings = 6;    ///< of the time between Pings at most
  static constexpr int kPullDoublings = 2;        ///< of the time between Pulls at most
  static constexpr int kMostWanted = 64;          ///< pieces that a Pull asks for
  static constexpr Micros kPatience = 2'500'000;  ///< longest silence of the introducer
  static constexpr int kMostFruitless = 8;        ///< Pulls in a row without a new piece, after the first one
  /// Time from the Welcome to the admission after which this peer asks anew: as long as the last of 63 waits for its
  /// turn, and 8 s, after which an honest introducer forgets it.
  static constexpr Micros kLongest = 40'000'000;

 private:
  void pull(Micros local);
  void set_clock();
  void lose(std::string_view by);
  std::string_view why_late(Micros local) const;
  bool pull_is_due(Micros local) const;
  bool comes_to_nothing(Micros local) const;
  void finish_if_complete();

  SessionState& session_;
  Endpoint by_;
  std::uint64_t nonce_;
  std::uint64_t cookie_;
  Micros begun_;
  OffsetEstimator offset_;
  Micros least_offset_ = std::numeric_limits<Micros>::min();
  std::vector<wire::Bytes> pieces_;
  std::size_t missing_ = 0;
  wire::Bytes transfer_;
  Micros heard_;
  Micros pinged_ = 0;
  Micros pulled_ = 0;
  Micros came_ = 0;     ///< when a piece last came that was missing
  int want_ = 4;        ///< pieces that the next Pull asks for: twice as many if all have come, half if none has
  int wanted_ = 0;      ///< of those that the last one asked for, pieces that have not come
  int fruitless_ = 0;   ///< Pulls in a row that nothing has come of
  int unanswered_ = 0;  ///< Pings in a row
  int entries_ = 0;     ///< Enters sent
  Micros entered_ = 0;
  bool ready_ = false;
  bool entering_ = false;
  std::string_view lost_;  ///< by what the introducer is lost; empty: it is not
};

}  // namespace padr::node
