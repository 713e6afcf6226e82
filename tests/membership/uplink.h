#pragma once

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

#include "common/model/rng.h"
#include "tests/membership/party.h"
#include "tests/seed.h"

namespace padr::test {

/// One person's uplink, which all that it sends shares: a rate, a queue, and loss behind it. To be given to its
/// `tamper`.
struct Uplink {
  const lab::VirtualNetwork* net = nullptr;  ///< as long as there is none, everything passes at once
  double kbit = 0;                           ///< per second; 0: any
  double room_s = 0;                         ///< of the queue
  double loss = 0;                           ///< part that gets lost
  int full = 0;                              ///< datagrams that found no room

  std::vector<node::Parcel> operator()(node::Parcel p) {
    std::vector<node::Parcel> out;
    if (net == nullptr) return {std::move(p)};
    const Micros now = net->now();
    for (; !queue_.empty() && queue_.front().first <= now; queue_.pop_front())
      out.push_back(std::move(queue_.front().second));
    if (kbit == 0) {
      out.push_back(std::move(p));
    } else if (free_at_ - now > seconds(room_s)) {
      ++full;
    } else {
      constexpr std::size_t kHeaders = 52;  // IP, UDP and the seal
      free_at_ = std::max(now, free_at_) + seconds(static_cast<double>(p.bytes.size() + kHeaders) * 8e-3 / kbit);
      if (rng_.uniform(0, 1) >= loss) queue_.emplace_back(free_at_, std::move(p));
    }
    return out;
  }

 private:
  Micros free_at_ = 0;
  std::deque<std::pair<Micros, node::Parcel>> queue_;
  Rng rng_{test::seed(5)};
};

}  // namespace padr::test
