#pragma once

#include "tools/report/report.h"

namespace padr::report {

/// Per second of one peer's time.
struct Rates {
  double updates_per_s = 0;
  double datagrams_per_s = 0;
  double wire_kbps = 0;  ///< kbit/s
  double repeats_per_s = 0;
};

inline double per_second(std::uint64_t n, double seconds) {
  return seconds > 0 ? static_cast<double>(n) / seconds : 0;
}

inline Rates rates_of(const Traffic& t, double seconds) {
  return {per_second(t.all_updates(), seconds), per_second(t.datagrams, seconds),
          per_second(t.wire_bytes, seconds) * 8.0 / 1000.0, per_second(t.repeats, seconds)};
}

inline double per_tick(std::uint64_t steps, Tick ticks) {
  return ticks > 0 ? static_cast<double>(steps) / static_cast<double>(ticks) : 0;
}

}  // namespace padr::report
