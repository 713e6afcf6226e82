#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/model/hash.h"
#include "common/model/scene.h"
#include "common/sync/updates.h"

namespace padr::sync {

/// What is in a body slot of a region.
struct Resident {
  bool present = false;  ///< otherwise the rest is zero
  BodyName name;
  std::uint32_t crossings = 0;  ///< of borders, so far
  std::uint32_t bound = 0;      ///< region that it is being handed over to; 0: none
  friend bool operator==(const Resident&, const Resident&) = default;
};

/// Which bodies are in a region of a crowd, and which have gone out of it lately. Of a scene that is no region:
/// nothing.
struct Residents {
  struct Gone {
    BodyName name;
    std::uint32_t crossings = 0;
    Tick at = 0;
    friend bool operator==(const Gone&, const Gone&) = default;
  };
  std::vector<Resident> slots;  ///< by body
  std::vector<Gone> gone;       ///< in the order they went; an entry that comes late must not bring them back
  friend bool operator==(const Residents&, const Residents&) = default;

  std::optional<EntityId> find(BodyName name) const;
  /// The most crossings it is known here to have made, whether it is here or has gone; 0 if nothing is known.
  std::uint32_t newest(BodyName name) const;
  /// The slot for what comes in: the one it is in already with fewer crossings, or else the lowest empty one of its
  /// build. Nothing if it is there with as many, has gone out since, or there is no room.
  std::optional<EntityId> slot_for(const Passage& p, const RegionDef& region) const;
  /// The slot that what goes out is in, with fewer crossings; nothing if there is none.
  std::optional<EntityId> slot_of(const Passage& p) const;
  void note_gone(const Passage& p, Tick now);

  /// An exit is remembered for so long, and so many at most.
  static constexpr Tick kRemembered = 30 * kTicksPerSecond;
  static constexpr std::size_t kMostGone = 64;
};

/// As the scene says.
Residents residents_of(const Scene& scene);

void add_to_hash(WideHasher& h, const Residents& r);

}  // namespace padr::sync
