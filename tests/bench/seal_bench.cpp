// What sealing a datagram and opening it again costs, beside what the same costs unsealed: one item is one datagram
// there and back. The counter `times` is the ratio of the two, measured in turns. `frame_4` and `frame_22` are how much
// of a frame that takes of a peer among 4 and among 22, in per cent, if it sends every other a datagram in every frame
// and gets one: more than any technique but `everything` does; `unsealed_4` and `unsealed_22` are the same without
// seals.
#include <benchmark/benchmark.h>

#include <chrono>
#include <string>

#include "common/channel/channel_keys.h"
#include "common/model/ids.h"
#include "common/model/rng.h"
#include "common/wire/codec.h"
#include "common/wire/sealed.h"
#include "common/wire/signature.h"

namespace padr {
namespace {

constexpr int kBatch = 64;

double seconds_of(const auto& work) {
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kBatch; ++i) work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// `payload`: bytes; a typical state datagram has some 100, the largest 1,190.
void sealing(benchmark::State& state, wire::SealMode mode) {
  wire::choose_fast_code();
  const wire::Bytes payload(static_cast<std::size_t>(state.range(0)), std::byte{7});
  const wire::Key key = wire::derive_key({}, "bench");
  std::uint64_t number = 0;
  const auto unsealed = [&] {
    wire::SealError error{};
    const wire::Bytes d = wire::seal({wire::Kind::kState, 1, 2}, payload);
    benchmark::DoNotOptimize(wire::open(d, error));
  };
  const auto sealed = [&] {
    const wire::Bytes plain = wire::seal({wire::Kind::kState, 1, 2}, payload);
    const wire::Bytes d = wire::seal_with(key, mode, 3, ++number, plain);
    const auto back = wire::unseal_with(key, number, d);
    wire::SealError error{};
    benchmark::DoNotOptimize(wire::open(*back, error));
  };
  double with = 0;
  double without = 0;
  for (auto unused : state) {
    (void)unused;
    without += seconds_of(unsealed);
    with += seconds_of(sealed);
  }
  const double datagrams = static_cast<double>(state.iterations()) * kBatch;
  state.counters["unsealed_us"] = without * 1e6 / datagrams;
  state.counters["sealed_us"] = with * 1e6 / datagrams;
  state.counters["times"] = with / without;
  for (const int peers : {4, 22}) {
    const double per_cent = 100.0 * (peers - 1) * kTicksPerSecond / datagrams;
    state.counters["frame_" + std::to_string(peers)] = with * per_cent;
    state.counters["unsealed_" + std::to_string(peers)] = without * per_cent;
  }
}

/// An update of the avatar and so many bodies, signed, and checked as each of its receivers does.
void signing(benchmark::State& state) {
  wire::choose_fast_code();
  const wire::Key secret = wire::derive_key({}, "bench");
  const wire::SigningKey key = wire::signing_key(secret);
  const PublicKey who = wire::public_key(secret);
  sync::Bundle b;
  b.peer = 1;
  b.index = 1000;
  b.tick = 10'000;
  b.avatar = sync::AvatarUpdate{};
  for (int i = 0; i < state.range(0); ++i) {
    sync::BodyUpdate& u = b.bodies.emplace_back();
    u.body = static_cast<EntityId>(i);
    u.has_state = true;
    u.epoch = 7;
    u.claimed = 9'990;
  }
  const auto bare = static_cast<double>(wire::encoded_size(b));
  const wire::Said said{{0x12, 0x34}, 0};
  double sign = 0;
  double check = 0;
  for (auto unused : state) {
    (void)unused;
    sign += seconds_of([&] { b.signature = wire::sign_update(key, said, b); });
    check += seconds_of([&] { benchmark::DoNotOptimize(wire::is_signed(who, said, b)); });
  }
  const double updates = static_cast<double>(state.iterations()) * kBatch;
  state.counters["sign_us"] = sign * 1e6 / updates;
  state.counters["check_us"] = check * 1e6 / updates;
  state.counters["bytes"] = bare;
  state.counters["more_bytes"] = static_cast<double>(wire::encoded_size(b)) - bare;
}

/// New keys for two peers, from the first message to the last. `peer_us` is what that takes of each of the two, and
/// `share_22` how much of a peer's time among 22 that is, in per cent, with new keys every two minutes.
void rekeying(benchmark::State& state) {
  wire::choose_fast_code();
  const wire::Key secret = wire::derive_key({}, "bench");
  const PublicKey own = wire::public_key(secret);
  const auto first = *wire::pair_keys(secret, secret, own, wire::public_key(wire::derive_key({}, "other")));
  const node::RandomBytes random = [rng = Rng(1)](std::span<std::byte> out) mutable {
    for (std::byte& b : out) b = static_cast<std::byte>(rng.below(256));
  };
  double took = 0;
  for (auto unused : state) {
    (void)unused;
    took += seconds_of([&] {
      node::ChannelKeys a(first, true, 0);
      node::ChannelKeys b({first.in, first.out}, false, 0);
      const auto answer = b.take(*a.due(0, random), 0, random);
      a.take(*answer.rekey, 0, random);
      if (!b.open([&](const wire::Key& key) { return key == a.out(); }, 0)) state.SkipWithError("not the same keys");
    });
  }
  const double each = took / 2 / static_cast<double>(state.iterations() * kBatch);
  state.counters["peer_us"] = each * 1e6;
  state.counters["share_22"] = 100 * 21 * each * 1e6 / static_cast<double>(node::ChannelKeys::kEvery);
}

BENCHMARK(rekeying);
BENCHMARK(signing)->Arg(0)->Arg(1)->Arg(20);
BENCHMARK_CAPTURE(sealing, auth, wire::SealMode::kAuth)->Arg(100)->Arg(1190);
BENCHMARK_CAPTURE(sealing, encrypt, wire::SealMode::kEncrypt)->Arg(100)->Arg(1190);

}  // namespace
}  // namespace padr
