#include "tools/report/report.h"

#include <algorithm>
#include <numeric>

#include "common/sync/fold.h"

namespace padr::report {

std::uint64_t Traffic::all_updates() const {
  return std::accumulate(updates.begin(), updates.end(), std::uint64_t{0});
}

double Traffic::bytes_rest() const {
  const double told = std::accumulate(bytes_by_cause.begin(), bytes_by_cause.end(), bytes_repeats);
  return std::max(0.0, static_cast<double>(wire_bytes) - told);
}

Traffic& Traffic::operator+=(const Traffic& o) {
  for (std::size_t c = 0; c < sync::kCauses; ++c) {
    updates[c] += o.updates[c];
    bytes_by_cause[c] += o.bytes_by_cause[c];
  }
  repeats += o.repeats;
  datagrams += o.datagrams;
  wire_bytes += o.wire_bytes;
  bytes_repeats += o.bytes_repeats;
  return *this;
}

int Report::peers_at_start() const {
  int told = 0;
  int there = 0;  // more may have come in time than play waited for
  for (const Peer& p : peers) {
    told = std::max({told, p.header.incarnation == 0 ? p.header.peers : 0, p.header.wanted});
    if (!p.header.spectates && !came_later(p)) ++there;
  }
  return std::max(told, there);
}

// Whoever heard late of the begin of play may have begun some ticks after the others.
bool Report::came_later(const Peer& peer) const {
  const auto first =
      std::min_element(peers.begin(), peers.end(), [](const Peer& a, const Peer& b) { return a.came < b.came; });
  return peer.header.incarnation > 0 && peer.came > first->came + sync::kStartLead;
}

bool Report::is_seen(const Peer& peer) const {
  return !peer.header.spectates && std::any_of(peers.begin(), peers.end(), [&peer](const Peer& p) {
    return &p != &peer && p.first_tick <= peer.went() && peer.came <= p.went();
  });
}

double Link::loss_percent() const {
  return judged == 0 ? 0 : 100.0 * static_cast<double>(lost) / static_cast<double>(judged);
}

double Link::reordered_percent() const {
  return received == 0 ? 0 : 100.0 * static_cast<double>(reordered) / static_cast<double>(received);
}

}  // namespace padr::report
