#include "tools/lab/examples/variant.h"

#include <array>

namespace padr::lab::examples {
namespace {

constexpr std::array<const char*, 4> kPredictors{"lookahead", "density", "path-density", "pcc"};
constexpr const char* kFixed = "0.8";  // m, the paper's highest; a fixed threshold is as good as no predictor
constexpr const char* kAdapted = "0.8:0.3";

Variant fixed(const std::string& base) {
  Variant v{base + ", no predictor", base + " --threshold " + kFixed + " --predictor none", technique_by_name(base)};
  set_threshold(v.technique, kFixed);
  set_predictor(v.technique, "none");
  return v;
}

Variant adapted(const std::string& base, const char* predictor) {
  const std::string threshold = base == "adaptive" ? "" : std::string(" --threshold ") + kAdapted;
  Variant v{base + ", " + predictor, base + threshold + " --predictor " + predictor, technique_by_name(base),
            predictor};
  set_threshold(v.technique, kAdapted);
  set_predictor(v.technique, predictor);
  return v;
}

Variant ablated(bool end, bool proxy) {
  const char* without = !end && !proxy ? "neither of them" : end ? "no proxy updates" : "no end updates";
  Variant v{std::string("adaptive, ") + without, "adaptive", technique_by_name("adaptive")};
  if (!end) {
    v.flags += " --end-update off";
    set_end_update(v.technique, "off");
  }
  if (!proxy) {
    v.flags += " --proxy-update off";
    set_proxy_update(v.technique, "off");
  }
  return v;
}

}  // namespace

std::vector<Variant> variants() {
  std::vector<Variant> all{without_authority()};
  for (const char* p : kPredictors) all.push_back(adapted("avatar-only", p));
  all.push_back(fixed("adaptive"));
  for (const char* p : kPredictors) all.push_back(adapted("adaptive", p));
  all.push_back(ablated(false, true));
  all.push_back(ablated(true, false));
  all.push_back(ablated(false, false));
  all.push_back({"full", "full", technique_by_name("full")});
  return all;
}

Variant without_authority() {
  return fixed("avatar-only");
}

Variant with_authority() {
  return fixed("adaptive");
}

}  // namespace padr::lab::examples
