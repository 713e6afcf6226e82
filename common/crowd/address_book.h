#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/crowd/regions.h"
#include "common/model/endpoint.h"
#include "common/model/rng.h"
#include "common/wire/session_codec.h"

namespace padr::crowd {

/// Somebody else in the crowd, as far as is known here.
struct Acquaintance {
  static constexpr Micros kNever = std::numeric_limits<Micros>::min() / 2;

  Endpoint at;
  std::vector<Region> in;     ///< is a member there
  std::vector<Region> seeks;  ///< wants to be, and knows nobody who is
  std::uint32_t rank = 0;
  bool fellow = false;          ///< is in a region with us
  Micros heard = kNever;        ///< it said so itself, in answer to us
  Micros hinted = kNever;       ///< another one, or one who has not proven its address, said so
  Micros asked = kNever;        ///< last
  Micros asked_first = kNever;  ///< of the Asks not answered since
  int unanswered = 0;           ///< Asks in a row

  bool is_in(Region r) const;
  bool looks_for(Region r) const;
};

/// Who is in which region, each pair once, in their order.
using Fellows = std::vector<std::pair<Endpoint, Region>>;

/// Whom a peer knows in the crowd, by address: those who have said something of themselves lately, and hints. Bounded,
/// whatever others say.
class AddressBook {
 public:
  static constexpr std::size_t kMost = 256;
  static constexpr std::size_t kMostAround = 48;
  static constexpr Micros kFresh = 20 * kMicrosPerSecond;  ///< and it is passed on
  static constexpr Micros kHint = 10 * kMicrosPerSecond;   ///< until it has to have answered
  static constexpr int kTries = 4;       ///< Asks in a row without an answer, over kPatience, and it has ended
  static constexpr int kTriesKnown = 8;  ///< if it has ever answered: who is overlooked may be in the region sought
  static constexpr Micros kPatience = 1'500'000;

  /// Null if it is not known.
  Acquaintance* find(const Endpoint& at);
  /// Null if it is not known and there is no room: who has said something of itself does not give way to a hint.
  Acquaintance* note(const Endpoint& at);
  void forget(const Endpoint& at) { all_.erase(at); }
  void expire(Micros local);
  /// Who is in a region with us, and where as far as we see: the others are not any more.
  void set_fellows(const Fellows& fellows);

  // Of those who have not ended:

  /// Those in r or next to it, kMostAround at most, and as many others as make them n: the nearest, without those who
  /// look for r.
  std::vector<Acquaintance*> nearest(Region r, std::size_t n);
  /// Those who look for it, the lowest ranks first; n at most.
  std::vector<Acquaintance*> rivals(Region r, std::size_t n);
  /// Whom to tell somebody of who asks about r, n at most: who is there, who looks for it, who is near.
  std::vector<Acquaintance*> to_tell_of(Region r, std::size_t n, Rng& rng);
  /// The nearest one in each of eight directions from r, without those who are in r alone.
  std::vector<Acquaintance*> all_around(Region r);
  std::vector<Acquaintance*> all();
  std::size_t size() const { return all_.size(); }

  static bool fresh(const Acquaintance& a, Micros local) { return a.fellow || local - a.heard < kFresh; }
  static bool ended(const Acquaintance& a) {
    const int tries = a.heard == Acquaintance::kNever ? kTries : kTriesKnown;
    return !a.fellow && a.unanswered >= tries && a.asked - a.asked_first >= kPatience;
  }

 private:
  std::map<Endpoint, Acquaintance> all_;
};

/// Squared distance of two regions that have a corner in common, the farthest next to one another.
inline constexpr std::int64_t kNextTo = 2;

/// Between the middles of two regions, in sides of a region, squared.
std::int64_t squared_distance(Region a, Region b);
/// From the nearest region that it is in; the largest number if there is none.
std::int64_t squared_distance(const Acquaintance& a, Region r);

}  // namespace padr::crowd
