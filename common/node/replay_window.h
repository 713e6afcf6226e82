#pragma once

#include <bitset>
#include <cstdint>

namespace padr::node {

/// Which of a link's datagram numbers have been here: each passes once, those too old to tell do not pass.
class ReplayWindow {
 public:
  bool pass(std::uint32_t seq) {
    if (seq > newest_) {
      const std::uint32_t by = seq - newest_;
      seen_ = by >= kSize ? std::bitset<kSize>{} : seen_ << by;
      newest_ = seq;
      seen_.set(0);
      return true;
    }
    const std::uint32_t back = newest_ - seq;
    if (back >= kSize || seen_.test(back)) return false;
    seen_.set(back);
    return true;
  }

  /// Whether enough has come to speak of loss.
  bool judged() const { return newest_ >= kEnough; }
  /// Share of the link's recent datagrams that have not come, 0 .. 1; those that may still be under way are left out.
  float loss() const {
    constexpr std::size_t kRecent = 200;
    const std::size_t sent = newest_ < kRecent ? newest_ : kRecent;
    if (!judged()) return 0;
    std::size_t missing = 0;
    for (std::size_t back = kUnderWay; back < sent; ++back) missing += seen_.test(back) ? 0U : 1U;
    return static_cast<float>(missing) / static_cast<float>(sent - kUnderWay);
  }

 private:
  static constexpr std::size_t kUnderWay = 8;
  static constexpr std::uint32_t kEnough = 2 * kUnderWay;
  static constexpr std::size_t kSize = 1024;  // 17 s at one datagram a tick
  std::bitset<kSize> seen_;
  std::uint32_t newest_ = 0;
};

}  // namespace padr::node
