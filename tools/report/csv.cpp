#include <cmath>

#include "shell/text.h"
#include "tools/report/outputs.h"

namespace padr::report {
namespace {

using shell::fixed;

std::string seconds(Tick t) {
  return fixed(static_cast<double>(t) / kTicksPerSecond, 4);
}

std::string owner_name(PeerId p) {
  return p == kNoPeer ? "none" : std::to_string(p);
}

std::string inconsistency(const Report& r) {
  std::string s = "peer,tick,seconds,combined_m,avatar_m,body_m,shown_m\n";
  for (const Peer& p : r.peers)
    for (const trace::InconsistencyPoint& i : p.series)
      s += p.name + ',' + std::to_string(i.tick) + ',' + seconds(i.tick) + ',' +
           fixed(static_cast<double>(i.combined()), 6) + ',' + fixed(static_cast<double>(i.avatars_m), 6) + ',' +
           fixed(static_cast<double>(i.bodies_m), 6) + ',' + fixed(static_cast<double>(i.shown_m), 6) + '\n';
  return s;
}

std::string fidelity(const Report& r) {
  std::string s = "peer,tick,seconds,fidelity_m,own_m,others_m,nobody_m,pcc_m,pcc_bodies\n";
  for (const Peer& p : r.peers) {
    const bool seen = r.is_seen(p);
    for (std::size_t i = 0; i < p.fidelity_series.size(); ++i) {
      const trace::FidelityPoint& f = p.fidelity_series[i];
      s += p.name + ',' + std::to_string(f.tick) + ',' + seconds(f.tick);
      for (const float m : {f.error_m(), f.own_m, f.others_m, f.nobody_m}) s += ',' + fixed(static_cast<double>(m), 6);
      const trace::PccPoint& cost = p.pcc_series[i];
      s += seen ? ',' + fixed(static_cast<double>(cost.cost_m), 6) + ',' + std::to_string(cost.bodies) : ",,";
      s += '\n';
    }
  }
  return s;
}

std::string traffic(const Report& r) {
  std::string s = "peer,second,datagrams,wire_bytes";
  for (const auto& cause : sync::kCauseNames) s += ",updates_" + std::string(cause);
  s += ",repeats";
  for (const auto& cause : sync::kCauseNames) s += ",bytes_" + std::string(cause);
  s += ",bytes_repeats,bytes_rest\n";
  for (const Peer& p : r.peers) {
    for (auto second = static_cast<std::size_t>(p.came / kTicksPerSecond); second < p.per_second.size(); ++second) {
      const Traffic& t = p.per_second[second];
      s += p.name + ',' + std::to_string(second) + ',' + std::to_string(t.datagrams) + ',' +
           std::to_string(t.wire_bytes);
      for (const std::uint64_t n : t.updates) s += ',' + std::to_string(n);
      s += ',' + std::to_string(t.repeats);
      for (const double b : t.bytes_by_cause) s += ',' + fixed(b, 0);
      s += ',' + fixed(t.bytes_repeats, 0) + ',' + fixed(t.bytes_rest(), 0) + '\n';
    }
  }
  return s;
}

std::string links(const Report& r) {
  std::string s =
      "from,to,sent,received,judged,lost,loss_percent,duplicates,reordered,delay_mean_ms,delay_p50_ms,delay_p95_ms,"
      "jitter_ms\n";
  for (const Link& l : r.links) {
    s += l.from_name + ',' + l.to_name;
    for (const std::uint64_t n : {l.sent, l.received, l.judged, l.lost}) s += ',' + std::to_string(n);
    s += ',' + fixed(l.loss_percent(), 3) + ',' + std::to_string(l.duplicates) + ',' + std::to_string(l.reordered);
    for (const double v : {l.delay_mean_ms, l.delay_p50_ms, l.delay_p95_ms, l.jitter_ms})
      s += ',' + (std::isnan(v) ? "" : fixed(v, 3));
    s += '\n';
  }
  return s;
}

std::string authority(const Report& r) {
  std::string s = "tick,seconds,body,owner\n";
  for (const AuthorityChange& a : r.authority)
    s += std::to_string(a.tick) + ',' + seconds(a.tick) + ',' + std::to_string(a.body) + ',' + owner_name(a.owner) +
         '\n';
  return s;
}

}  // namespace

std::vector<NamedText> csv_files(const Report& r) {
  return {{"inconsistency.csv", inconsistency(r)},
          {"fidelity.csv", fidelity(r)},
          {"traffic.csv", traffic(r)},
          {"links.csv", links(r)},
          {"authority.csv", authority(r)}};
}

}  // namespace padr::report
