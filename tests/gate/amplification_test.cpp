// What somebody at an address that has proven nothing gets back, in bytes with IP and UDP headers.
#include <cstdio>

#include "common/wire/session_codec.h"
#include "tests/gate/two_gates.h"

namespace padr::test {
namespace {

constexpr double kHeaders = 28;

double answered(node::Gate& gate, const wire::Bytes& d, Micros now) {
  gate.receive(place(66), d, now);
  double bytes = 0;
  for (const auto& p : gate.take_outgoing()) bytes += static_cast<double>(p.bytes.size()) + kHeaders;
  return bytes;
}

TEST(Amplification, NothingUnprovenGetsBackMoreThanItSent) {
  TwoGates g;
  g.meet();
  const wire::Key h = wire::handshake_key(gate_config(1).session);
  const wire::Bytes join = wire::seal({wire::Kind::kSession, kNoPeer, 0}, wire::encode_session(wire::Join{}));
  const std::vector<std::pair<const char*, wire::Bytes>> all{
      {"Hello", wire::encode_handshake(wire::Hello{key_of(5), 1}, h)},
      {"Cookie", wire::encode_handshake(wire::Cookie{key_of(5), 1, {}}, h)},
      {"Introduction", wire::encode_handshake(wire::Introduction{key_of(5), 1, {}}, h)},
      {"Acceptance", wire::encode_handshake(wire::Acceptance{g.a.key(), 1}, h)},
      {"Hello, wrong tag", wire::encode_handshake(wire::Hello{key_of(5), 1}, key_of(9))},
      {"sealed, wrong tag", wire::seal_with(key_of(9), wire::SealMode::kAuth, wire::short_id(g.a.key()), 99, join)},
      {"sealed, unknown", wire::seal_with(key_of(9), wire::SealMode::kAuth, 1, 99, join)},
      {"replayed",
       [&] {
         wire::Bytes d = g.sealed("x");
         g.b.receive(place(1), d, g.now);
         return d;
       }()},
      {"unsealed Join", join},
      {"garbage", wire::Bytes(1200)}};
  std::printf("  %-20s %6s %6s %6s\n", "from anywhere", "in", "out", "factor");
  for (const auto& [name, d] : all) {
    const double in = static_cast<double>(d.size()) + kHeaders;
    const double out = answered(g.b, d, g.now);
    std::printf("  %-20s %6.0f %6.0f %6.2f\n", name, in, out, out / in);
    EXPECT_LE(out, in) << name;
  }
}

}  // namespace
}  // namespace padr::test
