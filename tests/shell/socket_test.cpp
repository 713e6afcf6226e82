#include "shell/udp_socket.h"

#include <gtest/gtest.h>

#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "peer/egress.h"
#include "shell/handler_memory.h"
#include "tests/bench/allocations.h"

namespace padr::shell {
namespace {

Udp::endpoint any_port() {
  return {boost::asio::ip::address_v4::loopback(), 0};
}

std::vector<std::byte> datagram(std::size_t size, std::uint8_t n) {
  return std::vector<std::byte>(size, std::byte{n});
}

/// Two sockets, and what the second one has received.
class Sockets : public testing::Test {
 protected:
  Sockets() {
    there_.start([this](const Endpoint& from, std::span<const std::byte> d) { receive(from, d); }, {}, [] {});
  }
  void receive(const Endpoint& from, std::span<const std::byte> d) {
    EXPECT_EQ(from, at_);
    ++received_;
    if (keep_) got_.emplace_back(d.begin(), d.end());
  }
  /// Until so many have come in all; over loopback they have by the time that they are sent.
  void run_until(std::size_t received) {
    for (int i = 0; i < 1'000 && received_ < received; ++i) io_.poll();
  }
  void flush(std::size_t expected_sent) {
    std::size_t sent = 0;
    here_.flush([&](const Endpoint&, std::span<const std::byte>, bool went) { sent += went ? 1 : 0; });
    EXPECT_EQ(sent, expected_sent);
  }

  boost::asio::io_context io_{1};
  UdpSocket here_{io_, any_port()};
  UdpSocket there_{io_, any_port()};
  Endpoint at_ = to_endpoint(here_.local());
  Endpoint to_ = to_endpoint(there_.local());
  bool keep_ = true;
  std::size_t received_ = 0;
  std::vector<std::vector<std::byte>> got_;
};

// More than one call takes, of all sizes: each comes whole, once and in order.
TEST_F(Sockets, WhatIsPostedComesInOrder) {
  std::vector<std::vector<std::byte>> all;
  for (std::uint8_t n = 0; n < 150; ++n) all.push_back(datagram(n == 100 ? 60'000 : std::size_t{n} * 8, n));
  for (const auto& d : all) here_.post(to_, d);
  run_until(1);
  EXPECT_EQ(received_, 0U) << "before the flush";
  flush(all.size());
  run_until(all.size());
  EXPECT_EQ(got_, all);
  EXPECT_EQ(here_.stats().sent, all.size());
  flush(0);
}

TEST_F(Sockets, OneThatCannotGoKeepsNobodyBack) {
  Endpoint elsewhere = to_;  // IPv6, from a socket of IPv4
  elsewhere.address = {0x20, 0x01, 0x0d, 0xb8};
  here_.post(elsewhere, datagram(4, 1));
  here_.post(to_, datagram(4, 2));
  here_.post(to_, datagram(70'000, 3));  // larger than any datagram can be
  here_.post(elsewhere, datagram(4, 4));
  here_.post(to_, datagram(4, 5));
  std::vector<bool> went;
  here_.flush([&](const Endpoint&, std::span<const std::byte>, bool sent) { went.push_back(sent); });
  EXPECT_EQ(went, (std::vector<bool>{false, true, false, false, true}));
  run_until(2);
  EXPECT_EQ(got_, (std::vector<std::vector<std::byte>>{datagram(4, 2), datagram(4, 5)}));
  EXPECT_EQ(here_.stats().send_errors, 3U);
}

// What the machine says of one datagram may be told to the next one that is sent, and is then no error of any read. But
// as long as it has not been read in full, the socket is ready: whoever waits for it then never rests.
TEST_F(Sockets, ARefusalIsToldOnceAndLeavesNothingThatWakesAgain) {
  Endpoint closed;
  {
    UdpSocket gone(io_, any_port());
    closed = to_endpoint(gone.local());
  }
  std::vector<Endpoint> refused;
  int wakes = 0;
  here_.start([](const Endpoint&, std::span<const std::byte>) {}, [&](const Endpoint& at) { refused.push_back(at); },
              [&] { ++wakes; });
  for (std::uint8_t i = 0; i < 3; ++i) {
    here_.post(to_, datagram(8, i));
    here_.post(closed, datagram(9, i));
    here_.post(to_, datagram(10, i));
    flush(3);
    for (int n = 0; n < 1000; ++n) io_.poll_one();
  }
  EXPECT_EQ(refused, std::vector<Endpoint>(3, closed));
  EXPECT_LE(wakes, 12) << "of 3000 times that it could have";
}

// From the link to the socket, through the loop and out at the other end: once buffers have grown, nothing is
// allocated.
TEST_F(Sockets, SteadyTrafficAllocatesNothing) {
  keep_ = false;
  peer::Egress egress({}, [this](const Endpoint& to, std::span<const std::byte> d) { here_.post(to, d); });
  egress.sit(0);
  const auto d = datagram(100, 7);
  const auto tick = [&](std::size_t n) {
    const auto now = static_cast<Micros>(n) * 16'667;
    for (int i = 0; i < 40; ++i) egress.state(1, to_, d, now);
    egress.pump(now);
    here_.flush([](const Endpoint&, std::span<const std::byte>, bool) {});
    run_until(40 * (n + 1));
  };
  std::size_t n = 0;
  while (n < 10) tick(n++);
  const std::uint64_t before = bench::allocations();
  while (n < 210) tick(n++);
  EXPECT_EQ(bench::allocations() - before, 0U);
  EXPECT_EQ(received_, 40 * n);
}

// As a peer waits: each wake-up sets the timer anew, so that the wait before is cancelled and still to be told of it
// while the next one has begun, and the socket waits, too.
TEST_F(Sockets, WaitingForTheNextAllocatesNothing) {
  boost::asio::steady_timer timer(io_);
  const auto memory = std::make_shared<HandlerMemory>();
  UdpSocket third(io_, any_port());
  std::size_t woken = 0;
  const auto set_timer = [&] {
    timer.expires_after(std::chrono::hours(1));
    timer.async_wait(KeptIn(memory, [](const boost::system::error_code&) {}));
  };
  third.start([](const Endpoint&, std::span<const std::byte>) {}, {}, [&] { set_timer(), ++woken; });
  const Endpoint to = to_endpoint(third.local());
  const auto d = datagram(100, 1);
  const auto one = [&] {
    const std::size_t before = woken;
    here_.post(to, d);
    here_.post(to_, d);
    flush(2);
    for (int i = 0; i < 1'000 && woken == before; ++i) io_.poll();
  };
  keep_ = false;
  for (int i = 0; i < 10; ++i) one();
  const std::uint64_t before = bench::allocations();
  for (int i = 0; i < 200; ++i) one();
  EXPECT_EQ(bench::allocations() - before, 0U);
  EXPECT_GE(woken, 210U);
}

}  // namespace
}  // namespace padr::shell
