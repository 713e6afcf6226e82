#pragma once

// Columns of places and flags, for the codec; nobody else includes it.

#include <vector>

#include "common/monitor/format.h"

namespace padr::monitor {

using Column = google::protobuf::RepeatedField<std::int32_t>;

/// A place in whole millimetres and milliradians.
struct Whole {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t angle = 0;
  friend Whole operator-(Whole a, Whole b) { return {a.x - b.x, a.y - b.y, a.angle - b.angle}; }
};

std::int32_t to_millimetres(float metres);
/// False if it is farther off than kMostMetres.
bool from_millimetres(std::int64_t in, float& metres);
Whole to_whole(const Place& p);

void put(const Whole& w, Column& out);
/// Bytes that it takes in a column.
std::size_t size_of(const Whole& w);

/// The places of a column, each told as the difference to that of `base`, which is empty for none. False if one is out
/// of range, or they are not as many as `count`.
bool take(const Column& in, std::size_t count, const Column& base, std::vector<Place>& out, Column& sums);

void put_flags(const EntityFlags& f, std::string& flags, std::string& owners);
/// False if the columns differ in length or have something that makes no sense, or exceed the world.
bool take_flags(const std::string& flags, const std::string& owners, std::uint32_t first, std::uint32_t total,
                std::vector<EntityFlags>& out);

}  // namespace padr::monitor
