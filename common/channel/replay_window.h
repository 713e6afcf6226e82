#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace padr::node {

/// Which of a link's datagram numbers have been here: each passes once, those too old to tell do not pass.
template <std::size_t kSize>
class NumberWindow {
 public:
  bool pass(std::uint64_t seq) {
    loss_.reset();
    if (seq > newest_) {
      const std::uint64_t by = seq - newest_;
      seen_ = by >= kSize ? std::bitset<kSize>{} : seen_ << by;
      newest_ = seq;
      seen_.set(0);
      ++passed_;
      return true;
    }
    if (!would_pass(seq)) return false;
    seen_.set(newest_ - seq);
    ++passed_;
    return true;
  }
  bool would_pass(std::uint64_t seq) const {
    return seq > newest_ || (newest_ - seq < kSize && !seen_.test(newest_ - seq));
  }
  std::uint64_t newest() const { return newest_; }
  /// Nothing up to this number passes any more.
  void start_after(std::uint64_t seq) {
    newest_ = begin_ = seq;
    passed_ = 0;
    seen_.set();
    loss_.reset();
  }

  /// Whether enough has come to speak of loss.
  bool judged() const { return newest_ >= kEnough; }
  /// Share of the link's recent datagrams that have not come, 0 .. 1; those that may still be under way are left out,
  /// which are the newest 8.
  float loss() const {
    if (!loss_) loss_ = count_loss();
    return *loss_;
  }
  /// Of how many datagrams `loss` is the share: 192 at most, 0 until judged.
  std::size_t loss_of() const { return judged() ? recent() - kUnderWay : 0; }

  /// Of all the link's datagrams but the newest 8.
  struct Counted {
    std::uint64_t judged = 0;
    std::uint64_t lost = 0;  ///< have not come, or too late to pass
  };
  Counted counted() const {
    if (newest_ - begin_ < kEnough) return {};
    std::uint64_t under_way = 0;
    for (std::size_t back = 0; back < kUnderWay; ++back) under_way += seen_.test(back) ? 1U : 0U;
    const std::uint64_t of = newest_ - begin_ - kUnderWay;
    return {of, of - (passed_ - under_way)};
  }

 private:
  std::size_t recent() const { return newest_ < kRecent ? static_cast<std::size_t>(newest_) : kRecent; }
  float count_loss() const {
    if (!judged()) return 0;
    const std::size_t sent = recent();
    std::size_t missing = 0;
    for (std::size_t back = kUnderWay; back < sent; ++back) missing += seen_.test(back) ? 0U : 1U;
    return static_cast<float>(missing) / static_cast<float>(sent - kUnderWay);
  }

  static constexpr std::size_t kRecent = 200;
  static constexpr std::size_t kUnderWay = 8;
  static constexpr std::uint64_t kEnough = 2 * kUnderWay;
  std::bitset<kSize> seen_;
  std::uint64_t newest_ = 0;
  std::uint64_t begin_ = 0;            ///< numbers count from behind it
  std::uint64_t passed_ = 0;           ///< since then
  mutable std::optional<float> loss_;  ///< asked for more often than it changes
};

/// Of a link: 17 s at one datagram a tick.
using ReplayWindow = NumberWindow<1024>;

}  // namespace padr::node
