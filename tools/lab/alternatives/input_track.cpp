#include "tools/lab/alternatives/input_track.h"

#include <algorithm>

#include "common/world/avatar_control.h"

namespace padr::lab::alternatives {
namespace {

constexpr std::size_t kCountBits = 20;  // of put_small, for as many inputs as a datagram can have

std::uint32_t folded(std::int32_t v) {
  return v < 0 ? 2 * static_cast<std::uint32_t>(-(v + 1)) + 1 : 2 * static_cast<std::uint32_t>(v);
}

std::int32_t unfolded(std::uint32_t u) {
  const auto half = static_cast<std::int32_t>(u / 2);
  return u % 2 == 1 ? -half - 1 : half;
}

/// Where a hand gets to that goes on as it did; within what a place can be.
Quantised onward(const Quantised& last, const Quantised& before_last, const Quantiser& quantiser) {
  Quantised q;
  q.x = 2 * last.x - before_last.x;
  q.y = 2 * last.y - before_last.y;
  return quantiser.clamped(q);
}

}  // namespace

const Quantised& InputTrack::at(Tick tick) const {
  return inputs_[static_cast<std::size_t>(std::clamp(tick, first_, newest()) - first_)];
}

void InputTrack::forget_before(Tick tick) {
  while (first_ < tick && inputs_.size() > 1) {
    inputs_.pop_front();
    ++first_;
  }
}

std::uint64_t InputTrack::write(BitWriter& w, Tick from, Tick most, std::size_t most_bits,
                                const Quantiser& quantiser) const {
  BitWriter inputs;
  std::uint32_t count = 0;
  for (Tick t = from; t <= std::min(newest(), from + most - 1); ++t, ++count) {
    BitWriter one;
    if (count == 0) {
      quantiser.write_point(one, quantiser.state(at(t)).position);
    } else {
      const Quantised guess = onward(at(t - 1), at(count == 1 ? t - 1 : t - 2), quantiser);
      one.put_small(folded(at(t).x - guess.x));
      one.put_small(folded(at(t).y - guess.y));
    }
    if (kCountBits + inputs.bits() + one.bits() > most_bits) break;
    inputs.append(one);
  }
  w.put_small(count);
  w.append(inputs);
  return count;
}

InputReader::InputReader(BitReader& r, const Quantiser& quantiser)
    : r_(r), quantiser_(quantiser), left_(r.get_small()) {}

Quantised InputReader::next() {
  --left_;
  Quantised q;
  if (read_++ == 0) {
    q = input_of(quantiser_.read_point(r_), quantiser_);
    before_last_ = q;
  } else {
    q = onward(last_, before_last_, quantiser_);
    // A sum that wraps round is clamped like any other that no writer writes.
    const auto plus = [](std::int32_t a, std::int32_t b) {
      return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
    };
    q.x = plus(q.x, unfolded(r_.get_small()));
    q.y = plus(q.y, unfolded(r_.get_small()));
    q = quantiser_.clamped(q);
    before_last_ = last_;
  }
  last_ = q;
  return q;
}

void let_all_play(world::World& world) {
  for (PeerId p = 0; p < world.slots(); ++p) {
    world.set_present(world.avatar(p), true);
    world.set_free(p, true);
  }
}

void step_with_inputs(world::World& world, std::span<const Quantised> inputs, const Quantiser& quantiser) {
  for (PeerId p = 0; p < inputs.size(); ++p) world::drive_avatar(world, p, quantiser.state(inputs[p]).position);
  world.step();
}

Quantised input_of(Vec2 target, const Quantiser& quantiser) {
  BodyState s;
  s.position = target;
  Quantised q = quantiser.place(s);
  q.angle = 0;
  q.awake = true;
  return q;
}

Quantised rest_of(const world::World& world, PeerId p, const Quantiser& quantiser) {
  return input_of(world.position(world.avatar(p)), quantiser);
}

}  // namespace padr::lab::alternatives
