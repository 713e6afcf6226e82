// The way in of a peer in a session with a key: datagrams of any bytes, handshakes, new keys and sealed ones with right
// tags and with wrong ones, of somebody who is known and of strangers, from several places.
#include <algorithm>

#include "common/channel/secure_channels.h"
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/good.h"

namespace {

using namespace padr;

constexpr std::size_t kHead = 3;  // of each datagram: what to do with it, from where, its length

Endpoint place(unsigned n) {
  return ipv4({10, 0, 0, static_cast<std::uint8_t>(n)}, 7000);
}

node::RandomBytes random_bytes(std::uint64_t seed) {
  return [own = Rng(seed)](std::span<std::byte> out) mutable {
    for (std::byte& b : out) b = static_cast<std::byte>(own.below(256));
  };
}

node::ChannelConfig config(std::uint8_t seed) {
  node::ChannelConfig c;
  c.seed.fill(seed);
  c.session.fill(9);
  c.random = random_bytes(seed);
  c.may_carry = [](const Endpoint&, const Endpoint&, std::size_t) { return true; };
  return c;
}

/// Somebody with the session's key, and the numbers it would have given out itself.
struct Friend {
  explicit Friend(const PublicKey& other)
      : both(*wire::pair_keys(config(1).session, secret, key, other), key < other, 0) {}
  /// What it makes of what it is told.
  void hear(std::span<const std::byte> d, Micros now) {
    const auto message = wire::decode_handshake(d, wire::Key{});
    const auto* rekey = message ? std::get_if<wire::Rekey>(&*message) : nullptr;
    const wire::Key* by = rekey != nullptr ? both.key_of(rekey->generation) : nullptr;
    if (by != nullptr && wire::proves(d, *by, rekey->number)) both.take(*rekey, now, random);
  }

  wire::Key secret = wire::derive_key(config(2).seed, "secret");
  PublicKey key = wire::public_key(secret);
  std::uint64_t number = 1000;
  node::RandomBytes random = random_bytes(2);
  node::ChannelKeys both;
};

/// What it wants for new keys; `what` may change what it says of them.
wire::Bytes rekey(std::uint8_t what, Friend& who, Micros now) {
  wire::Rekey r = who.both.due(now, who.random).value_or(wire::Rekey{who.key, 0, 0, who.both.generation() + 1, 0});
  r.number = ++who.number;
  r.id = wire::short_id(who.key);
  if (what % 16 == 1) ++r.generation;
  if (what % 16 == 2) --r.generation;
  if (what % 16 == 3) ++r.has;
  if (what % 16 == 4) r.exchange = {};
  return wire::encode_handshake(r, who.both.out());
}

wire::Bytes with_right_tag(std::uint8_t what, std::span<const std::byte> bytes, Friend& who, Micros now) {
  const wire::Key h = wire::handshake_key(config(1).session);
  const wire::Key& first = who.both.first().out;
  const wire::Key& own = what % 16 < 12 ? who.both.out() : first;
  wire::Tag cookie{};
  std::copy_n(bytes.begin(), std::min(bytes.size(), cookie.size()), cookie.begin());
  const auto mode = what % 2 == 0 ? wire::SealMode::kAuth : wire::SealMode::kEncrypt;
  switch (what / 2 % 6) {
    case 0:
      return wire::encode_handshake(wire::Hello{who.key, bytes.size()}, h);
    case 1:
      return wire::encode_handshake(wire::Cookie{who.key, bytes.size(), cookie}, h);
    case 2:
      return wire::encode_handshake(wire::Introduction{who.key, ++who.number, cookie}, own);
    case 3:
      return wire::encode_handshake(wire::Acceptance{who.key, ++who.number}, own);
    case 4:
      return rekey(what, who, now);
    default:
      return wire::seal_with(own, mode, wire::short_id(who.key), ++who.number,
                             wire::seal({wire::Kind::kSession, what, 1}, bytes));
  }
}

/// The same as something that a third one passes on, for this peer or for whoever it names.
wire::Bytes carried(std::uint8_t what, const wire::Bytes& d, Friend& who, const PublicKey& to) {
  wire::Bytes plain;
  wire::encode_carried({what % 4 == 0 ? what : wire::short_id(to), d}, plain);
  return wire::seal_with(who.both.out(), wire::SealMode::kAuth, wire::short_id(who.key), ++who.number, plain);
}

}  // namespace

padr::wire::Bytes padr::test::good_input(Rng& rng) {
  wire::Bytes all;
  for (int i = 0; i < 30; ++i) {
    const std::uint32_t size = rng.below(120);
    all.push_back(static_cast<std::byte>(rng.below(256)));
    all.push_back(static_cast<std::byte>(rng.below(4)));
    all.push_back(static_cast<std::byte>(size));
    for (std::uint32_t k = 0; k < size; ++k) all.push_back(static_cast<std::byte>(rng.below(256)));
  }
  return all;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  node::SecureChannels channels(config(1));
  Friend known(channels.key());
  Micros now = 0;
  for (int i = 0; size > kHead && i < 200; ++i) {
    const std::uint8_t what = data[0];
    const Endpoint from = place(data[1] % 4);
    const std::size_t length = std::min<std::size_t>(data[2], size - kHead);
    const auto bytes = test::bytes(data + kHead, length);
    data += kHead + length;
    size -= kHead + length;
    now += kMicrosPerSecond / 10;
    if (what < 32) {
      Endpoint to = from;
      if (what < 16) to.key = known.key;
      if (what < 4) channels.carry(known.key, what < 2 ? known.key : channels.key(), what % 2 == 0, now);
      channels.send(to, kNoPeer, wire::seal({}, bytes), now);
    } else if (what < 64) {
      channels.receive(from, bytes, now);
    } else {
      wire::Bytes d = with_right_tag(what, bytes, known, now);
      if (what >= 200 && !bytes.empty()) d[std::to_integer<std::size_t>(bytes[0]) % d.size()] ^= std::byte{1};
      if (what % 5 == 4) d = carried(what, d, known, channels.key());
      channels.receive(from, d, now);
    }
    for (const node::Parcel& p : channels.take_outgoing()) {
      if (p.bytes.size() > wire::kMaxCarried || p.to.has_key()) __builtin_trap();
      known.hear(p.bytes, now);
    }
  }
  return 0;
}
