#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "common/model/endpoint.h"
#include "common/sync/transfer.h"

namespace padr::lab::audit {

/// One peer in one slot, as the traces know it.
struct Member {
  PeerId slot = kNoPeer;
  std::uint32_t incarnation = 0;
  PublicKey key{};  ///< all zeros: not known, or the session has no key
  Tick since = -1;  ///< of its admission; -1: not known
  bool has_key() const { return key != PublicKey{}; }
};

/// Place of a member in Members.
using MemberId = std::size_t;

/// Who has sat in which slot. Each trace knows some of the members; those that several traces know are one. The two
/// sides of a partition may give the same incarnation to two newcomers: the key, or else the tick of the admission,
/// tells them apart.
class Members {
 public:
  explicit Members(std::size_t traces) : seats_(traces) {}

  /// A trace knows this member, whose updates have numbers from `first` on.
  MemberId note(std::size_t trace, const Member& member, std::uint32_t first);
  /// An update says who comes in.
  void note_admission(std::size_t trace, const sync::Admission& admission, Tick tick);
  /// What a peer begins with says who is there.
  void note_transfer(std::size_t trace, const sync::Transfer& start);

  /// Who sits there, as the trace knows it; nothing if it does not.
  std::optional<MemberId> sitter(std::size_t trace, PeerId slot, std::uint32_t incarnation) const;
  /// Whose update that number is; nothing if the trace does not know.
  std::optional<MemberId> author(std::size_t trace, PeerId slot, std::uint32_t index) const;

  const Member& operator[](MemberId m) const { return all_[m]; }
  std::size_t size() const { return all_.size(); }

 private:
  struct Seat {
    std::uint32_t first = 0;
    MemberId member = 0;
  };
  MemberId find_or_add(const Member& member);

  std::vector<Member> all_;
  std::vector<std::map<PeerId, std::vector<Seat>>> seats_;  ///< by trace, then slot; in the order heard
};

}  // namespace padr::lab::audit
