#pragma once

#include <string>
#include <vector>

#include "tools/lab/examples/measure.h"
#include "tools/lab/examples/variant.h"

namespace padr::lab::examples {

/// What a predictor was worth in one story: avatar-only with the threshold adapted by it, against avatar-only without
/// any. The event to be foreseen is, in each take, what comes first without a predictor: the model's hit in the other
/// view, or the avatar's true contact.
struct Verdict {
  std::string story;
  std::string predictor;
  int takes = 0;
  int contacts = 0;      ///< takes in which the avatar truly touched
  int foreseen = 0;      ///< of these, those that it warned of before the contact
  int warned = 0;        ///< takes in which it warned before the event
  double lead_s = 0;     ///< by which it did, mean over these; 0 if there are none
  int hits = 0;          ///< takes in which the model hit all the same
  double cost_m = 0;     ///< sum over bodies in the end without a predictor, mean over takes
  double avoided_m = 0;  ///< of that
  std::string sentence;  ///< what it did and why, from these numbers
};

/// `none`: the story's takes without a predictor; `with`: the same takes under `variant`, whose predictor is judged.
Verdict judge(const std::string& story, const Variant& variant, const std::vector<Cost>& none,
              const std::vector<Cost>& with);

}  // namespace padr::lab::examples
