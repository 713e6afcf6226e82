// A real member of a real session that lies: a participant on a UDP socket, whose datagrams are changed on their way
// out as by `padr-lab chaos --liar`.
//
//   padr-liar JOIN_PORT KEY LIE SECONDS    KEY: 64 hexadecimal digits, or `-` for none; it lies from 4 s of play on
#include <sodium.h>

#include <charconv>
#include <cstdio>
#include <cstring>
#include <random>
#include <stdexcept>
#include <string>

#include "common/participant/participant.h"
#include "common/scenarios/scenarios.h"
#include "common/wire/secret.h"
#include "shell/clock.h"
#include "shell/session_words.h"
#include "shell/udp_socket.h"
#include "tools/lab/chaos/lies.h"

namespace {

using namespace padr;

constexpr Tick kHonest = 4 * kTicksPerSecond;

std::uint64_t drawn() {
  std::random_device d;
  return std::uint64_t{d()} << 32U | d();
}

int number(const char* text) {
  int n = 0;
  if (std::from_chars(text, text + std::strlen(text), n).ec != std::errc()) throw std::runtime_error("not a number");
  return n;
}

node::ParticipantConfig config(const char* port, const std::string& key, lab::Liar& liar) {
  node::ParticipantConfig c;
  c.session.join = ipv4({127, 0, 0, 1}, static_cast<std::uint16_t>(number(port)));
  c.session.seed = drawn();
  c.session.secret = drawn();
  c.replica.technique = technique_by_name("full");
  c.tamper = [&liar](node::Parcel p) { return liar.tamper(std::move(p)); };
  if (key == "-") return c;
  node::ChannelConfig channels;
  for (std::size_t i = 0; i < channels.session.size(); ++i)
    std::from_chars(key.data() + 2 * i, key.data() + 2 * i + 2, channels.session[i], 16);
  randombytes_buf(channels.seed.data(), channels.seed.size());
  channels.random = [](std::span<std::byte> out) { randombytes_buf(out.data(), out.size()); };
  liar.learn_key(channels);
  c.channels = channels;
  return c;
}

/// Lies once it has played for a while.
class Lying {
 public:
  Lying(lab::Liar& liar, const node::Participant& peer, const lab::Behaviour& how)
      : liar_(liar), peer_(peer), how_(how) {}

  void advance() {
    if (!peer_.playing() || !peer_.replica().playing()) return;
    liar_.learn_session(peer_.session().id());
    if (plot_ || peer_.replica().now() < peer_.replica().start().at + kHonest) return;
    plot_ = std::make_shared<lab::Deceiver>(liar_, peer_, 1, 0);
    how_.begin(plot_);
    plot_->active = true;
    std::fprintf(stderr, "lies\n");
  }

 private:
  lab::Liar& liar_;
  const node::Participant& peer_;
  const lab::Behaviour& how_;
  lab::Plot plot_;
};

int play(char** argv) {
  const lab::Behaviour* how = lab::behaviour(argv[3]);
  if (how == nullptr) throw std::runtime_error("no such lie");
  const Micros end = Micros{number(argv[4])} * kMicrosPerSecond;
  const shell::Clock clock;
  lab::Liar liar;
  node::Participant peer(scenarios::load_embedded("arena", 1), config(argv[1], argv[2], liar), clock.now());
  Lying lying(liar, peer, *how);
  boost::asio::io_context io;
  shell::UdpSocket socket(io, {boost::asio::ip::address_v4::loopback(), 0});
  socket.start([&](const Endpoint& from, std::span<const std::byte> d) { peer.receive(from, d, clock.now()); },
               [](const Endpoint&) {}, [] {});
  Rng rng(1);
  Vec2 target{5, 5};
  while (clock.now() < end && !peer.failed()) {
    io.run_for(std::chrono::milliseconds(2));
    const Micros now = clock.now();
    peer.advance(now);
    while (peer.step_due(now)) {
      if (rng.chance(0.02)) target = lab::some_place(rng, peer.replica().live().world().scene());
      peer.step(target, now);
    }
    lying.advance();
    for (const node::Parcel& p : peer.take_outgoing()) socket.send(p.to, p.bytes);
    for (const node::SessionEvent& e : peer.take_events()) std::fprintf(stderr, "%s\n", shell::words_of(e).c_str());
  }
  std::printf("%llu lies\n%s\n", static_cast<unsigned long long>(liar.told), peer.session().failure().c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 5) return std::fprintf(stderr, "usage: padr-liar JOIN_PORT KEY LIE SECONDS\n"), 2;
  wire::choose_fast_code();
  return play(argv);
} catch (const std::exception& e) {
  return std::fprintf(stderr, "padr-liar: %s\n", e.what()), 1;
}
