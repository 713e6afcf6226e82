#include "common/link/loss.h"

namespace padr::link {

namespace {

Chance correlation_of(const LossProcess::Model& model) {
  const auto* random = std::get_if<Knob>(&model);
  return random == nullptr ? 0 : random->correlation;
}

}  // namespace

LossProcess::LossProcess(std::uint64_t seed, const Model& model)
    : model_(model), correlated_(derive_seed(seed, 1), correlation_of(model)), rng_(derive_seed(seed, 2)) {}

void LossProcess::set_model(const Model& model) {
  model_ = model;
  correlated_.set_correlation(correlation_of(model));
  state_ = State::kGapSend;
  bad_ = false;
}

bool LossProcess::next() {
  return std::visit([this](const auto& model) { return next_of(model); }, model_);
}

bool LossProcess::next_of(const Knob& random) {
  return correlated_.chance(random.chance);
}

/// One draw decides the transition; the packet is lost if the state it leads to is a losing one.
bool LossProcess::next_of(const FourStateLoss& chain) {
  const std::uint32_t draw = rng_.next_u32();
  switch (state_) {
    case State::kGapSend:
      // The parser keeps p13 + p14 within 100 %, so the sum does not wrap; the same for p31 + p32 below.
      if (happens(chain.p14, draw)) {
        state_ = State::kGapLose;
      } else if (happens(chain.p14 + chain.p13, draw)) {
        state_ = State::kBurstLose;
      }
      break;
    case State::kBurstSend:
      if (happens(chain.p23, draw)) state_ = State::kBurstLose;
      break;
    case State::kBurstLose:
      if (happens(chain.p32, draw)) {
        state_ = State::kBurstSend;
      } else if (happens(chain.p32 + chain.p31, draw)) {
        state_ = State::kGapSend;
      }
      break;
    case State::kGapLose:
      state_ = State::kGapSend;
      break;
  }
  return state_ == State::kGapLose || state_ == State::kBurstLose;
}

/// Two draws: the transition, then the loss by the state *before* it.
bool LossProcess::next_of(const GilbertElliottLoss& chain) {
  const bool was_bad = bad_;
  if (happens(was_bad ? chain.r : chain.p, rng_.next_u32())) bad_ = !bad_;
  return happens(was_bad ? chain.lose_bad : chain.lose_good, rng_.next_u32());
}

}  // namespace padr::link
