#pragma once

#include <cstdint>
#include <variant>

#include "common/link/netem_spec.h"
#include "common/model/rng.h"

namespace padr::link {

/// Whether an event of probability `chance` happens at draw `random`: never for 0, always for kAlways.
constexpr bool happens(Chance chance, std::uint32_t random) {
  return chance == kAlways || random < chance;
}

/// Numbers that resemble the one before: x = v * (1 - rho) + x_before * rho in 32-bit fixed point, v uniform; netem's
/// formula. The mean stays 1/2 but the spread shrinks, so rare events become much rarer than asked.
class CorrelatedRandom {
 public:
  CorrelatedRandom(std::uint64_t seed, Chance rho) : rng_(seed), rho_(rho), last_(rng_.next_u32()) {}

  std::uint32_t next() {
    const std::uint64_t v = rng_.next_u32();
    if (rho_ == 0) return static_cast<std::uint32_t>(v);
    const std::uint64_t rho = std::uint64_t{rho_} + 1;
    last_ = static_cast<std::uint32_t>((v * ((std::uint64_t{1} << 32U) - rho) + last_ * rho) >> 32U);
    return last_;
  }
  bool chance(Chance c) { return c != 0 && happens(c, next()); }
  void set_correlation(Chance rho) { rho_ = rho; }

 private:
  Rng rng_;
  Chance rho_;
  std::uint32_t last_;
};

/// Decides packet by packet what is lost: independent or correlated losses, the 4-state Markov chain, or
/// Gilbert-Elliott. The two chains draw uncorrelated numbers and begin in their good state.
class LossProcess {
 public:
  using Model = std::variant<Knob, FourStateLoss, GilbertElliottLoss>;

  LossProcess(std::uint64_t seed, const Model& model);

  /// A new model, from its good state; the random stream goes on where it is.
  void set_model(const Model& model);

  /// True if the next packet is lost.
  bool next();

 private:
  enum class State : std::uint8_t { kGapSend, kBurstSend, kBurstLose, kGapLose };

  bool next_of(const Knob& random);
  bool next_of(const FourStateLoss& chain);
  bool next_of(const GilbertElliottLoss& chain);

  Model model_;
  CorrelatedRandom correlated_;
  Rng rng_;
  State state_ = State::kGapSend;
  bool bad_ = false;
};

}  // namespace padr::link
