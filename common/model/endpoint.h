#pragma once

#include <array>
#include <charconv>
#include <compare>
#include <cstdint>
#include <string>

namespace padr {

/// An Ed25519 public key; all zeros: none.
using PublicKey = std::array<std::uint8_t, 32>;

/// What the signatures of a session are bound to: drawn by its founder; all zeros in a session without a key.
using SessionId = std::array<std::uint8_t, 16>;

/// Where a peer's datagrams come from and go to, and, in a session with a key, who that peer is. Plain numbers:
/// resolving names and sending are the shell's.
struct Endpoint {
  std::array<std::uint8_t, 16> address{};  ///< network order; IPv4 a.b.c.d as ::ffff:a.b.c.d
  std::uint16_t port = 0;
  PublicKey key{};  ///< of this run of the peer's program; none if it is not known or there is no session key
  friend auto operator<=>(const Endpoint&, const Endpoint&) = default;

  bool is_v4() const {
    for (std::size_t i = 0; i < 10; ++i)
      if (address[i] != 0) return false;
    return address[10] == 0xFF && address[11] == 0xFF;
  }
  /// 127.0.0.0/8 or ::1.
  bool is_loopback() const {
    if (is_v4()) return address[12] == 127;
    Endpoint one;
    one.address[15] = 1;
    return address == one.address;
  }
  /// Something that can be sent to: has a port, and an address that is not all zeros.
  bool is_set() const { return port != 0 && address != Endpoint{}.address; }
  bool has_key() const { return key != PublicKey{}; }
  /// The same without saying who is there.
  Endpoint place() const { return {address, port, {}}; }
};

/// a.b.c.d:port.
inline Endpoint ipv4(const std::array<std::uint8_t, 4>& address, std::uint16_t port) {
  Endpoint e;
  e.address[10] = e.address[11] = 0xFF;
  for (std::size_t i = 0; i < 4; ++i) e.address[12 + i] = address[i];
  e.port = port;
  return e;
}

/// Whoever is there.
inline bool same_place(const Endpoint& a, const Endpoint& b) {
  return a.address == b.address && a.port == b.port;
}

/// `a.b.c.d:port` or `[x:x:...]:port`, the longest run of zeros of two groups or more left out (RFC 5952).
inline std::string to_string(const Endpoint& e) {
  std::string s;
  const auto add = [&s](unsigned v, int base) {
    std::array<char, 8> text{};
    const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), v, base);
    s.append(text.data(), end);
  };
  if (e.is_v4()) {
    for (std::size_t i = 12; i < 16; ++i) {
      if (i > 12) s += '.';
      add(e.address[i], 10);
    }
    s += ':';
    add(e.port, 10);
    return s;
  }
  const auto group = [&e](std::size_t i) { return unsigned{e.address[2 * i]} << 8U | e.address[2 * i + 1]; };
  std::size_t gap = 8;
  std::size_t gap_length = 1;
  for (std::size_t i = 0; i < 8; ++i) {
    std::size_t n = 0;
    while (i + n < 8 && group(i + n) == 0) ++n;
    if (n > gap_length) {
      gap = i;
      gap_length = n;
    }
  }
  s += '[';
  for (std::size_t i = 0; i < 8; ++i) {
    if (i == gap) {
      s += "::";
      i += gap_length - 1;
      continue;
    }
    if (i > 0 && s.back() != ':') s += ':';
    add(group(i), 16);
  }
  s += "]:";
  add(e.port, 10);
  return s;
}

}  // namespace padr
