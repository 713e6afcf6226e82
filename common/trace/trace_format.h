#pragma once

// What the writer and the reader of traces share; nobody else but their tests includes it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/model/hash.h"
#include "common/trace/events.h"
#include "proto/trace.pb.h"

namespace padr::trace {

/// A record is never longer: the largest is a header with a scenario's text.
inline constexpr std::size_t kMaxRecordBytes = 16U << 20U;

inline constexpr std::uint32_t kAwakeBit = 1U << 6U;  ///< in Step.changed_fields

/// Confirmed.owner: whose an entity is, and whether it is there.
inline std::uint32_t put_owner(PeerId owner, bool present) {
  return 2 * (owner == kNoPeer ? 0U : owner + 1U) + (present ? 1U : 0U);
}

/// An entity before anything was told of it.
inline constexpr BodyState kUntold{{}, 0, {}, 0, false};

inline std::array<float, 6> fields_of(const BodyState& s) {
  return {s.position.x, s.position.y, s.angle, s.velocity.x, s.velocity.y, s.spin};
}
inline void set_fields(BodyState& s, const std::array<float, 6>& v) {
  s.position = {v[0], v[1]};
  s.angle = v[2];
  s.velocity = {v[3], v[4]};
  s.spin = v[5];
}

/// The agreed world before anything was told of it.
inline Truth nothing_agreed(std::size_t entities) {
  return {std::vector<PeerId>(entities, kNoPeer), std::vector<bool>(entities, false), std::vector<Vec2>(entities)};
}

/// The record as it stands in the file: after the varint of its length.
std::vector<std::byte> delimited(const file::Record& record);
/// `bytes`: as delimited() makes them.
void add_record(Hasher& sum, std::span<const std::byte> bytes);
/// `bytes`: a record that ends with its own checksum, as Header and Footer do; all but that is added.
void add_up_to_checksum(Hasher& sum, std::span<const std::byte> bytes);
/// Of all records that were added; never 0.
std::uint32_t checksum_of(const Hasher& sum);

void put_technique(const Technique& t, file::Technique& out);
/// False if a knob is out of range.
bool take_technique(const file::Technique& in, Technique& t);

void put_header(const Header& h, file::Header& out);
/// Empty if all is well, otherwise what is wrong with it.
std::string take_header(const file::Header& in, Header& h);

}  // namespace padr::trace
