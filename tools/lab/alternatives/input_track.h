#pragma once

#include <deque>
#include <span>

#include "common/model/ids.h"
#include "common/world/world.h"
#include "tools/lab/alternatives/quantised.h"

namespace padr::lab::alternatives {

/// The inputs of one player, tick by tick, as far as they are known without a gap. An input is the point that the
/// avatar is drawn towards in that tick's step; of a Quantised its place alone.
class InputTrack {
 public:
  /// Until tick `until` the input is `rest`.
  InputTrack(const Quantised& rest, Tick until) : first_(until), inputs_{rest} {}

  Tick newest() const { return first_ + static_cast<Tick>(inputs_.size()) - 1; }
  /// Beyond the newest one that one again, which is GGPO's prediction; before those that are kept the oldest one.
  const Quantised& at(Tick tick) const;
  /// That of the tick after the newest.
  void add(const Quantised& input) { inputs_.push_back(input); }
  /// Those before `tick` are not asked for any more.
  void forget_before(Tick tick);

  /// Appends the inputs from `from` on, at most `most` and as many as fit into `most_bits`, with their number: the
  /// first whole, the others as differences to a hand that goes on as before. Returns how many.
  std::uint64_t write(BitWriter& w, Tick from, Tick most, std::size_t most_bits, const Quantiser& quantiser) const;

 private:
  Tick first_;
  std::deque<Quantised> inputs_;
};

/// Reads what InputTrack::write wrote, input by input.
class InputReader {
 public:
  InputReader(BitReader& r, const Quantiser& quantiser);
  /// Inputs that are still to come.
  std::uint32_t left() const { return left_; }
  Quantised next();

 private:
  BitReader& r_;
  const Quantiser& quantiser_;
  std::uint32_t left_;
  std::uint32_t read_ = 0;
  Quantised last_;
  Quantised before_last_;
};

/// A world in which every avatar pushes everything, as all alternatives play it.
void let_all_play(world::World& world);
/// A step that depends on the world and the inputs of all players, by peer, and on nothing else.
void step_with_inputs(world::World& world, std::span<const Quantised> inputs, const Quantiser& quantiser);
/// What an avatar that nobody drives yet is driven towards: where it is.
Quantised rest_of(const world::World& world, PeerId p, const Quantiser& quantiser);
/// An input as it travels.
Quantised input_of(Vec2 target, const Quantiser& quantiser);

}  // namespace padr::lab::alternatives
