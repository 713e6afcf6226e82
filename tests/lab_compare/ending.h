#pragma once

#include <algorithm>
#include <memory>
#include <utility>

#include "common/scenarios/input.h"

namespace padr::lab::alternatives {

/// Another input until a tick, then where that has led.
class Ending final : public scenarios::InputSource {
 public:
  Ending(std::unique_ptr<scenarios::InputSource> input, Tick last) : input_(std::move(input)), last_(last) {}
  Vec2 target(Tick tick) override { return input_->target(std::min(tick, last_)); }

 private:
  std::unique_ptr<scenarios::InputSource> input_;
  Tick last_;
};

}  // namespace padr::lab::alternatives
