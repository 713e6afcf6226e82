// Peers in a session with a key, among whose real datagrams somebody does what a script says.
//
// An outsider has the network, but no key: it damages, cuts, joins, repeats, reflects and redirects what it saw, brings
// what it saw of another session, and loses some. Nothing of that passes, and the session goes on undisturbed.
//
// A member has keys: its own datagrams are changed before they are sealed. If it tells everybody the same lies about
// the world, the others agree on it as they agree on the truth. If it tells one this and another that, they may come to
// differ until that is repaired, so that only whether they survive it is looked at.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <optional>

#include "common/wire/codec.h"
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/good.h"
#include "tests/fuzz/small_net.h"

namespace {

using namespace padr;
using test::Passing;
using test::SmallNet;

constexpr std::size_t kHead = 2;   // what kind of script, how they seal
constexpr std::size_t kEntry = 6;  // bytes: what, which, where, how far in, by what, turns until the next
constexpr std::size_t kMostEntries = 40;
constexpr int kQuietTurns = 30;  // at the end, for all to hear from one another again
constexpr int kMostTurns = 180;  // at the end, for what was lost to be noticed and repeated

struct Entry {
  std::uint8_t what, which, where, at, by, turns;
};

void damage(wire::Bytes& bytes, const Entry& e) {
  if (!bytes.empty())
    bytes[(e.at + std::size_t{256} * (e.where >> 6U)) % bytes.size()] ^= static_cast<std::byte>(e.by | 1U);
}

wire::Bytes joined(const wire::Bytes& a, const wire::Bytes& b, std::size_t at) {
  wire::Bytes both(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(std::min(at, a.size())));
  if (at < b.size()) both.insert(both.end(), b.begin() + static_cast<std::ptrdiff_t>(at), b.end());
  return both;
}

/// What goes to and fro in a session with another key.
const std::deque<Passing>& elsewhere() {
  static const std::deque<Passing> kSent = [] {
    SmallNet net(2, 99, wire::SealMode::kAuth);
    if (!net.come_together()) std::abort();
    for (int i = 0; i < 60; ++i) net.turn();
    return net.sent();
  }();
  return kSent;
}

/// Compares what all but the liar confirm.
class Agreement {
 public:
  Agreement(SmallNet& net, int honest) {
    net.on_confirmed = [this, honest](int peer, Tick tick, std::uint64_t hash) {
      if (peer >= honest) return;
      const auto [it, is_new] = hashes_.try_emplace(tick, hash);
      if (!is_new && it->second != hash) broken_ = true;
    };
  }
  bool broken() const { return broken_; }
  Tick newest() const { return hashes_.empty() ? -1 : hashes_.rbegin()->first; }

 private:
  std::map<Tick, std::uint64_t> hashes_;
  bool broken_ = false;
};

// ---- without a key

struct Counts {
  std::uint64_t passed, handshakes, moves;
};

Counts counts(const SmallNet& net, int peer) {
  const node::ChannelStats& s = net.peer(peer).channels()->stats();
  return {s.passed, s.handshakes, s.moves};
}

/// Whoever has seen one may say it again, to anybody, and gets a cookie that it cannot use.
bool is_hello(const SmallNet& net, const wire::Bytes& bytes) {
  const auto message = wire::decode_handshake(bytes, wire::handshake_key(net.session_key()));
  return message && std::holds_alternative<wire::Hello>(*message);
}

void forge(SmallNet& net, const Entry& e) {
  const std::deque<Passing>& sent = net.sent();
  const auto lately = [&](std::uint8_t n) -> const Passing& { return sent[sent.size() - 1 - n % sent.size()]; };
  Passing p = lately(e.which);
  Endpoint from = SmallNet::place(e.where % 2 == 0 ? p.from : 50);
  switch (e.what % 8) {
    case 0:
      damage(p.bytes, e);
      break;
    case 1:
      p.bytes.resize(e.at % (p.bytes.size() + 1));
      break;
    case 2:
      p.bytes = joined(p.bytes, lately(e.by).bytes, e.at);
      break;
    case 3:
      break;
    case 4:
      std::swap(p.from, p.to);
      from = SmallNet::place(p.from);
      break;
    case 5:
      p.to = e.by % net.peers();
      break;
    case 6:
      p.bytes = elsewhere()[e.at % elsewhere().size()].bytes;
      if (e.where % 4 < 2) damage(p.bytes, e);
      break;
    default:
      net.lose(e.by % 6);
      return;
  }
  const bool awaited = net.awaited(p.to, p.bytes);
  const Counts before = counts(net, p.to);
  net.inject(from, p.to, p.bytes);
  if (awaited) return;  // it only came another way, or sooner
  const Counts after = counts(net, p.to);
  if (after.passed != before.passed || after.moves != before.moves) std::abort();
  if (after.handshakes != before.handshakes && !is_hello(net, p.bytes)) std::abort();
}

// ---- with a member's keys

float damaged(float v, const Entry& e) {
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(v) ^ std::uint32_t{e.by} << (e.at % 25U));
}

/// The same for everybody who is told this update.
void lie_about_the_world(sync::Bundle& b, const Entry& e) {
  switch (e.what % 6) {
    case 0:
      if (b.avatar) b.avatar->position.x = damaged(b.avatar->position.x, e);
      break;
    case 1:
      if (b.avatar) b.avatar->velocity.y = damaged(b.avatar->velocity.y, e);
      break;
    case 2:
      if (!b.bodies.empty()) b.bodies[0].state.velocity.x = damaged(b.bodies[0].state.velocity.x, e);
      break;
    case 3:
      if (!b.bodies.empty()) b.bodies[0].epoch ^= std::uint32_t{e.by} << (e.at % 25U);
      break;
    case 4:
      if (!b.bodies.empty()) b.bodies[0].held = !b.bodies[0].held;
      break;
    default:
      b.bodies.clear();
  }
}

wire::Bytes with_one_story(const wire::Bytes& unsealed, const std::vector<Entry>& script) {
  wire::SealError error{};
  const auto opened = wire::open(unsealed, error);
  if (!opened || opened->header.kind != wire::Kind::kState) return unsealed;
  auto packet = wire::decode_state(opened->payload, opened->header.sender);
  if (!packet) return unsealed;
  packet->check_tick = -1;  // of its own world, which nobody else has
  for (sync::Bundle& b : packet->updates) lie_about_the_world(b, script[b.index % script.size()]);
  const wire::Bytes payload = wire::encode(*packet);
  return payload.size() > wire::kMaxPayload ? unsealed : wire::seal(opened->header, payload);
}

wire::Bytes with_any_lie(const SmallNet& net, const wire::Bytes& unsealed, const Entry& e) {
  wire::SealError error{};
  const auto opened = wire::open(unsealed, error);
  if (!opened) std::abort();
  wire::Header header = opened->header;
  wire::Bytes payload(opened->payload.begin(), opened->payload.end());
  switch (e.what % 8) {
    case 0:
    case 1:
      damage(payload, e);
      break;
    case 2:
      payload.resize(e.at % (payload.size() + 1));
      break;
    case 3:
      header.sender = static_cast<PeerId>(e.by % (net.peers() + 1));
      break;
    case 4:
      header.kind = static_cast<wire::Kind>(e.by % 3);
      break;
    case 5:
      header.session = static_cast<std::uint16_t>(header.session ^ e.by);
      break;
    case 6:  // of another's
      payload = joined(payload, net.sent()[e.by % net.sent().size()].bytes, e.at);
      break;
    default:
      for (std::size_t i = e.at; i < payload.size(); i += 1U + e.which % 7U) payload[i] ^= static_cast<std::byte>(e.by);
  }
  if (payload.size() > wire::kMaxPayload) payload.resize(wire::kMaxPayload);
  return wire::seal(header, payload);
}

std::vector<Entry> script_of(std::span<const std::uint8_t> bytes) {
  std::vector<Entry> script;
  for (; bytes.size() >= kEntry && script.size() < kMostEntries; bytes = bytes.subspan(kEntry))
    script.push_back({bytes[0], bytes[1], bytes[2], bytes[3], bytes[4], bytes[5]});
  return script;
}

bool caught_up(const SmallNet& net) {
  for (int p = 0; p < net.peers(); ++p) {
    if (!net.peer(p).playing()) return false;
    const node::Replica& replica = net.peer(p).replica();
    if (replica.now() - replica.agreed().confirmed().tick > kQuietTurns) return false;
  }
  return true;
}

void play_outsider(const std::vector<Entry>& script, wire::SealMode mode) {
  SmallNet net(2, 5, mode);
  const Agreement agreement(net, 2);
  if (!net.come_together()) std::abort();
  for (const Entry& e : script) {
    forge(net, e);
    for (int i = e.turns % 4; i > 0; --i) net.turn();
  }
  net.lose(0);
  for (int i = 0; i < kQuietTurns || (!caught_up(net) && i < kMostTurns); ++i) net.turn();
  if (agreement.broken() || !caught_up(net)) std::abort();
  for (int p = 0; p < 2; ++p) {
    const node::Participant& peer = net.peer(p);
    if (peer.incarnation() != 0 || !peer.replica().seat(static_cast<PeerId>(1 - p)).there()) std::abort();
  }
}

void play_member(const std::vector<Entry>& script, wire::SealMode mode, bool one_story) {
  constexpr int kHonest = 2;
  SmallNet net(kHonest + 1, 6, mode);
  const Agreement agreement(net, kHonest);
  if (!net.come_together()) std::abort();
  std::size_t next = 0;
  net.lie = [&](int from, int, const wire::Bytes& unsealed) {
    if (from != kHonest) return unsealed;
    if (one_story) return with_one_story(unsealed, script);
    return next < script.size() ? with_any_lie(net, unsealed, script[next++]) : unsealed;
  };
  for (const Entry& e : script)
    for (int i = e.turns % 4; i > 0; --i) net.turn();
  for (int i = 0; i < kQuietTurns; ++i) net.turn();
  if (one_story && agreement.broken()) std::abort();
}

}  // namespace

padr::wire::Bytes padr::test::good_input(Rng& rng) {
  wire::Bytes all;
  const std::size_t size = kHead + kEntry * (1 + rng.below(kMostEntries));
  while (all.size() < size) all.push_back(static_cast<std::byte>(rng.below(256)));
  return all;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < kHead + kEntry) return 0;
  const auto mode = data[1] % 2 == 0 ? wire::SealMode::kAuth : wire::SealMode::kEncrypt;
  const std::vector<Entry> script = script_of({data + kHead, size - kHead});
  if (data[0] % 3 == 0)
    play_outsider(script, mode);
  else
    play_member(script, mode, data[0] % 3 == 1);
  return 0;
}
