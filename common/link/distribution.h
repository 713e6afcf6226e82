#pragma once

#include <array>
#include <cstdint>

#include "common/link/netem_spec.h"

namespace padr::link {

/// A distribution of mean about 0 as a table of its quantiles, in 1/8192 of a JITTER: entry i is the value below which
/// a share (i + 1/2) / 4096 of all draws lies. A draw is one entry, each as likely as another.
using DistributionTable = std::array<std::int16_t, 4096>;
inline constexpr int kDistributionScale = 8192;

/// The table of a distribution; null for uniform, which needs none. Computed from the inverse distribution functions,
/// with additions, multiplications and divisions only, so it is the same on every machine:
///   normal        standard normal, within +-3.67;
///   pareto        4/3 of a Pareto(alpha 3, minimum 1) less its mean 1.5; from -0.67, cut at 4 as netem's is by its
///                 16-bit entries. Mean -0.03, standard deviation 0.82: JITTER is not quite its deviation;
///   paretonormal  1/4 normal + 3/4 pareto, quantile by quantile. Standard deviation 0.83.
const DistributionTable* distribution_table(Distribution distribution);

/// The delay that a 32-bit random number selects: `mean` plus the table's entry `random % 4096` times `jitter`, or
/// without a table `random` modulo the 2 * jitter nanoseconds of [mean - jitter, mean + jitter). May be negative.
/// 0 <= jitter <= kMaxJitter. Both as in the kernel, with two consequences that are also the kernel's: correlation
/// of `random` hardly shows in the delays, and the uniform one is a little heavier at its low end (by 1 % in part of
/// the range for a jitter of 20 ms; noticeable for seconds).
Nanos distributed(Nanos mean, Nanos jitter, const DistributionTable* table, std::uint32_t random);

}  // namespace padr::link
