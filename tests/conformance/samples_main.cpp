// Prints datagrams and transfers with what our decoders read in them, for the second decoder to read: `datagram BYTES`
// or `transfer BODIES SLOTS FIXED_THINGS CORNERS BYTES`, then the listing, then an empty line. Most are damaged.
#include <cstdlib>
#include <iostream>
#include <string>

#include "common/wire/transfer_codec.h"
#include "tests/seed.h"
#include "tests/wire/listing.h"
#include "tests/wire/samples.h"

namespace padr::test {
namespace {

constexpr PeerId kSender = 2;
constexpr std::uint16_t kSession = 0x1234;

std::string hex_word(const wire::Bytes& bytes) {
  std::string s;
  for (const char c : hex(bytes))
    if (c != ' ' && c != '\n') s += c;
  return s;
}

void damage(Rng& rng, wire::Bytes& bytes) {
  if (rng.chance(0.1)) bytes.resize(rng.below(static_cast<std::uint32_t>(bytes.size()) + 1));
  for (std::uint32_t n = 1 + rng.below(2); n > 0 && !bytes.empty(); --n)
    bytes[rng.below(static_cast<std::uint32_t>(bytes.size()))] ^= std::byte{1} << rng.below(8);
}

void print_datagram(wire::Kind kind, const wire::Bytes& payload) {
  const wire::Bytes datagram = wire::seal({kind, kSender, kSession}, payload);
  std::cout << "datagram " << hex_word(datagram) << '\n' << read(datagram).lines << '\n';
}

void print_transfer(const Scene& scene, const wire::Bytes& bytes) {
  std::cout << "transfer " << scene.bodies.size() << ' ' << Played::kSlots << ' ' << scene.statics.size() << ' '
            << scene.lower.x << ' ' << scene.lower.y << ' ' << scene.upper.x << ' ' << scene.upper.y << ' '
            << hex_word(bytes) << '\n';
  const auto t = wire::decode_transfer(bytes, scene, Played::kSlots);
  std::cout << (t ? list(*t) : "drop = malformed\n") << '\n';
}

void print_datagrams(Rng& rng, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const bool state = rng.chance(0.4);
    const bool finding = !state && rng.chance(0.2);
    const wire::Kind kind = state ? wire::Kind::kState : finding ? wire::Kind::kSession : wire::Kind::kMembership;
    sync::StatePacket packet = any_packet(rng, kSender);
    if (packet.updates.empty() && rng.chance(0.5))
      packet.updates.push_back(any_crossing(rng, kSender, packet.mark_count - 1, packet.mark_tick));
    wire::Bytes payload = state     ? wire::encode(packet)
                          : finding ? wire::encode_session(any_finding(rng))
                                    : wire::encode_membership(any_membership(rng, i));
    print_datagram(kind, payload);
    damage(rng, payload);
    print_datagram(kind, payload);
  }
}

void print_transfers(Rng& rng, std::uint64_t seed, std::size_t count) {
  for (const Tick ticks : {40, Played::kIsOut + 10, 250}) {
    const Played played(seed, ticks);
    const wire::Bytes whole = wire::encode_transfer(played.transfer());
    print_transfer(played.scene(), whole);
    for (std::size_t i = 0; i < count / 3; ++i) {
      wire::Bytes bytes = whole;
      damage(rng, bytes);
      print_transfer(played.scene(), bytes);
    }
  }
}

}  // namespace
}  // namespace padr::test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: wire_samples COUNT\n";
    return 2;
  }
  const auto count = static_cast<std::size_t>(std::atoi(argv[1]));
  const std::uint64_t seed = padr::test::seed();
  std::cout << '\n';
  padr::Rng rng(seed);
  padr::test::print_datagrams(rng, count);
  padr::test::print_transfers(rng, seed, count / 2);
}
