#include "tools/lab/examples/variant.h"

#include <array>

#include "shell/technique_text.h"

namespace padr::lab::examples {
namespace {

constexpr std::array<const char*, 4> kPredictors{"lookahead", "density", "path-density", "pcc"};

Variant variant(const std::string& label, const std::string& flags, const char* predictor = "") {
  return {label, flags, shell::technique_of(flags), predictor};
}

/// 0.8 m is the paper's highest; a fixed threshold is as good as no predictor.
Variant fixed(const std::string& base) {
  return variant(base + ", no predictor", base + " --threshold 0.8 --predictor none");
}

Variant adapted(const std::string& base, const char* predictor) {
  const std::string threshold = base == "adaptive" ? "" : " --threshold 0.8:0.3";
  return variant(base + ", " + predictor, base + threshold + " --predictor " + predictor, predictor);
}

}  // namespace

std::vector<Variant> variants() {
  std::vector<Variant> all{without_authority()};
  for (const char* p : kPredictors) all.push_back(adapted("avatar-only", p));
  all.push_back(fixed("adaptive"));
  for (const char* p : kPredictors) all.push_back(adapted("adaptive", p));
  all.push_back(variant("adaptive, no end updates", "adaptive --end-update off"));
  all.push_back(variant("adaptive, no proxy updates", "adaptive --proxy-update off"));
  all.push_back(variant("adaptive, neither of them", "adaptive --end-update off --proxy-update off"));
  all.push_back(variant("full", "full"));
  return all;
}

Variant without_authority() {
  return fixed("avatar-only");
}

Variant with_authority() {
  return fixed("adaptive");
}

}  // namespace padr::lab::examples
