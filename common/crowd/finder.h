#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/channel/parcel.h"
#include "common/crowd/address_book.h"
#include "common/crowd/regions.h"
#include "common/crowd/search.h"
#include "common/model/rng.h"

namespace padr::crowd {

/// What a peer can say of itself.
struct Standing {
  Region home;
  std::vector<Region> in;  ///< a member there, or founding it
  Fellows fellows;         ///< the other members of these
  Micros clock = 0;        ///< the crowd's, now; 0: it has none yet
};

struct FinderStats {
  std::uint64_t asks = 0;        ///< sent
  std::uint64_t tells = 0;       ///< sent
  std::uint64_t bytes = 0;       ///< sent, IP and UDP headers included
  std::uint64_t malformed = 0;   ///< received, and no Ask or Tell
  std::uint64_t strange = 0;     ///< Tells that nobody asked for, and whatever is of another crowd
  std::uint64_t unanswered = 0;  ///< Asks that came while too many others did
};

/// Finds out who is in which region, from what peers tell one another; docs/crowds.md, "Finding". Pure: `local` is
/// microseconds on the caller's clock, the same for all calls.
class Finder {
 public:
  struct Config {
    Plane plane;
    std::optional<Endpoint> contact;  ///< of anybody in the crowd; absent: this is the first one
    std::uint64_t seed = 0;           ///< no two peers' are the same
  };
  explicit Finder(const Config& config);

  /// A datagram of no session.
  void receive(const Endpoint& from, std::span<const std::byte> datagram, Micros local);
  /// Whether the next advance() looks at who is with us: always as long as anything is sought, else now and then.
  bool looks_about(const std::vector<Region>& sought, Micros local) const {
    return !sought.empty() || local - looked_about_ >= kLookAbout;
  }
  /// Does what is due; `sought` are the regions that this peer wants to be in and is not. Unless it looks about, it
  /// goes on with the fellows that it was told last.
  void advance(Standing standing, const std::vector<Region>& sought, Micros local);
  /// When to advance next.
  Micros next_due() const { return next_; }

  struct Finding {
    Region region;
    std::optional<Endpoint> member;  ///< absent: nobody is there, and it is this peer's to found
  };
  /// Each region once, until it is sought anew; empty afterwards.
  std::vector<Finding> take_findings();
  std::vector<node::Parcel> take_outgoing();

  /// Coming into the region by that member has failed: others come first for a while.
  void distrust(Region r, const Endpoint& member, Micros local);
  /// Who say that they are in a region that this peer is in, too, but are not among its members.
  std::vector<std::pair<Region, Endpoint>> strangers(Micros local) const;

  /// The crowd's clock as others have told it, us; nothing if nobody has.
  std::optional<Micros> clock(Micros local) const;
  /// Somebody has answered, or nobody was to be asked.
  bool met() const { return met_; }
  /// Why this peer cannot be in the crowd; empty if nothing is known.
  const std::string& failure() const { return failure_; }
  std::size_t acquaintances() const { return book_.size(); }
  /// What is kept of others besides, for the regions that are looked for.
  std::size_t sayings() const;
  const FinderStats& stats() const { return stats_; }

  static constexpr Micros kPace = 50'000;
  static constexpr Micros kLookAbout = 4 * kPace;
  static constexpr Micros kAskAgain = 300'000;
  /// How long those nearest to a region must have been the same.
  static constexpr Micros kSettle = 500'000;
  static constexpr std::size_t kNearest = 4;
  /// Of those who look for the same region so many have to know that this peer does, before it founds it.
  static constexpr std::size_t kRivals = 16;
  /// For who looks for the same region and comes first.
  static constexpr Micros kGiveWay = 12 * kMicrosPerSecond;
  /// Who is in one of this peer's regions for so long, but not among the members, is on another side.
  static constexpr Micros kStranger = 3 * kMicrosPerSecond;

 private:
  struct Question {
    Endpoint to;
    Region about;
    Micros sent = 0;
  };
  void take(const Endpoint& from, const wire::Ask& ask, std::size_t size, Micros local);
  void take(const Endpoint& from, const wire::Tell& tell, Micros local);
  void take_clock(const wire::Tell& tell, Micros sent, Micros local);
  void answer(const Endpoint& to, const wire::Tell& tell, std::size_t size);
  void ask(const Endpoint& to, Region about, Micros local);
  void look(Region r, Search& search, Micros local);
  void hear_say(const wire::Acquaintance& of, const Endpoint& at, Region about, Micros local);
  bool all_said(Region r, Search& search, Micros local);
  bool all_rumoured_said(Region r, Search& search, Micros local);
  bool gives_way(Region r, Micros local);
  std::optional<Endpoint> member_of(Region r, Micros local);
  void keep_acquainted(Micros local);
  bool is_fellow_in(const Endpoint& at, Region r) const;
  void note_strangers(Micros local);
  std::vector<Region> posts() const;
  wire::Whereabouts whereabouts(Region about) const;
  void send(const Endpoint& to, std::span<const std::byte> payload);
  bool may_answer(Micros local);

  Config config_;
  Rng rng_;
  std::uint32_t rank_;
  std::uint64_t crowd_;
  AddressBook book_;
  Standing standing_;
  std::map<Region, Search> searches_;
  std::map<std::uint64_t, Question> questions_;              ///< by nonce
  std::map<std::pair<Region, Endpoint>, Micros> distrust_;   ///< until then
  std::map<std::pair<Region, Endpoint>, Micros> strangers_;  ///< since when they are
  std::vector<Finding> findings_;
  std::vector<node::Parcel> outgoing_;
  std::string failure_;
  FinderStats stats_;
  bool met_ = false;
  bool contact_met_ = false;  ///< the contact has answered
  Micros offset_ = 0;         ///< crowd clock less local
  Micros trip_ = -1;          ///< round trip of the Tell that it is from; -1: there was none
  Micros next_ = 0;
  Micros looked_about_ = Acquaintance::kNever;
  Micros upkeep_ = 0;                     ///< next look at whom to stay acquainted with
  Micros called_ = 0;                     ///< when somebody was asked last for that
  Micros hailed_ = Acquaintance::kNever;  ///< when the contact was asked last
  double answers_ = 0;
  Micros answered_ = 0;
};

}  // namespace padr::crowd
