#pragma once

#include "common/model/state.h"
#include "tools/lab/alternatives/playout.h"

namespace padr::lab::alternatives {

/// An entity in the snapshots around a moment; `a` is there, others may be null.
struct Around {
  const Quantised* before = nullptr;
  const Quantised* a = nullptr;
  const Quantised* b = nullptr;
  const Quantised* after = nullptr;
};

/// Where an entity is at a moment: on the cubic Hermite curve through the snapshots around it, with slopes from their
/// neighbours (Fiedler recommends it for low rates, and it is no worse for high ones). If the next snapshot is late,
/// straight on for a quarter of a second, as in Source, and then it stays.
BodyState between(const Quantiser& quantiser, const Around& q, const Playout::Moment& m);

}  // namespace padr::lab::alternatives
