// A game of your own around PADR's participant: one UDP socket, one clock, one loop. docs/own-game.md walks through it.
//
//   own_game PORT             founds a session on 127.0.0.1 and waits for a second player
//   own_game PORT JOIN_PORT   joins the session at 127.0.0.1:JOIN_PORT
#include <utility>  // Boost.Asio 1.74 needs it and does not include it

#include <algorithm>
#include <array>
#include <boost/asio.hpp>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <span>
#include <string>

#include "common/model/user_error.h"
#include "common/participant/participant.h"
#include "common/scenarios/scenarios.h"

using boost::asio::ip::udp;
using std::chrono::microseconds;
using std::chrono::steady_clock;

const padr::Tick kEnd = 10 * padr::kTicksPerSecond;  // after the begin of play

std::uint16_t port_of(const std::string& text) {
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || *end != '\0' || port < 1 || port > 65535)
    throw padr::UserError("PORT '" + text + "' is not allowed; give 1 to 65535");
  return static_cast<std::uint16_t>(port);
}

// 1. What you choose: the session that you found or join, and the technique.
padr::node::ParticipantConfig configure(const char* join_port) {
  padr::node::ParticipantConfig config;
  config.replica.technique = padr::technique_by_name("full");
  config.session.slots = 4;
  config.session.scenario = "arena seed 1";  // for messages to people, and for padr-capture
  std::random_device random;
  config.session.seed = random();
  config.session.secret = std::uint64_t{random()} << 32U | random();
  if (join_port) config.session.join = padr::ipv4({127, 0, 0, 1}, port_of(join_port));
  config.on_confirmed = [](int, const padr::sync::FoldState& world, std::uint64_t hash) {
    if (world.tick % 60 == 0) std::printf("confirmed %d %016llx\n", int(world.tick), (unsigned long long)hash);
  };
  return config;
}

// 2. Your input: the point that the avatar is drawn towards, in metres. Your picture: where everything is to be drawn.
padr::Vec2 input(const padr::node::Replica& replica) {
  const float angle = float(replica.now()) / 40 + float(replica.self()) * 3;
  return {10 + 5 * std::cos(angle), 7.5F + 5 * std::sin(angle)};
}
void draw(const padr::node::Replica& replica) {
  if (replica.now() % 60 != 0) return;
  const std::vector<padr::Vec2>& at = replica.shown().positions();  // of the bodies, then of the avatars by slot; m
  const auto& world = replica.live().world();                       // has angles and velocities: world.state(id)
  const padr::PeerId owner = replica.agreed().predicted_state().authority[0].holder();  // or padr::kNoPeer
  std::printf("tick %d: body 0 at %.2f %.2f", int(replica.now()), at[0].x, at[0].y);
  if (owner != padr::kNoPeer) std::printf(" owned by player %d", int{owner});
  for (padr::EntityId id = 0; id < at.size(); ++id)
    if (world.is_avatar(id) && world.present(id))  // a slot may be empty
      std::printf(", %s avatar at %.2f %.2f", id == replica.live().avatar() ? "my" : "another", at[id].x, at[id].y);
  std::puts("");
}

udp::socket open(boost::asio::io_context& io, std::uint16_t port) {
  udp::socket socket(io, udp::v4());
  boost::system::error_code error;
  socket.bind({boost::asio::ip::address_v4::loopback(), port}, error);
  if (error) throw padr::UserError("127.0.0.1:" + std::to_string(port) + ": " + error.message());
  return socket;
}
void send(udp::socket& socket, const padr::Endpoint& to, std::span<const std::byte> bytes) {
  boost::asio::ip::address_v4::bytes_type address{};
  std::copy_n(to.address.begin() + 12, 4, address.begin());
  boost::system::error_code lost;  // as any datagram may be
  socket.send_to(boost::asio::buffer(bytes.data(), bytes.size()), {boost::asio::ip::address_v4(address), to.port}, 0,
                 lost);
}

void tell(const padr::node::SessionEvent& event) {
  using Kind = padr::node::SessionEvent::Kind;
  if (event.kind == Kind::kAdmitted) std::printf("in the session as player %d\n", int{event.peer});
  if (event.kind == Kind::kJoined) std::printf("player %d joins\n", int{event.peer});
  if (event.kind == Kind::kLeft) std::printf("player %d has left\n", int{event.peer});
  if (event.kind == Kind::kLost) std::printf("player %d is lost\n", int{event.peer});
  if (event.kind == Kind::kRefused) std::printf("a joiner is refused: %s\n", event.text.c_str());
  if (event.kind == Kind::kWrongKey) std::puts("somebody has another key, or none");
}

int main(int argc, char** argv) try {
  if (argc < 2) return std::puts("usage: own_game PORT [JOIN_PORT]"), 2;
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);  // a log in a file shows each line at once
  // 3. The participant has neither clock nor socket. Both are yours.
  boost::asio::io_context io;
  udp::socket socket = open(io, port_of(argv[1]));
  const auto start = steady_clock::now();
  const auto now = [&] { return std::chrono::duration_cast<microseconds>(steady_clock::now() - start).count(); };
  padr::node::Participant peer(padr::scenarios::load_embedded("arena", 1), configure(argv[2]), now());
  std::array<std::byte, 2048> in{};
  udp::endpoint from;
  const std::function<void()> listen = [&] {
    socket.async_receive_from(boost::asio::buffer(in), from, [&](boost::system::error_code error, std::size_t size) {
      if (!error) peer.receive(padr::ipv4(from.address().to_v4().to_bytes(), from.port()), {in.data(), size}, now());
      listen();
    });
  };
  listen();

  // 4. The loop: wait for a datagram or for what is due, play the ticks that are due, send what there is to send.
  for (bool over = false; !over;) {
    const auto due = peer.playing() ? std::min(peer.next_due(), peer.next_step()) : peer.next_due();
    io.run_one_until(start + microseconds(due));
    const auto time = now();
    peer.advance(time);
    while (peer.step_due(time) && !over) {
      peer.step(input(peer.replica()), time);
      draw(peer.replica());
      if (peer.replica().playing() && peer.replica().now() >= peer.replica().start().at + kEnd) peer.leave(time);
      over = peer.done(time);
    }
    for (const padr::node::Parcel& parcel : peer.take_outgoing()) send(socket, parcel.to, parcel.bytes);
    for (const padr::node::SessionEvent& event : peer.take_events()) tell(event);
    if (peer.failed()) return std::fprintf(stderr, "own_game: %s\n", peer.session().failure().c_str()), 1;
  }
  return peer.replica().stats().hash_mismatches == 0 ? 0 : 1;
} catch (const std::exception& e) {
  return std::fprintf(stderr, "own_game: %s\n", e.what()), 1;
}
