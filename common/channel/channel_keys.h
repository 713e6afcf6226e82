#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "common/model/ids.h"
#include "common/wire/handshake.h"

namespace padr::node {

/// Fills all bytes with what nobody can guess and no copy of this process draws, too.
using RandomBytes = std::function<void(std::span<std::byte>)>;

/// The keys of two peers as time goes on; proto/WIRE.md, section 14, "New keys". Each of the two makes a new X25519
/// pair and tells the public half. Whoever has both makes the next keys of them and of the present ones. It uses the
/// next keys once it knows that the other can make them, too. Until then the present ones stay, for ever if need be.
///
/// To open with there are two keys at most: the present one, and either the next one or the former one. The former one
/// stays until kOverlap after the other was first heard to use the present one.
class ChannelKeys {
 public:
  /// `begins`: of the two, the one that asks for new keys when it is time; the other waits for kPatience first.
  ChannelKeys(const wire::PairKeys& first, bool begins, Micros local);

  /// What to seal with.
  const wire::Key& out() const { return present_.out; }
  /// 0: the first keys, which a later thief of this peer's memory could make again.
  std::uint32_t generation() const { return generation_; }
  /// The first keys.
  const wire::PairKeys& first() const { return first_; }

  /// Calls `opens` with one key to open with after the other, until it returns true. Then the other peer is known to
  /// use this key. Whether one did.
  template <typename Opens>
  bool open(const Opens& opens, Micros local) {
    forget(local);
    if (opens(present_.in)) {
      confirm(local);
      return true;
    }
    if (next_ && opens(next_->keys.in)) {
      advance(local);
      confirm(local);
      return true;
    }
    return former_in_ && opens(*former_in_);
  }

  /// Whether the other peer may not know yet that this one has gone on from the first keys.
  bool may_lag(Micros local) const { return generation_ == 1 && !confirmed_ && local - began_ < kLag; }
  /// Back to the first keys: the other peer has no later ones any more.
  void restart(Micros local);

  /// What to tell the other peer now on our own account; nothing if it is not time. The number and the short id are the
  /// caller's to fill in. It is sealed with out().
  std::optional<wire::Rekey> due(Micros local, const RandomBytes& random);

  /// The key that a Rekey of this generation has its tag by; null if there is none.
  const wire::Key* key_of(std::uint32_t generation) const;
  struct Answer {
    std::optional<wire::PairKeys> made;  ///< keys that are new
    std::optional<wire::Rekey> rekey;    ///< to send, as in due()
    bool confirm = false;  ///< an Acceptance by out() is to be sent: the other does not know that we follow
  };
  /// Takes in what the other peer has told; its tag is right by key_of(), and it is new.
  Answer take(const wire::Rekey& theirs, Micros local, const RandomBytes& random);

  /// Wipes a former key whose time is over.
  void forget(Micros local);

  std::uint64_t rekeys() const { return rekeys_; }

  /// The first new keys are made at once, the others after this time.
  static constexpr Micros kEvery = 120 * kMicrosPerSecond;
  static constexpr Micros kPatience = 10 * kMicrosPerSecond;
  /// For datagrams under way.
  static constexpr Micros kOverlap = 5 * kMicrosPerSecond;
  /// For an answer to come: that a peer still uses the first keys says nothing sooner.
  static constexpr Micros kLag = 2 * kMicrosPerSecond;
  /// Between two Rekeys at first; it doubles until kSlowest.
  static constexpr Micros kAgain = 200'000;
  static constexpr Micros kSlowest = 10 * kMicrosPerSecond;
  /// From one generation to the next: whoever asks sooner is not followed.
  static constexpr Micros kSoonest = kOverlap;

 private:
  /// Our half of the next keys.
  struct Offer {
    wire::Key secret;
    PublicKey exchange{};
  };
  struct Next {
    wire::PairKeys keys;
    PublicKey exchange{};  ///< the other's
    std::uint64_t number = 0;
  };
  void offer(const RandomBytes& random);
  bool make(const wire::Rekey& theirs);
  wire::Rekey told() const;
  void advance(Micros local);
  void confirm(Micros local);

  wire::PairKeys first_;
  wire::PairKeys present_;
  std::optional<wire::Key> former_in_;
  std::optional<Offer> offer_;
  std::optional<Next> next_;
  std::uint32_t generation_ = 0;
  bool begins_;
  bool confirmed_ = true;     ///< the other is known to use the present keys
  Micros since_ = 0;          ///< when that was
  Micros began_ = 0;          ///< the generation, here
  PublicKey exchange_{};      ///< the other's, which the present keys are made of
  std::uint64_t number_ = 0;  ///< of the message that told it
  Micros again_ = 0;          ///< when to tell of our offer again
  Micros pace_ = kAgain;
  std::uint64_t rekeys_ = 0;
};

}  // namespace padr::node
