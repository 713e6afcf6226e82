#include "peer/status.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <numeric>

#include "shell/text.h"

namespace padr::peer {

std::uint64_t updates_told(const node::ReplicaStats& stats) {
  return std::accumulate(stats.updates_by_cause.begin(), stats.updates_by_cause.end(), std::uint64_t{0});
}

namespace {

/// From this price on the status line tells of it: below, it is that of the last few updates.
constexpr float kDear = 2;

/// Datagrams that were dropped for their content. Damage and duplicates by the network are not counted here.
std::uint64_t refused(const node::ReplicaStats& stats) {
  using enum sync::DropReason;
  std::uint64_t sum = 0;
  for (const sync::DropReason why : {kMalformed, kTick, kOrder, kEntity, kValue, kSignature, kRight, kCutOff, kPromise})
    sum += stats.dropped[static_cast<std::size_t>(why)];
  return sum;
}

/// Which members are reached through which others, if any are: "2 by 0, 3 by 0".
std::string carried(const Player& player) {
  std::string list;
  for (PeerId p = 0; p < player.replica().config().slots; ++p)
    if (player.carrier(p) != kNoPeer) list += fmt::format("{}{} by {}", list.empty() ? "" : ", ", p, player.carrier(p));
  return list;
}

/// What the links carry that are too narrow for what there was to tell of late, if any are: "2 at 8.0 kbit/s, 3 at 16.0
/// kbit/s".
std::string narrow(const Player& player) {
  std::string list;
  for (PeerId p = 0; p < player.replica().config().slots; ++p) {
    const auto rate = link_kbit(player.replica(), p);
    const bool limits = player.replica().link(p).out.rate().holds_back(player.replica().now());
    if (rate && limits && player.replica().seat(p).there())
      list += fmt::format("{}{} at {:.1f} kbit/s", list.empty() ? "" : ", ", p, *rate);
  }
  return list;
}

}  // namespace

std::optional<double> link_kbit(const node::Replica& replica, PeerId to) {
  const sync::LinkRate& rate = replica.link(to).out.rate();
  return rate.is_limited() ? std::optional(rate.rate() * 8e-3) : std::nullopt;
}

double confirmed_lag_ms(const Player& player) {
  return (player.replica().now() - player.confirmed().tick) * 1000.0 / kTicksPerSecond;
}

std::string Status::line(const Player& player, Micros now) {
  const node::Replica& replica = player.replica();
  const Totals totals = player.totals();
  const History& history = player.history();
  const std::uint64_t updates = updates_told(totals.replica);
  const std::uint64_t bytes = totals.replica.wire_bytes_sent;
  const double seconds = std::max(1e-3, static_cast<double>(now - last_) / kMicrosPerSecond);
  const auto ticks = static_cast<double>(std::max<std::uint64_t>(1, totals.ticks - last_ticks_));
  std::string line = fmt::format(
      "{:6.1f} s  peers {}/{}  confirmed -{:.0f} ms {:08x}@{}  sent {:.1f} updates/s {:.1f} kbit/s  own error {:.3f} m "
      " replay {:.1f}/tick  late {}",
      static_cast<double>(replica.now()) / kTicksPerSecond, player.present(), replica.config().slots,
      confirmed_lag_ms(player), player.confirmed().hash >> 32U, player.confirmed().tick,
      static_cast<double>(updates - last_updates_) / seconds, static_cast<double>(bytes - last_bytes_) * 8e-3 / seconds,
      replica.own_error(), static_cast<double>(totals.replayed_steps - last_replayed_) / ticks, player.ticks().late);
  if (const int wanted = replica.start().wanted; wanted > 0) line += "  waits for " + shell::counted(wanted, "player");
  if (const int n = player.session().spectators(); n > 0) line += fmt::format("  spectators {}", n);
  if (history.came() > 0) line += fmt::format("  came {}", history.came());
  if (history.left() > 0) line += fmt::format("  left {}", history.left());
  if (history.removed() > 0) line += fmt::format("  lost {}", history.removed());
  if (const std::uint64_t n = refused(totals.replica); n > 0) line += fmt::format("  refused {}", n);
  if (player.channels() != nullptr && player.channels()->stats().readable > 0) line += "  readable datagrams come";
  if (const std::string list = carried(player); !list.empty()) line += "  carried: " + list;
  if (const std::string list = narrow(player); !list.empty()) line += "  narrow: " + list;
  if (replica.price() >= kDear) line += fmt::format("  thresholds x{:.0f}", replica.price());
  if (player.incarnation() > 0) line += fmt::format("  rejoined {}", player.incarnation());
  if (player.returning()) line += "  joining anew";
  if (player.leaving()) line += "  leaving";
  last_ = now;
  last_ticks_ = totals.ticks;
  last_updates_ = updates;
  last_bytes_ = bytes;
  last_replayed_ = totals.replayed_steps;
  return line;
}

}  // namespace padr::peer
