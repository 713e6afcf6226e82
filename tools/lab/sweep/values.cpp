#include "tools/lab/sweep/values.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "common/model/user_error.h"

namespace padr::lab::sweep {
namespace {

constexpr double kMostMilliseconds = 60'000;
// Far more than anybody waits for, and few enough to keep in memory.
constexpr std::uint64_t kMostInRange = 1'000'000;

[[noreturn]] void refuse(std::string_view flag, std::string_view value, const std::string& allowed) {
  throw UserError(std::string(flag) + ": '" + std::string(value) + "' is not allowed; give " + allowed);
}

template <typename T>
std::optional<T> number_of(std::string_view text) {
  T v{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return v;
}

template <typename T>
void refuse_repeats(std::string_view flag, std::string_view text, std::vector<T> values) {
  std::sort(values.begin(), values.end());
  if (std::adjacent_find(values.begin(), values.end()) != values.end()) refuse(flag, text, "every value once");
}

struct Unit {
  std::string_view name;
  double milliseconds;
};
constexpr std::array<Unit, 3> kUnits{{{"ms", 1}, {"us", 0.001}, {"s", 1000}}};

const Unit* unit_of(std::string_view word) {
  for (const Unit& u : kUnits)
    if (word.ends_with(u.name)) return &u;
  return nullptr;
}

}  // namespace

std::vector<std::string> words_of(std::string_view flag, std::string_view text) {
  if (text.find('\n') != std::string_view::npos)
    throw UserError(std::string(flag) + ": a value with a line break is not allowed; a row of the CSV is one line");
  std::vector<std::string> words;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t to = std::min(text.find(',', from), text.size());
    if (to == from) refuse(flag, text, "values with commas between them");
    words.emplace_back(text.substr(from, to - from));
    from = to + 1;
  }
  refuse_repeats(flag, text, words);
  return words;
}

std::vector<std::uint64_t> integers_of(std::string_view flag, std::string_view text, std::uint64_t low,
                                       std::uint64_t high) {
  const std::string allowed =
      "whole numbers from " + std::to_string(low) + " to " + std::to_string(high) + ", or ranges such as 1-20";
  std::vector<std::uint64_t> all;
  for (const std::string& word : words_of(flag, text)) {
    const std::size_t dash = word.find('-');
    const auto first = number_of<std::uint64_t>(std::string_view(word).substr(0, dash));
    const auto last =
        dash == std::string::npos ? first : number_of<std::uint64_t>(std::string_view(word).substr(dash + 1));
    if (!first || !last || *first < low || *last > high || *first > *last) refuse(flag, word, allowed);
    if (*last - *first >= kMostInRange) refuse(flag, word, "a million values at the most");
    for (std::uint64_t v = *first;; ++v) {
      all.push_back(v);
      if (v == *last) break;
    }
  }
  refuse_repeats(flag, text, all);
  return all;
}

std::vector<double> milliseconds_of(std::string_view flag, std::string_view text) {
  const std::string allowed = "times from 0 to 60 s with a unit (s, ms or us), such as 0,50,100ms";
  const std::vector<std::string> words = words_of(flag, text);
  std::vector<double> all(words.size());
  const Unit* unit = nullptr;
  for (std::size_t i = words.size(); i-- > 0;) {
    std::string_view word = words[i];
    if (const Unit* own = unit_of(word)) {
      unit = own;
      word.remove_suffix(own->name.size());
    }
    const auto v = number_of<double>(word);
    if (!v || (unit == nullptr && *v != 0)) refuse(flag, words[i], allowed);
    all[i] = unit == nullptr ? 0 : *v * unit->milliseconds;
    if (!(all[i] >= 0 && all[i] <= kMostMilliseconds)) refuse(flag, words[i], allowed);
  }
  refuse_repeats(flag, text, all);
  return all;
}

std::vector<double> percents_of(std::string_view flag, std::string_view text) {
  std::vector<double> all;
  for (const std::string& word : words_of(flag, text)) {
    std::string_view bare = word;
    if (bare.ends_with('%')) bare.remove_suffix(1);
    const auto v = number_of<double>(bare);
    if (!v || !(*v >= 0 && *v <= 100)) refuse(flag, word, "percentages from 0 to 100, such as 0,5,10%");
    all.push_back(*v);
  }
  refuse_repeats(flag, text, all);
  return all;
}

std::string plain(double v) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), v).ptr};
}

}  // namespace padr::lab::sweep
