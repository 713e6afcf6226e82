#include "common/scenarios/scenarios.h"

#include <string>

#include "common/model/user_error.h"
#include "common/scenarios/embedded.h"
#include "common/scenarios/scene_draft.h"

namespace padr::scenarios {

Scene load(std::string_view text, std::string_view label, std::uint64_t seed) {
  const Document document(text, label);
  SceneDraft draft = draft_of(document);
  check_placement(draft, document);
  scatter(draft, document, seed);
  add_spawns(draft, document, seed);
  return std::move(draft.scene);
}

std::vector<std::string_view> embedded_names() {
  std::vector<std::string_view> names;
  for (const Embedded& e : embedded()) names.push_back(e.name);
  return names;
}

std::string_view embedded_text(std::string_view name) {
  for (const Embedded& e : embedded()) {
    if (e.name == name) return e.text;
  }
  std::string known;
  for (const Embedded& e : embedded()) known += (known.empty() ? "" : ", ") + std::string(e.name);
  throw UserError("scenario: \"" + std::string(name) + "\" is not built in, allowed: " + known);
}

Scene load_embedded(std::string_view name, std::uint64_t seed) {
  return load(embedded_text(name), std::string(name) + ".textproto", seed);
}

}  // namespace padr::scenarios
