#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <vector>

#include "common/crowd/address_book.h"

namespace padr::crowd {

/// What is known of a region that is looked for: who has said what of it, and when, in microseconds on the caller's
/// clock.
class Search {
 public:
  /// Who has said so within this is where it said, for all that matters.
  static constexpr Micros kJustNow = 2 * kMicrosPerSecond;
  /// Where those nearest change all the time they change after this, too.
  static constexpr Micros kChanging = 4 * kMicrosPerSecond;

  explicit Search(Micros local) : began_(local), changed_(local) {}

  Micros began() const { return began_; }
  /// When somebody came to be among the nearest.
  Micros changed() const { return changed_; }
  /// When all was known first, which is now.
  Micros settle(Micros local);

  /// Somebody tells others of it, as it has said in answer to an Ask sent then.
  void note_told(const Endpoint& by, Micros sent, Micros local);
  /// What others say of somebody that it has not said itself.
  void note_there(const Endpoint& who, Micros local) { note_first(rumours_[who].there, local); }
  void note_looks(const Endpoint& who, Micros local) { note_first(rumours_[who].looks, local); }
  void note_nearest(const std::vector<Acquaintance*>& nearest, Micros local);
  /// Whether that one has, after it has noted that this peer looks for the region, not before `since`, and just now;
  /// and once more if others have said since that it is there, or looks for it.
  bool has_said(const Acquaintance& a, Micros since, Micros local) const;
  /// Those of whom others say something, and who have not said better themselves.
  std::vector<Acquaintance*> rumoured(AddressBook& book, Micros local) const;

  /// The book is bounded, whatever others say, and so is what is kept of those in it.
  void forget_unknown(AddressBook& book);
  /// Entries that are kept.
  std::size_t sayings() const { return noted_.size() + told_.size() + rumours_.size(); }

 private:
  /// Since when others say it.
  struct Rumour {
    Micros there = Acquaintance::kNever;
    Micros looks = Acquaintance::kNever;  ///< for the region, too
  };
  static void note_first(Micros& when, Micros local) {
    if (when == Acquaintance::kNever) when = local;
  }

  Micros began_;
  Micros changed_;
  Micros settled_ = 0;                ///< 0: it is not
  std::map<Endpoint, Micros> noted_;  ///< who tells others of it, since when at least
  std::map<Endpoint, Micros> told_;   ///< by whom after that, in answer to an Ask sent then
  std::map<Endpoint, Rumour> rumours_;
  std::set<Endpoint> nearest_;
};

}  // namespace padr::crowd
