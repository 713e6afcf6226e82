#include "common/model/technique.h"

#include "common/model/user_error.h"

namespace padr {

std::vector<std::string_view> technique_names() {
  return {"avatar-only", "fixed", "adaptive", "full", "everything"};
}

Technique technique_by_name(std::string_view name) {
  Technique t;
  t.name = std::string(name);
  if (name == "full") return t;
  // What others are measured against is told to the bit, and takes what it takes.
  t.budget = 0;
  t.precision = Precision::kExact;
  if (name == "everything") {
    t.predictor = Predictor::kNone;  // no threshold waits for it
    t.every_tick = true;
    return t;
  }
  // The three of the paper: first order, updates applied on arrival, one for every contact and chain, a world of one's
  // own.
  t.unowned = Unowned::kLive;
  t.replay = false;
  t.model = Model::kFirst;
  t.time_space = 0;
  t.threshold_high = 0.8F;
  t.threshold_low = 0.3F;
  t.body_threshold = 0;
  t.update_every_contact = true;
  if (name == "adaptive") return t;
  t.predictor = Predictor::kNone;
  t.threshold_high = t.threshold_low = 0.5F;
  if (name == "fixed") return t;
  t.authority = false;
  if (name == "avatar-only") return t;
  throw UserError("--technique: '" + t.name +
                  "' is not allowed; give one of avatar-only, fixed, adaptive, full, everything");
}

}  // namespace padr
