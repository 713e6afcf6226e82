#include "tools/lab/alternatives/alternative.h"

#include <cassert>

#include "tools/lab/alternatives/dis.h"
#include "tools/lab/alternatives/input_sync.h"
#include "tools/lab/alternatives/snapshot.h"
#include "tools/lab/alternatives/state_sync.h"

namespace padr::lab::alternatives {

std::unique_ptr<Alternative> make_alternative(const Scene& scene, const AlternativeConfig& config) {
  assert(config.spec.hz > 0 && config.spec.hz <= kTicksPerSecond);
  assert((config.spec.kind != Kind::kSnapshot && config.spec.kind != Kind::kInputs) ||
         kTicksPerSecond % config.spec.hz == 0);
  switch (config.spec.kind) {
    case Kind::kSnapshot:
      return std::make_unique<Snapshot>(scene, config);
    case Kind::kStateSync:
      return std::make_unique<StateSync>(scene, config);
    case Kind::kDis:
      return std::make_unique<Dis>(scene, config);
    case Kind::kInputs:
      return std::make_unique<InputSync>(scene, config);
    case Kind::kEntrant:
      return config.spec.make(scene, config);
  }
  return nullptr;
}

}  // namespace padr::lab::alternatives
