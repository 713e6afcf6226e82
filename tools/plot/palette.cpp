#include "tools/plot/palette.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace padr::plot {
namespace {

// Okabe and Ito's colours, which people with any of the common colour blindnesses tell apart. Their black and their
// pale yellow cannot be seen on a black or a white page: an olive and a brown stand for them. The page of padr-monitor
// has the same ones in palette.js; a test compares the two.
constexpr std::array<std::string_view, kColours> kByNumber{"#0072B2", "#E69F00", "#009E73", "#D55E00",
                                                           "#56B4E9", "#CC79A7", "#B9A90B", "#8A6D5B"};
constexpr std::array<std::string_view, 4> kShades{"#000000", "#555555", "#999999", "#DDDDDD"};

struct Entry {
  std::string_view name;
  Look look;
};

// Filled marks for techniques; hollow ones are left for their variants. A longer name stands before its beginning.
constexpr std::array<Entry, 12> kTechniques{{
    {"avatar-only", {"#D55E00", 0, 9}},
    {"fixed", {"#E69F00", 0, 5}},
    {"adaptive", {"#0072B2", 0, 7}},
    {"full", {"#009E73", 0, 13}},
    {"snapshot", {"#CC79A7", 0, 11}},
    {"state-sync", {"#56B4E9", 0, 15}},
    {"rollback", {"#882255", 0, 8}},
    {"lockstep", {"#999933", 0, 10}},
    {"dis", {"#000000", 3, 2}},
    {"everything-no-replay", {"#777777", 4, 1}},
    {"everything --replay off", {"#777777", 4, 1}},
    {"everything", {"#777777", 0, 3}},
}};
constexpr Look kUnknown{"#333333", 0, 6};
constexpr std::array<int, 9> kVariantMarks{6, 4, 8, 10, 12, 14, 1, 2, 3};
constexpr int kDashes = 5;

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

std::string_view colour_of(std::string_view technique) {
  return look_of(technique).colour;
}

std::string_view colour_by_number(std::size_t i) {
  return kByNumber[i % kColours];
}

std::string_view shade(std::size_t i) {
  return kShades[std::min(i, kShades.size() - 1)];
}

}  // namespace padr::plot
