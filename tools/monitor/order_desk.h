#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/monitor/codec.h"
#include "tools/monitor/peer_record.h"
#include "tools/monitor/site.h"

namespace padr::monitor {

/// Brings orders to peers: each is sent until the peer says what became of it, one after the other; where an avatar is
/// driven is sent again and again, and only the newest counts. Has no clock and no socket.
class OrderDesk {
 public:
  using Sender = std::function<void(const Endpoint& to, const Bytes& datagram)>;

  /// Who is to be told what became of an order.
  struct Ticket {
    ViewerId viewer = 0;
    std::optional<std::uint64_t> id;
    std::string about;
    std::string doubt{};  ///< to be said if all follow it
  };
  struct Outcome {
    Ticket ticket;
    bool ok = true;
    std::string text;  ///< one line
  };

  /// `issuer`: drawn at random, not 0.
  OrderDesk(std::uint64_t issuer, Sender send) : issuer_(issuer), send_(std::move(send)) {}

  enum class Whom : std::uint8_t {
    kAll,  ///< each of them is to follow it
    kOne,  ///< one is: the first that does not refuse
  };
  /// For these peers, which must take orders. Returns false, and does nothing, if one of them has too much to do
  /// already.
  bool give(const std::vector<const PeerRecord*>& peers, const What& what, const Ticket& ticket,
            Whom whom = Whom::kAll);
  /// From now on, until something else is said. A release is an order like others.
  void drive(const PeerRecord& peer, const Drive& drive);
  /// Nobody is driven any more: all are told so.
  void release_all();
  /// The peer has told of this.
  void heard(std::uint64_t process, const Event& event);
  /// Sends what is due. A few dozen times a second.
  void advance(Micros now);
  /// What has come of orders, since the last call.
  std::vector<Outcome> take_outcomes() { return std::exchange(outcomes_, {}); }

  static constexpr Micros kAgain = 100'000;
  static constexpr int kTries = 15;
  static constexpr Micros kDriveAgain = 200'000;
  static constexpr std::size_t kWaiting = 32;  ///< orders for one peer

 private:
  struct Addressee {
    std::uint64_t process = 0;
    PeerId slot = kNoPeer;
    Endpoint to;
    std::uint64_t token = 0;
  };
  struct Errand {
    Ticket ticket;
    Whom whom = Whom::kAll;
    std::set<std::uint64_t> open;   ///< processes
    std::deque<Addressee> instead;  ///< asked one after the other if it is refused
    bool ok = true;
    std::string text;
  };
  struct Item {
    What what;
    std::uint64_t errand = 0;  ///< 0: nobody asks
  };
  struct Lane {
    Addressee whose;
    std::deque<Item> waiting;
    std::uint32_t number = 0;  ///< of the first that waits; 0: not sent yet
    int tries = 0;
    Micros sent_at = 0;
    std::optional<Drive> drive;
    bool drive_new = false;
    Micros driven_at = 0;
  };
  static Addressee addressee(const PeerRecord& peer);
  Lane& lane_of(const Addressee& a);
  void send(const Lane& lane, std::uint32_t number, const What& what);
  enum class Answer : std::uint8_t { kFollowed, kRefused, kNone };
  void done(Lane& lane, Answer answer, const std::string& text);

  std::uint64_t issuer_;
  Sender send_;
  std::uint32_t numbers_ = 0;
  std::map<std::uint64_t, Lane> lanes_;  ///< by process
  std::map<std::uint64_t, Errand> errands_;
  std::uint64_t errands_ever_ = 0;
  std::vector<Outcome> outcomes_;
};

}  // namespace padr::monitor
