// Garbage for a UDP port at a steady rate: random bytes, bytes that begin as datagrams of the protocol do, whole
// datagrams whose checksum is wrong, and sealed ones and handshakes in the name of somebody whom the receiver knows,
// with wrong tags. Says at the end how many went out.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

#include "common/model/rng.h"
#include "common/wire/handshake.h"
#include "common/wire/sealed.h"

namespace {

using namespace padr;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kBatch = 64;        // datagrams of one call
constexpr std::size_t kDifferent = 4096;  // datagrams made beforehand
constexpr int kSources = 4;               // sockets that they come from

wire::Bytes random_bytes(Rng& rng, std::uint32_t size) {
  wire::Bytes bytes(size);
  for (std::byte& b : bytes) b = static_cast<std::byte>(rng.below(256));
  return bytes;
}

wire::Key random_key(Rng& rng) {
  wire::Key key{};
  for (auto& b : key) b = static_cast<std::uint8_t>(rng.below(256));
  return key;
}

/// `known`: short ids of public keys that the receiver knows; if there are none, nothing is sealed.
wire::Bytes garbage(Rng& rng, const std::vector<std::uint32_t>& known) {
  const std::uint32_t size = rng.chance(0.1) ? 1000 : 20 + rng.below(200);
  wire::Bytes payload = random_bytes(rng, size);
  const auto kind = static_cast<wire::Kind>(rng.below(3));
  const wire::Header header{kind, static_cast<PeerId>(rng.below(4)), static_cast<std::uint16_t>(rng.below(65536))};
  switch (rng.below(known.empty() ? 3 : 6)) {
    case 0:
      return payload;
    case 1: {
      const wire::Bytes like = wire::seal(header, {});
      std::copy_n(like.begin(), wire::kHeaderBytes, payload.begin());
      return payload;
    }
    case 2: {
      wire::Bytes d = wire::seal(header, payload);
      d.back() ^= std::byte{1};
      return d;
    }
    case 3: {
      PublicKey key{};
      for (auto& b : key) b = static_cast<std::uint8_t>(rng.below(256));
      return wire::encode_handshake(wire::Hello{key, rng.next_u64()}, random_key(rng));
    }
    default: {
      const auto mode = rng.chance(0.5) ? wire::SealMode::kAuth : wire::SealMode::kEncrypt;
      const std::uint32_t id = known[rng.below(static_cast<std::uint32_t>(known.size()))];
      return wire::seal_with(random_key(rng), mode, id, 1'000'000 + rng.below(1U << 30U), wire::seal(header, payload));
    }
  }
}

/// So many as the system takes of these; it may take fewer than all.
std::size_t send(int socket, sockaddr_in& to, std::vector<wire::Bytes>& all, std::size_t from, std::size_t count) {
  std::array<iovec, kBatch> parts{};
  std::array<mmsghdr, kBatch> messages{};
  for (std::size_t i = 0; i < count; ++i) {
    wire::Bytes& d = all[(from + i) % all.size()];
    parts[i] = {d.data(), d.size()};
    messages[i].msg_hdr.msg_name = &to;
    messages[i].msg_hdr.msg_namelen = sizeof(to);
    messages[i].msg_hdr.msg_iov = &parts[i];
    messages[i].msg_hdr.msg_iovlen = 1;
  }
  const int sent = sendmmsg(socket, messages.data(), static_cast<unsigned>(count), 0);
  return sent < 0 ? 0 : static_cast<std::size_t>(sent);
}

template <class Number>
bool read(const char* text, Number& value, int base = 10) {
  const char* end = text + std::strlen(text);
  const auto [rest, error] = std::from_chars(text, end, value, base);
  return error == std::errc{} && rest == end;
}

int flood(sockaddr_in to, std::uint64_t rate, std::uint64_t seconds, std::uint64_t seed,
          const std::vector<std::uint32_t>& known) {
  Rng rng(seed);
  std::vector<wire::Bytes> all;
  while (all.size() < kDifferent) all.push_back(garbage(rng, known));
  std::array<int, kSources> sockets{};
  for (int& s : sockets) {
    s = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (s < 0) {
      std::perror("flood: socket");
      return 1;
    }
  }
  const auto begin = Clock::now();
  std::uint64_t due = 0;
  std::uint64_t sent = 0;
  for (std::size_t turn = 0; due < rate * seconds; ++turn) {
    const std::chrono::duration<double> passed = Clock::now() - begin;
    const auto wanted =
        std::min(static_cast<std::uint64_t>(passed.count() * static_cast<double>(rate)), rate * seconds);
    if (wanted == due) std::this_thread::sleep_for(std::chrono::microseconds(200));
    while (due < wanted) {
      const std::size_t count = std::min<std::uint64_t>(wanted - due, kBatch);
      sent += send(sockets[turn % kSources], to, all, due % kDifferent, count);
      due += count;
    }
  }
  const std::chrono::duration<double> took = Clock::now() - begin;
  std::printf("sent %llu of %llu in %.3f s\n", static_cast<unsigned long long>(sent),
              static_cast<unsigned long long>(due), took.count());
  for (const int s : sockets) close(s);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::uint16_t port = 0;
  std::uint64_t rate = 0;
  std::uint64_t seconds = 0;
  std::uint64_t seed = 0;
  std::vector<std::uint32_t> known;
  bool good = argc >= 5 && read(argv[1], port) && read(argv[2], rate) && read(argv[3], seconds) && read(argv[4], seed);
  for (int i = 5; good && i < argc; ++i) good = read(argv[i], known.emplace_back(), 16);
  if (!good || port == 0 || rate < 1 || rate > 10'000'000 || seconds < 1 || seconds > 3600) {
    std::fputs("usage: flood PORT DATAGRAMS_PER_SECOND SECONDS SEED [SHORT_ID_IN_HEX...]\n", stderr);
    return 2;
  }
  to.sin_port = htons(port);
  return flood(to, rate, seconds, seed, known);
}
