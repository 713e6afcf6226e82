#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/channel/channel_keys.h"
#include "common/channel/outbox.h"
#include "common/channel/parcel.h"
#include "common/channel/replay_window.h"
#include "common/wire/handshake.h"

namespace padr::node {

/// `seed` and `random` must be set, and `mode` must not be kNone: that is asserted.
struct ChannelConfig {
  wire::Key session{};  ///< the session's key
  /// 32 bytes that nobody can guess and no other run of the program has, so not zeros: the secret key and the cookies
  /// come of them.
  wire::Key seed{};
  /// For new keys and the nonces of Hellos. It is asked each time, so that two processes that are restored from one
  /// snapshot of a machine get different bytes.
  RandomBytes random;
  wire::SealMode mode = wire::SealMode::kAuth;  ///< of what goes out; not kNone
  /// Told of the keys of those who have proven theirs, or whom we were told of, and of each new key: once for each
  /// direction, who sends, who receives (public keys), and the key. So many pairs at most: whoever has the session's
  /// key can come under any number of names.
  std::function<void(const PublicKey& from, const PublicKey& to, const wire::Key& key)> on_key;
  std::size_t most_keys = 65'536;
  /// Whether a datagram of so many bytes of one peer is passed on to another one. Empty: none is; a Participant then
  /// decides itself.
  std::function<bool(const Endpoint& from, const Endpoint& to, std::size_t bytes)> may_carry{};
};

/// Why a datagram went no further.
enum class ChannelDrop : std::uint8_t {
  kForm,      ///< not of this protocol and version
  kUnsealed,  ///< of this protocol, without a seal
  kStranger,  ///< sealed by somebody with whom there are no keys
  kReplay,    ///< has been here, or is too old to tell
  kTag,       ///< tampered with, or made with another key
  kCookie,    ///< an introduction from an address that has not proven itself
  kFull,      ///< no room for yet another peer
};
inline constexpr std::size_t kChannelDrops = 7;
inline constexpr std::array<std::string_view, kChannelDrops> kChannelDropNames{"form", "unsealed", "stranger", "replay",
                                                                               "tag",  "cookie",   "full"};

struct ChannelStats {
  std::uint64_t datagrams = 0;  ///< that came
  std::uint64_t passed = 0;
  std::uint64_t handshakes = 0;     ///< messages of it that were right
  std::uint64_t rekeys = 0;         ///< times that a channel went over to new keys
  std::uint64_t moves = 0;          ///< peers that were found at another address than before
  std::uint64_t carried = 0;        ///< datagrams of others that this peer has passed on
  std::uint64_t carried_bytes = 0;  ///< of those, as they went out
  std::uint64_t declined = 0;       ///< datagrams of others that it has not
  /// Passed datagrams that anybody on their way could read, though this peer encrypts what it sends.
  std::uint64_t readable = 0;
  std::array<std::uint64_t, kChannelDrops> dropped{};
};

/// Between the network and a peer in a session with a key: seals what goes out, and lets in what was sealed by somebody
/// who has the session's key, for us, once. Whoever comes in is named by place and public key; a peer whose place
/// changes keeps its name. Whoever passes datagrams on can make it seem to have moved, so that what is for it goes to
/// where it was, too, until enough has come from the new place; and until it has answered from there, little is sent
/// there.
///
/// What is for a peer whose link does not work can go through another one that both reach. It is sealed for its
/// receiver, and once more for who carries it, who sees neither what is in it nor can change it.
///
/// Two programs get to know one another's keys by a handshake, or from others whom they know: endpoints that carry a
/// key are enough to begin with, and the handshake goes on beside until there is an answer. Everything is repeated by
/// those who send: there are no timers here.
class SecureChannels {
 public:
  explicit SecureChannels(ChannelConfig config);

  const PublicKey& key() const { return public_; }
  /// Of the same pair.
  wire::SigningKey signing_key() const { return wire::signing_key(secret_); }

  struct Arrival {
    Endpoint from;
    std::span<const std::byte> datagram;  ///< unsealed; until the next one arrives
    bool carried = false;                 ///< another peer has passed it on
  };
  /// A datagram has arrived from `place`.
  std::optional<Arrival> receive(const Endpoint& place, std::span<const std::byte> datagram, Micros local);
  /// Seals an unsealed datagram for whoever `to` names; without a key in it, for whoever is found at that place.
  /// `state_to`: as in Parcel.
  void send(const Endpoint& to, PeerId state_to, std::span<const std::byte> datagram, Micros local);
  /// What is for one peer goes through another one for the next kCarries. Meanwhile a state datagram now and then goes
  /// directly, too, so that both can see whether their link works again; or all datagrams, if `directly_too`, though
  /// state datagrams by one way only, in turn, where one follows another within kClosely. With each of the former, a
  /// Hello goes to every one of `elsewhere`, where the peer says that it is.
  void carry(const PublicKey& to, const PublicKey& by, bool directly_too, Micros local,
             std::span<const Endpoint> elsewhere = {});
  /// Another peer says that somebody with this key is at this place since so long ago: sends a few Hellos there, and
  /// opens what comes of it.
  void expect(const Endpoint& somebody, Micros since, Micros local);
  /// By which ways something of a peer has come lately.
  struct Came {
    bool directly = false;  ///< and what is sent to it comes there
    bool carried = false;
  };
  Came came(const PublicKey& of, Micros local) const;
  /// Whether somebody who has the session's key has lately been heard at this place.
  bool hears(const Endpoint& place, Micros local) const;
  /// Where a peer is, by what it sent last; not set if it is not known.
  Endpoint place(const PublicKey& of) const;
  /// What to send, by place, in order, since the last time; until the next call of anything.
  std::span<const Parcel> take_outgoing() { return outgoing_.take(); }

  const ChannelStats& stats() const { return stats_; }
  /// Peers whose first readable datagram came since the last call, in a peer that encrypts what it sends.
  std::vector<Endpoint> take_readable() { return std::exchange(readable_, {}); }
  std::size_t channels() const { return channels_.size(); }
  /// Places that were sent something, and of which nobody's key is known yet.
  std::size_t callers() const { return callers_.size(); }

  static constexpr std::size_t kMostChannels = 256;
  static constexpr std::size_t kMostWaiting = 8;
  /// No more keys are told.
  bool has_told_all_keys() const { return keys_told_ == config_.most_keys; }
  static constexpr int kSettled = 8;
  static constexpr Micros kCarries = 250'000;
  /// A link that does not work is tried after this time, and after twice that, until kTrySlowest.
  static constexpr Micros kTryAgain = 1'000'000;
  static constexpr Micros kTrySlowest = 4'000'000;
  /// Hellos to somebody who is expected: between two of them, and until the last.
  static constexpr Micros kKnockAgain = 300'000;
  static constexpr Micros kKnocks = 700'000;
  /// To a place that a peer seems to have moved to, at most so many times the bytes that came from there are sent until
  /// it has echoed a nonce.
  static constexpr std::size_t kUnprovenTimes = 3;
  /// Peers that made room for others, and whose datagrams do not pass a second time all the same; the latest so many.
  static constexpr std::size_t kMostForgotten = 65'536;

 private:
  /// Somebody whose public key we know.
  struct Channel {
    Channel(const PublicKey& whose, const ChannelKeys& both) : key(whose), id(wire::short_id(whose)), keys(both) {}
    PublicKey key;
    std::uint32_t id;
    ChannelKeys keys;
    PeerId number = kNoPeer;  ///< as which it was sent a state datagram last
    Endpoint name;            ///< as we were told of it, or first met it
    Endpoint at;              ///< where it is, by what it sent last
    Endpoint home;            ///< where it was before, until it has settled there
    int here = 0;             ///< of its newest datagrams in a row, how many came from there; counted to kSettled
    /// It answers at `at`: it has echoed a nonce that was sent there, or `at` is where we were told that it is.
    bool answers = true;
    bool mutual = false;     ///< an echo has shown that what either sends comes directly to the other, which is at `at`
    std::size_t credit = 0;  ///< until then: bytes that may be sent there
    NumberWindow<4096> window;
    bool met = false;                 ///< something of it has come
    bool readable = false;            ///< something readable of it has come to a peer that encrypts
    Micros heard = 0;                 ///< when, or when we began
    Micros direct = kNever;           ///< when something came that nobody had carried
    Micros carried = kNever;          ///< when something came that somebody had
    bool hearsay = false;             ///< only others have said where it is
    PublicKey carrier{};              ///< who carries what is for it
    Micros carried_until = kNever;    ///< until then
    bool directly_too = false;        ///< and it is sent there, too
    Micros posted = kNever;           ///< when a state datagram was, last
    bool turn = false;                ///< it went directly only
    std::vector<Endpoint> elsewhere;  ///< where it says that it is, too
    Micros tried = kNever;            ///< then: when something was sent directly all the same
    Micros try_again = kTryAgain;     ///< after so long
    Micros greeted = kNever;
    std::uint64_t nonce = 0;  ///< of the last Hello; 0: none is out
    std::optional<wire::Tag> cookie;
    Micros baked = 0;          ///< when the cookie came
    std::uint64_t rekeys = 0;  ///< as many as have been counted
    int in_vain = 0;           ///< introductions by later keys than the first, since it was heard last
  };
  /// Somebody of whom we know only the place.
  struct Caller {
    Endpoint place;
    std::uint64_t nonce = 0;
    Micros greeted = kNever;
    Micros since = 0;
    Parcel waiting;  ///< what was to be sent last
  };
  static constexpr Micros kNever = -(Micros{1} << 60U);
  /// Whoever has said nothing for so long is greeted anew.
  static constexpr Micros kQuiet = 2'000'000;
  /// A cookie is good for this long at its maker's, and then some.
  static constexpr Micros kCookieAge = 10'000'000;

  Channel* known(const PublicKey& key);
  Channel* lately_at(const Endpoint& place, Micros local);
  Channel* make(const PublicKey& key, const Endpoint& at, Micros local);
  /// What would be kept of somebody; nothing if it is no key.
  std::optional<Channel> channel_to(const PublicKey& key, const Endpoint& at, Micros local) const;
  /// Without forgetting anybody who was there a moment ago.
  bool has_room(Micros local);
  std::list<Channel>::iterator quietest(Micros local);
  /// A channel that was made just now. Room makes whoever may be forgotten, else who never said anything, else who has
  /// been quiet for the longest.
  Channel& keep(const Channel& c);
  void make_room(Micros local);
  void tell_keys(const PublicKey& whose, const wire::PairKeys& keys);
  void greet(const Endpoint& place, std::uint64_t& nonce, Micros& greeted, Micros pace, Micros local);
  void call(const Endpoint& to, PeerId state_to, std::span<const std::byte> datagram, Micros local);
  void post(Channel& to, PeerId state_to, std::span<const std::byte> datagram);
  void transmit(Channel& to, PeerId state_to, std::span<const std::byte> sealed);
  void transmit_directly(Channel& to, PeerId state_to, std::span<const std::byte> sealed);
  bool is_carried(const Channel& c) const { return local_ < c.carried_until; }
  void try_directly(Channel& to, PeerId state_to, std::span<const std::byte> datagram);
  std::optional<Arrival> take_carried(const Channel& by);
  void pass_on(const Channel& by, std::uint32_t to);
  /// `place`: null if another peer has carried it.
  std::optional<Arrival> open(const Endpoint* place, std::span<const std::byte> datagram);
  std::optional<Arrival> open_handshake(const Endpoint* place, std::span<const std::byte> datagram);
  void introduce(Channel& to, Micros local);
  void accept(Channel& to);
  /// Asks for new keys if it is time.
  void renew(Channel& c, Micros local);
  void tell(Channel& to, wire::Rekey rekey);
  void keep_company(Channel& c, Micros local);
  void heard(Channel& c, const Endpoint* place, std::uint64_t number, std::size_t bytes, Micros local);
  void note_place(Channel& c, const Endpoint& place, bool newest, std::size_t bytes, Micros local);
  void challenge(Channel& c, Micros local);
  void answered(Channel& c, const Endpoint& place);
  bool may_send_there(Channel& c, std::size_t bytes);
  void note_mode(Channel& c, wire::SealMode mode);
  wire::Tag cookie_for(const Endpoint& place, const PublicKey& key, std::int64_t age) const;
  std::optional<Arrival> drop(ChannelDrop why);
  /// That a datagram with this number is new, and of whom it says; counts it as dropped if not.
  bool proven(Channel& c, std::uint64_t number, std::span<const std::byte> datagram, Micros local);
  /// The same of an introduction, which may go back to the first keys.
  bool introduced(Channel& c, std::uint64_t number, std::span<const std::byte> datagram, Micros local);
  void take(const Endpoint& place, const wire::Hello& hello, Micros local);
  void take(const Endpoint& place, const wire::Cookie& cookie, Micros local);
  void take(const Endpoint& place, const wire::Introduction& in, std::span<const std::byte> datagram, Micros local);
  void take(const Endpoint* place, const wire::Acceptance& in, std::span<const std::byte> datagram, Micros local);
  void take(const Endpoint* place, const wire::Rekey& in, std::span<const std::byte> datagram, Micros local);
  void count_rekeys(Channel& c);
  void follow(Channel& c, const wire::Rekey& in, Micros local);

  ChannelConfig config_;
  wire::Key secret_;
  PublicKey public_;
  std::uint32_t id_;
  wire::Key handshake_;
  wire::Key cookies_;
  std::uint64_t number_ = 0;  ///< of the last datagram sealed, for whomever
  std::list<Channel> channels_;
  /// The newest number of each peer that made room for another one, and their keys in the order of that.
  std::map<PublicKey, std::uint64_t> forgotten_;
  std::deque<PublicKey> forgotten_order_;
  std::list<Caller> callers_;
  std::size_t keys_told_ = 0;
  Outbox outgoing_;
  wire::Bytes sealed_;    ///< what is being sent
  wire::Bytes unsealed_;  ///< what has arrived
  wire::Bytes carried_;   ///< what is carried
  wire::Bytes outer_;     ///< that, sealed for who carries it
  Micros local_ = 0;      ///< of the last call
  ChannelStats stats_;
  std::vector<Endpoint> readable_;
};

}  // namespace padr::node
