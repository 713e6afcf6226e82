#include "tools/plot/palette.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <set>

namespace padr::plot {
namespace {

// Okabe and Ito's colours, which people with any of the common colour blindnesses tell apart. Their black and their
// pale yellow cannot be seen on a black or a white page: a violet and a brown stand for them. The page of padr-monitor
// has the same ones in palette.js; a test compares the two.
constexpr std::array<std::string_view, kColours> kByNumber{"#0072B2", "#E69F00", "#009E73", "#D55E00",
                                                           "#56B4E9", "#CC79A7", "#8250DF", "#8A6D5B"};
constexpr std::array<std::string_view, 4> kShades{"#000000", "#555555", "#999999", "#DDDDDD"};

struct Entry {
  std::string_view name;
  Look look;
};

// Filled marks for techniques; hollow ones are left for their variants. A longer name stands before its beginning.
constexpr std::array<Entry, 21> kTechniques{{
    {"avatar-only", {"#D55E00", 0, 9}},
    {"fixed, time stamps", {"#A06A00", 4, 12}},
    {"fixed", {"#E69F00", 0, 5}},
    {"adaptive", {"#0072B2", 0, 7}},
    {"full at larger thresholds", {"#00583F", 4, 6}},
    {"full", {"#009E73", 0, 13}},
    {"snapshot coarse", {"#7E3F63", 4, 10}},
    {"snapshot", {"#CC79A7", 0, 11}},
    {"state-sync coarse", {"#2A6F97", 4, 14}},
    {"state-sync", {"#56B4E9", 0, 15}},
    {"rollback 10 Hz", {"#E0709A", 1, 6}},
    {"rollback 20 Hz", {"#B2182B", 4, 4}},
    {"rollback coarse", {"#4D1230", 4, 14}},
    {"rollback", {"#882255", 0, 8}},
    {"lockstep 20 Hz", {"#5F6B00", 3, 12}},
    {"lockstep", {"#999933", 0, 10}},
    {"dis", {"#000000", 3, 2}},
    {"everything-no-replay", {"#444444", 4, 1}},
    {"everything --replay off", {"#444444", 4, 1}},
    {"everything", {"#777777", 0, 3}},
}};
constexpr Look kUnknown{"#333333", 0, 6};
constexpr std::array<int, 9> kVariantMarks{6, 4, 8, 10, 12, 14, 1, 2, 3};
constexpr int kDashes = 5;
// For distinct_looks, those that are farthest from all above first.
constexpr std::array<std::string_view, 10> kSpareColours{"#332288", "#8A6D5B", "#CC6677", "#44AA99", "#AA4499",
                                                         "#6699CC", "#661100", "#EE3377", "#117733", "#B9A90B"};
constexpr std::array<int, 15> kSpareMarks{6, 4, 12, 14, 8, 10, 2, 1, 3, 5, 7, 9, 11, 13, 15};

bool begins(std::string_view text, std::string_view name) {
  return text.starts_with(name) && (text.size() == name.size() || text[name.size()] == ' ');
}

}  // namespace

Look look_of(std::string_view technique, int variant) {
  assert(variant >= 0);
  const auto* const known = std::find_if(kTechniques.begin(), kTechniques.end(),
                                         [technique](const Entry& e) { return begins(technique, e.name); });
  Look look = known == kTechniques.end() ? kUnknown : known->look;
  if (variant == 0) return look;
  look.dash = (look.dash + variant) % kDashes;
  look.point = kVariantMarks[static_cast<std::size_t>(variant - 1) % kVariantMarks.size()];
  return look;
}

std::vector<Look> distinct_looks(const std::vector<std::string>& titles) {
  std::vector<Look> looks;
  std::set<std::string_view> colours;
  std::set<int> marks;
  std::vector<bool> settled;
  // Known techniques have the first choice, whatever comes before them.
  for (const std::string& title : titles) {
    looks.push_back(look_of(title));
    Look& look = looks.back();
    const bool known = look.colour != kUnknown.colour && colours.insert(look.colour).second;
    if (!known) look.colour = "";
    settled.push_back(known && marks.insert(look.point).second);
  }
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (looks[i].colour.empty()) {
      const auto* const free = std::find_if(kSpareColours.begin(), kSpareColours.end(),
                                            [&colours](std::string_view c) { return !colours.contains(c); });
      looks[i].colour = free == kSpareColours.end() ? kUnknown.colour : *free;
      colours.insert(looks[i].colour);
    }
    if (settled[i]) continue;
    const auto* const free =
        std::find_if(kSpareMarks.begin(), kSpareMarks.end(), [&marks](int m) { return !marks.contains(m); });
    if (free == kSpareMarks.end()) continue;  // the colour tells it apart
    looks[i].point = *free;
    marks.insert(*free);
  }
  return looks;
}

std::string_view colour_by_number(std::size_t i) {
  return kByNumber[i % kColours];
}

std::string_view shade(std::size_t i) {
  return kShades[std::min(i, kShades.size() - 1)];
}

}  // namespace padr::plot
