#pragma once

#include <cstdint>
#include <string>

namespace padr::world {

/// How physics comes out here, in 64 bits: two machines whose fingerprints differ compute differently and cannot share
/// a session. The parts, from the highest bit on, so that a difference can be named:
///   8 bits   habits of this build and machine, see Habit; 0 is what every peer should have
///   16 bits  hash of sines, cosines, arc tangents and roots, as Box2D calls them
///   16 bits  hash of a short canned simulation of bodies that never have more than one contact
///   24 bits  hash of one of a pile
/// Takes some milliseconds.
std::uint64_t physics_fingerprint();

/// Ways of computing that give other bits. A bit of the fingerprint's highest byte for each.
enum class Habit : std::uint8_t {
  kFuses = 1U << 0U,       ///< one rounding for a multiplication and an addition, in this program
  kBox2dFuses = 1U << 1U,  ///< the same in Box2D
  kWide = 1U << 2U,        ///< more digits than float and double have, between two operations
  kReorders = 1U << 3U,    ///< sums in another order than written
  kFlushes = 1U << 4U,     ///< 0 for numbers below 2^-126
  kRoundsAway = 1U << 5U,  ///< another rounding than to the nearest
  kOtherBytes = 1U << 6U,  ///< the highest byte of a number comes first
  kOtherBox2d = 1U << 7U,  ///< a Box2D that is not 2.4
};

/// What differs between two fingerprints, and what to do about it, for people: such as "the newcomer fuses
/// multiplications and additions: compile it with -ffp-contract=off". `first` and `second` say whose they are. Empty if
/// they are equal.
std::string physics_difference(std::uint64_t a, std::uint64_t b, const std::string& first, const std::string& second);

/// The part of a fingerprint that says how this build and machine compute, in words, one for each Habit that it has;
/// empty if it computes as every peer should.
std::string habits_text(std::uint64_t fingerprint);

}  // namespace padr::world
