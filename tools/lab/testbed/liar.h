#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/channel/parcel.h"
#include "common/channel/secure_channels.h"
#include "common/sync/packet.h"
#include "common/wire/membership_codec.h"
#include "common/wire/session_codec.h"
#include "common/wire/signature.h"

namespace padr::lab {

/// A peer whose program is an honest peer's but for what leaves it: from some moment on its datagrams are changed,
/// withheld or joined by others on their way out, sealed and signed with its own keys.
class Liar {
 public:
  /// May change a state packet before it goes to member `to`; nothing is signed yet.
  using Lie = std::function<void(sync::StatePacket& packet, PeerId to)>;
  /// Unsealed datagrams to send besides a state datagram with this header, which goes to member `to`.
  using Extra = std::function<std::vector<wire::Bytes>(const wire::Header& header, PeerId to)>;
  /// Whether an unsealed datagram of this kind to this place is not sent; `to` as in Parcel.
  using Silence = std::function<bool(wire::Kind kind, const Endpoint& place, PeerId to)>;

  /// Changes what the liar says with every state datagram from now on.
  void begin(Lie lie) { lie_ = std::move(lie); }
  /// What it sends besides, each time that it sends a state datagram.
  void send_too(Extra extra) { extra_ = std::move(extra); }
  /// May change what it says about who is there.
  void speak_of_others(std::function<void(wire::MembershipMessage&)> lie) { gossip_ = std::move(lie); }
  /// May change what it says to joiners, and as one.
  void speak_to_joiners(std::function<void(wire::SessionMessage&)> lie) { hosting_ = std::move(lie); }
  /// Withholds datagrams. Asked before anything else.
  void withhold(Silence silence) { silence_ = std::move(silence); }
  /// Is honest from now on.
  void stop() { lie_ = {}, extra_ = {}, gossip_ = {}, hosting_ = {}, silence_ = {}; }

  /// Whether lies are signed as what they are: the liar's.
  bool signs = true;
  std::uint64_t told = 0;  ///< datagrams changed, added or withheld

  /// The key that the peer with these channels signs with.
  void learn_key(const node::ChannelConfig& channels) {
    const wire::Key secret = wire::derive_key(channels.seed, "secret");
    key_ = wire::signing_key(secret);
    public_key_ = wire::public_key(secret);
    sealed_ = true;
  }
  /// The session that its signatures are for.
  void learn_session(const SessionId& id) { id_ = id; }
  const wire::SigningKey& key() const { return key_; }
  const PublicKey& public_key() const { return public_key_; }
  /// Signs an update in the liar's name, or not, as `signs` says.
  void sign(sync::Bundle& update, std::uint32_t incarnation) const {
    if (sealed_ && signs) update.signature = wire::sign_update(key_, {id_, incarnation}, update);
  }

  /// For ParticipantConfig::tamper.
  std::vector<node::Parcel> tamper(node::Parcel parcel);

 private:
  bool says_nothing() const { return !lie_ && !extra_ && !gossip_ && !hosting_ && !silence_; }
  void change_state(node::Parcel& parcel, const wire::Opened& opened);
  void change_membership(node::Parcel& parcel, const wire::Opened& opened);
  void change_session(node::Parcel& parcel, const wire::Opened& opened);

  Lie lie_;
  Extra extra_;
  std::function<void(wire::MembershipMessage&)> gossip_;
  std::function<void(wire::SessionMessage&)> hosting_;
  Silence silence_;
  wire::SigningKey key_;
  PublicKey public_key_{};
  SessionId id_{};
  bool sealed_ = false;
};

}  // namespace padr::lab
