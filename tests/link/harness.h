#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "common/link/shim.h"
#include "shell/netem_text.h"

namespace padr::link::testing {

/// The seed of every random choice in these tests: PADR_SEED, or 1. Bounds are wide enough for any seed.
inline std::uint64_t seed() {
  const char* text = std::getenv("PADR_SEED");
  return text == nullptr ? 1 : std::strtoull(text, nullptr, 10);
}

/// For SCOPED_TRACE: how to run a failure again.
inline std::string seed_note() {
  return "run with PADR_SEED=" + std::to_string(seed());
}

/// `hits` of `n` independent trials of probability `p` lie within 6 standard deviations (and 1), which fails once in
/// 5 * 10^8. `inflation` multiplies the variance where trials are not independent.
inline void expect_share(double hits, double n, double p, double inflation = 1) {
  const double margin = 6 * std::sqrt(n * p * (1 - p) * inflation) + 1;
  EXPECT_NEAR(hits, n * p, margin) << "of " << n << " at probability " << p << "; " << seed_note();
}

inline std::vector<std::byte> bytes_of(std::string_view text, std::size_t size = 0) {
  std::vector<std::byte> bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  if (bytes.size() < size) bytes.resize(size, std::byte{'.'});
  return bytes;
}

/// Text without the padding.
inline std::string text_of(const std::vector<std::byte>& bytes) {
  std::string text;
  for (const std::byte b : bytes) {
    if (b != std::byte{'.'}) text += static_cast<char>(b);
  }
  return text;
}

/// A packet number in 4 bytes.
inline std::vector<std::byte> numbered(std::uint32_t n, std::size_t size = 4) {
  std::vector<std::byte> bytes(size);
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<std::byte>(n >> (8 * i));
  return bytes;
}
inline std::uint32_t number_of(const std::vector<std::byte>& bytes) {
  std::uint32_t n = 0;
  for (std::size_t i = 0; i < 4; ++i) n |= std::to_integer<std::uint32_t>(bytes[i]) << (8 * i);
  return n;
}

/// With link traces: `trace 10,20` has opportunities at 10 and 20 ms.
inline NetemSpec parse(std::string_view spec) {
  return shell::parse_netem(spec, nullptr, [](std::string times) {
    std::replace(times.begin(), times.end(), ',', '\n');
    return times;
  });
}

/// A scripted shim: at a time, send, expect, or expect nothing. A failure prints the steps so far.
class Script {
 public:
  explicit Script(std::string_view spec) : shim_(parse(spec), seed()) {
    steps_ << seed_note() << "\nspec: " << spec << '\n';
  }
  Script& at(Micros now) {
    now_ = now;
    return *this;
  }
  Script& send(std::string_view text, std::size_t size = 0) {
    steps_ << "  at " << now_ << " us: send " << text << '\n';
    shim_.accept(now_, bytes_of(text, size));
    return *this;
  }
  /// Exactly these come out now, in this order.
  Script& expect(const std::vector<std::string>& wanted) {
    std::vector<std::string> got;
    while (const auto bytes = shim_.release(now_)) got.push_back(text_of(*bytes));
    steps_ << "  at " << now_ << " us: expect";
    for (const auto& w : wanted) steps_ << ' ' << w;
    steps_ << '\n';
    EXPECT_EQ(got, wanted) << steps_.str();
    return *this;
  }
  Script& nothing() { return expect({}); }
  /// Nothing one microsecond before `t`; then these, at `t`; and the shim knew `t`.
  Script& expect_at(Micros t, const std::vector<std::string>& wanted) {
    EXPECT_EQ(shim_.next_due(), std::optional<Micros>(t)) << steps_.str();
    at(t - 1).nothing();
    return at(t).expect(wanted);
  }
  Script& empty() {
    EXPECT_EQ(shim_.next_due(), std::nullopt) << steps_.str();
    EXPECT_EQ(shim_.in_flight(), 0U) << steps_.str();
    return *this;
  }
  Script& change(std::string_view spec) {
    steps_ << "  at " << now_ << " us: change to " << spec << '\n';
    shim_.set_spec(now_, parse(spec));
    return *this;
  }
  const ShimStats& stats() const { return shim_.stats(); }

 private:
  Shim shim_;
  Micros now_ = 0;
  std::ostringstream steps_;
};

/// One datagram that came out.
struct Out {
  Micros at = 0;
  std::uint32_t number = 0;
  friend bool operator==(const Out&, const Out&) = default;
};

/// Sends `count` numbered datagrams `gap` apart, collecting at the very times the shim asks for.
inline std::vector<Out> stream(Shim& shim, std::uint32_t count, Micros gap, std::size_t size = 4) {
  std::vector<Out> out;
  const auto collect = [&](Micros now) {
    while (const auto bytes = shim.release(now)) out.push_back({now, number_of(*bytes)});
  };
  const auto run_to = [&](Micros end) {
    for (auto due = shim.next_due(); due && *due < end; due = shim.next_due()) collect(*due);
  };
  for (std::uint32_t i = 0; i < count; ++i) {
    const Micros now = static_cast<Micros>(i) * gap;
    run_to(now);
    shim.accept(now, numbered(i, size));
    collect(now);
  }
  run_to(Micros{1} << 50U);
  return out;
}

}  // namespace padr::link::testing
