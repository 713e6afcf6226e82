#include "tools/lab/compare/contestant.h"

#include <algorithm>
#include <array>
#include <set>
#include <sstream>
#include <utility>

#include "common/model/user_error.h"
#include "shell/technique_text.h"
#include "tools/lab/alternatives/entrants/entrant.h"
#include "tools/lab/compare/alternative_text.h"

namespace padr::lab::compare {
namespace {

constexpr std::array<std::pair<std::string_view, Group>, 4> kGroups{{{"paper", Group::kPaper},
                                                                     {"ours", Group::kOurs},
                                                                     {"ablations", Group::kAblation},
                                                                     {"alternatives", Group::kAlternative}}};

template <typename Change>
Technique changed(Technique t, Change change) {
  change(t);
  return t;
}

void add_paper(std::vector<Contestant>& all) {
  const auto add = [&all](const char* id, const char* series, const char* mark, const char* text, const char* what) {
    all.push_back({id, series, mark, Group::kPaper, what, shell::technique_of(text)});
  };
  add("avatar-only", "avatar-only", "", "avatar-only --threshold 0.5",
      "the paper's failure case: dead-reckoned avatars, 0.5 m, nobody owns bodies");
  add("fixed-0.8", "fixed (m)", "0.8", "fixed --threshold 0.8",
      "the paper's: dynamic authority, one threshold of 0.8 m, updates applied on arrival");
  add("fixed-0.5", "fixed (m)", "0.5", "fixed --threshold 0.5", "the same with 0.5 m");
  add("fixed-0.3", "fixed (m)", "0.3", "fixed --threshold 0.3", "the same with 0.3 m");
  add("fixed-0.5-stamped", "fixed, time stamps", "0.5", "fixed --threshold 0.5 --time-stamps on",
      "the same with 0.5 m and time stamps: an update is extrapolated by its age, as in DIS");
  add("adaptive", "adaptive", "", "adaptive", "the paper's: the same with 0.8 m, or 0.3 m when a contact is predicted");
}

void add_ours(std::vector<Contestant>& all) {
  const Technique everything = technique_by_name("everything");
  const Technique late = changed(everything, [](Technique& t) { t.replay = false; });
  const Technique first = changed(everything, [](Technique& t) { t.model = Model::kFirst; });
  all.push_back({"full", "full", "", Group::kOurs,
                 "PADR's own: 0.014 m, or 0.012 m when a contact is predicted; bodies 0.012 m; 64 kbit/s at most",
                 technique_by_name("full")});
  all.push_back({"full-0.3", "full at larger thresholds", "0.3", Group::kOurs,
                 "full with 0.3 m, or 0.1 m; bodies 0.05 m",
                 shell::technique_of("full --threshold 0.3:0.1 --body-threshold 0.05")});
  all.push_back({"full-0.8", "full at larger thresholds", "0.8", Group::kOurs,
                 "full with the paper's adaptive thresholds: 0.8 m, or 0.3 m; bodies 0.1 m",
                 shell::technique_of("full --threshold 0.8:0.3 --body-threshold 0.1")});
  all.push_back({"everything", "everything", "", Group::kOurs,
                 "sends own avatar and every awake own body at every tick, with replay: the limit of full",
                 everything});
  all.push_back(
      {"everything-first", "everything", "first order", Group::kOurs, "the same with the first-order model", first});
  all.push_back({"everything-no-replay", "everything-no-replay", "", Group::kOurs,
                 "the same as everything, applied on arrival", late});
}

void add_ablations(std::vector<Contestant>& all) {
  const Technique full = technique_by_name("full");
  const auto add = [&all, &full](const char* id, const char* part, const char* what, auto change) {
    all.push_back({id, std::string("full no ") + part, "", Group::kAblation, what, changed(full, change)});
  };
  add("full-no-replay", "replay", "full without replay: updates applied on arrival",
      [](Technique& t) { t.replay = false; });
  add("full-no-body-threshold", "body threshold", "full without body threshold",
      [](Technique& t) { t.body_threshold = 0; });
  add("full-no-end-update", "end update", "full, the end of a contact is sent without states",
      [](Technique& t) { t.end_update = false; });
  add("full-no-proxy-update", "proxy update", "full without updates for collisions by proxy",
      [](Technique& t) { t.proxy_update = false; });
  add("full-first", "input model", "full with the first-order model in place of the input model",
      [](Technique& t) { t.model = Model::kFirst; });
  add("full-input", "choice of models", "full with the input model in every update",
      [](Technique& t) { t.model = Model::kInput; });
  add("full-no-lead", "lead", "full, the input model's target is sent as it is now, not as it will be",
      [](Technique& t) { t.lead = 0; });
  add("full-no-foresight", "foresight", "full, an avatar's error counts as it is now, not as it will be",
      [](Technique& t) { t.foresee = 0; });
  add("full-no-time-space", "time-space law", "full, an avatar's error counts only when it exceeds the threshold",
      [](Technique& t) { t.time_space = 0; });
  add("full-exact", "rounding", "full, states are sent to the bit",
      [](Technique& t) { t.precision = Precision::kExact; });
  add("full-no-rest-state", "rest state", "full, a body at rest is released without its state",
      [](Technique& t) { t.rest_state = false; });
}

/// `series`: what shares a curve; `mark`: which point of it.
Contestant alternative(const std::string& id, const std::string& series, const std::string& mark, Group group,
                       const std::string& what, const std::string& text) {
  return {id, series, mark, group, what, *alternative_of(text)};
}

void add_alternatives(std::vector<Contestant>& all) {
  for (const char* hz : {"10", "20", "60"})
    all.push_back(
        alternative(std::string("snapshot-") + hz, "snapshot", hz, Group::kAlternative,
                    std::string("delta-compressed snapshots at ") + hz + " Hz, interpolated with a playout delay",
                    std::string("snapshot --hz ") + hz));
  for (const char* hz : {"5", "8", "10", "20", "60"})
    all.push_back(alternative(
        std::string("state-sync-") + hz, "state-sync", hz, Group::kAlternative,
        std::string("state synchronization at ") + hz + " Hz: priority accumulator, byte budget, local physics",
        std::string("state-sync --hz ") + hz));
  all.push_back(alternative("dis", "dis", "1 m", Group::kAlternative,
                            "as in DIS: dead reckoning of each entity, 1 m and 3 degrees, heartbeats of 5 s",
                            "dis --threshold 1"));
  all.push_back(alternative("dis-0.3m", "dis", "0.3 m", Group::kAlternative, "the same with 0.3 m in place of 1 m",
                            "dis --threshold 0.3"));
  for (const alternatives::Entrant& e : alternatives::all_entrants())
    all.push_back({e.id, e.id, "", Group::kAlternative, e.what, e.spec});
}

Contestant from_inputs(const std::string& name, const char* delay, const char* hz, Group group) {
  const bool slow = std::string(hz) != "60";
  const std::string rate = slow ? std::string("-") + hz + "hz" : "";
  return alternative(name + "-" + delay + rate, name + " " + hz + " Hz", delay, group,
                     name + " at " + hz + " Hz, input delay " + delay + " ticks",
                     name + " --hz " + hz + " --input-delay " + delay);
}

void add_inputs(std::vector<Contestant>& all) {
  for (const char* delay : {"0", "2", "4", "6"})
    all.push_back(from_inputs("rollback", delay, "60", Group::kAlternative));
  for (const char* delay : {"2", "6", "12", "18"})
    all.push_back(from_inputs("lockstep", delay, "60", Group::kAlternative));
  for (Contestant& c : all) {
    if (c.id == "rollback-0") c.what += " (GGPO): inputs alone, a late one predicted to be as the last";
    if (c.id == "lockstep-2") c.what += ": inputs alone, a tick waits until all are there";
  }
}

void add_frontier(std::vector<Contestant>& all) {
  for (const char* budget : {"4", "8", "16", "32"})
    all.push_back({std::string("full-") + budget + "kbit", "full", std::string(budget) + "k", Group::kFrontier,
                   std::string("full with at most ") + budget + " kbit/s",
                   shell::technique_of(std::string("full --budget ") + budget)});
  for (const char* hz : {"10", "20"})
    for (const char* delay : {"0", "2", "4", "6"}) all.push_back(from_inputs("rollback", delay, hz, Group::kFrontier));
  for (const char* delay : {"6", "12", "18"}) all.push_back(from_inputs("lockstep", delay, "20", Group::kFrontier));
  all.push_back(alternative("rollback-0-coarse", "rollback coarse", "0", Group::kFrontier,
                            "rollback-0-20hz with inputs to 1/64 m",
                            "rollback --hz 20 --input-delay 0 --steps-per-m 64"));
  all.push_back(alternative("state-sync-20-coarse", "state-sync coarse", "20", Group::kFrontier,
                            "state-sync-20 with places to 1/256 m", "state-sync --hz 20 --steps-per-m 256"));
  all.push_back(alternative("snapshot-20-coarse", "snapshot coarse", "20", Group::kFrontier,
                            "snapshot-20 with places to 1/256 m", "snapshot --hz 20 --steps-per-m 256"));
  all.push_back(alternative("dis-0.1m", "dis", "0.1 m", Group::kFrontier, "dis with 0.1 m in place of 1 m",
                            "dis --threshold 0.1"));
}

bool is_of(const Contestant& c, std::string_view group) {
  if (group == "all") return c.group != Group::kFrontier;
  if (group == "frontier")
    return c.group == Group::kFrontier || c.group == Group::kAlternative || c.id == "full" || c.id == "everything";
  const auto* const found =
      std::find_if(kGroups.begin(), kGroups.end(), [&group](const auto& g) { return g.first == group; });
  return found != kGroups.end() && found->second == c.group;
}

[[noreturn]] void refuse(const std::string& word, const std::vector<Contestant>& all) {
  std::string allowed = "all, frontier";
  for (const auto& [name, group] : kGroups) allowed += ", " + std::string(name);
  for (const Contestant& c : all) allowed += ", " + c.id;
  throw UserError("--techniques: '" + word + "' is not allowed; give some of " + allowed);
}

}  // namespace

std::string Contestant::setting() const {
  const auto* technique = std::get_if<Technique>(&how);
  return technique != nullptr ? shell::describe(*technique) : what;
}

bool is_budget_of_full(const Contestant& c) {
  const auto* technique = std::get_if<Technique>(&c.how);
  if (technique == nullptr) return false;
  Technique like = technique_by_name("full");
  like.budget = technique->budget;
  return *technique == like;
}

std::vector<Contestant> all_contestants() {
  std::vector<Contestant> all;
  add_paper(all);
  add_ours(all);
  add_ablations(all);
  add_alternatives(all);
  add_inputs(all);
  add_frontier(all);
  return all;
}

Contestant added_contestant(const std::string& text) {
  if (const auto spec = alternative_of(text)) return {text, text, "", Group::kAlternative, "added by --add", *spec};
  const Technique t = shell::technique_of(text);
  return {text, text, "", Group::kOurs, "added by --add", t};
}

std::vector<Contestant> chosen_contestants(const std::string& list) {
  const std::vector<Contestant> all = all_contestants();
  std::set<std::string> ids;
  std::istringstream in(list);
  for (std::string word; std::getline(in, word, ',');) {
    bool known = false;
    for (const Contestant& c : all) {
      const bool meant = word == c.id || is_of(c, word);
      if (meant) ids.insert(c.id);
      known = known || meant;
    }
    if (!known) refuse(word, all);
  }
  if (ids.empty()) refuse(list, all);
  std::vector<Contestant> chosen;
  for (const Contestant& c : all)
    if (ids.contains(c.id)) chosen.push_back(c);
  return chosen;
}

}  // namespace padr::lab::compare
