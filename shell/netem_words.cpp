#include "shell/netem_words.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "common/model/user_error.h"
#include "shell/netem_text.h"

namespace padr::shell::words {

namespace {

using link::Chance;
using link::Distribution;
using link::Nanos;

struct Unit {
  std::string_view name;
  double factor;
};

// tc compares units without regard to case.
constexpr auto kTimeUnits = std::to_array<Unit>({{"s", 1e9},
                                                 {"sec", 1e9},
                                                 {"secs", 1e9},
                                                 {"ms", 1e6},
                                                 {"msec", 1e6},
                                                 {"msecs", 1e6},
                                                 {"us", 1e3},
                                                 {"usec", 1e3},
                                                 {"usecs", 1e3},
                                                 {"ns", 1},
                                                 {"nsec", 1},
                                                 {"nsecs", 1}});
constexpr auto kRateUnits = std::to_array<Unit>({{"", 1},
                                                 {"bit", 1},
                                                 {"kbit", 1e3},
                                                 {"mbit", 1e6},
                                                 {"gbit", 1e9},
                                                 {"tbit", 1e12},
                                                 {"kibit", 0x1p10},
                                                 {"mibit", 0x1p20},
                                                 {"gibit", 0x1p30},
                                                 {"tibit", 0x1p40},
                                                 {"bps", 8},
                                                 {"kbps", 8e3},
                                                 {"mbps", 8e6},
                                                 {"gbps", 8e9},
                                                 {"tbps", 8e12},
                                                 {"kibps", 8 * 0x1p10},
                                                 {"mibps", 8 * 0x1p20},
                                                 {"gibps", 8 * 0x1p30},
                                                 {"tibps", 8 * 0x1p40}});
constexpr auto kSizeUnits = std::to_array<Unit>({{"", 1},
                                                 {"b", 1},
                                                 {"k", 0x1p10},
                                                 {"kb", 0x1p10},
                                                 {"m", 0x1p20},
                                                 {"mb", 0x1p20},
                                                 {"g", 0x1p30},
                                                 {"gb", 0x1p30},
                                                 {"kbit", 128},
                                                 {"mbit", 131072},
                                                 {"gbit", 134217728}});

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool same_unit(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == y; });
}

template <std::size_t N>
std::optional<double> factor_of(const std::array<Unit, N>& units, std::string_view name) {
  for (const Unit& unit : units) {
    if (same_unit(name, unit.name)) return unit.factor;
  }
  return std::nullopt;
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The leading decimal number and what follows it; nothing if there is none. "inf" and "nan" are no numbers here.
std::optional<std::pair<double, std::string_view>> leading_number(std::string_view text) {
  if (text.empty() || !(is_digit(text[0]) || text[0] == '.')) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  return std::pair{value, text.substr(static_cast<std::size_t>(end - text.data()))};
}

std::string wanted(std::string_view what, std::string_view allowed) {
  return "not a valid " + std::string(what) + "; allowed: " + std::string(allowed);
}

bool is_blank(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

}  // namespace

std::vector<Word> split(std::string_view text) {
  std::vector<Word> words;
  std::size_t i = 0;
  while (i < text.size()) {
    if (is_blank(text[i])) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (end < text.size() && !is_blank(text[end])) ++end;
    words.push_back({text.substr(i, end - i), words.size() + 1, i + 1});
    i = end;
  }
  return words;
}

std::string quoted(std::string_view text) {
  constexpr std::size_t kShown = 40;
  constexpr std::string_view kHex = "0123456789abcdef";
  std::string shown = "\"";
  for (const char c : text.substr(0, kShown)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte < 0x7F) {
      shown += c;
    } else {
      shown += "\\x";
      shown += kHex[byte >> 4U];
      shown += kHex[byte & 15U];
    }
  }
  if (text.size() > kShown) shown += "...";
  return shown + '"';
}

std::string describe(const Word& word) {
  return "word " + std::to_string(word.number) + " " + quoted(word.text) + " (column " + std::to_string(word.column) +
         ")";
}

void fail(const Word& word, const std::string& message) {
  throw UserError(describe(word) + ": " + message);
}

bool looks_like_number(const Word& word) {
  return is_digit(word.text[0]) || word.text[0] == '.';
}

bool looks_like_signed_number(const Word& word) {
  return looks_like_number(word) || word.text[0] == '-';
}

Nanos duration(const Word& word, std::string_view what, bool* bare) {
  const std::string allowed = wanted(what, "0 to " + std::to_string(link::kMaxTime / link::kNanosPerSecond) +
                                               "s, with s, ms, us or ns, as in 20ms or 1.5s");
  const auto number = leading_number(word.text);
  if (!number) fail(word, allowed);
  const auto [value, unit] = *number;
  *bare = unit.empty();
  const auto factor = *bare ? std::optional<double>(1e3) : factor_of(kTimeUnits, unit);
  if (!factor || value * *factor > static_cast<double>(link::kMaxTime)) fail(word, allowed);
  return std::llround(value * *factor);
}

Chance percent(const Word& word, std::string_view what) {
  const auto number = leading_number(word.text);
  if (!number || !(number->second.empty() || number->second == "%") || number->first > 100.0) {
    fail(word, wanted(what, "0% to 100%, the % may be left out"));
  }
  return static_cast<Chance>(std::llround(number->first / 100.0 * link::kAlways));
}

std::uint64_t rate(const Word& word, bool* bytes_per_second) {
  const auto number = leading_number(word.text);
  const auto factor = number ? factor_of(kRateUnits, number->second) : std::nullopt;
  const double bits = factor ? number->first * *factor : -1.0;
  if (bits < 0 || (bits > 0 && bits < 1) || bits > static_cast<double>(link::kMaxRate)) {
    fail(word, wanted("RATE",
                      "0 (unlimited) or 1bit to 10tbit a second, with bit, kbit, mbit, gbit (bits) or bps, kbps, mbps, "
                      "gbps (BYTES); a share of an interface's speed is unknown here"));
  }
  const char last = number->second.empty() ? ' ' : lower(number->second.back());
  *bytes_per_second = last == 's';
  return static_cast<std::uint64_t>(std::llround(bits));
}

std::int64_t integer(const Word& word, std::string_view what, std::int64_t lo, std::int64_t hi) {
  std::int64_t value = 0;
  const char* const end = word.text.data() + word.text.size();
  const auto [stop, error] = std::from_chars(word.text.data(), end, value);
  if (error != std::errc() || stop != end || value < lo || value > hi) {
    fail(word, wanted(what, "a whole number from " + std::to_string(lo) + " to " + std::to_string(hi)));
  }
  return value;
}

std::uint64_t seed(const Word& word) {
  std::uint64_t value = 0;
  const char* const end = word.text.data() + word.text.size();
  const auto [stop, error] = std::from_chars(word.text.data(), end, value);
  if (error != std::errc() || stop != end) fail(word, wanted("seed", "a whole number from 0 to 18446744073709551615"));
  return value;
}

std::uint32_t size(const Word& word, std::string_view what) {
  const auto number = leading_number(word.text);
  const auto factor = number ? factor_of(kSizeUnits, number->second) : std::nullopt;
  if (!factor || number->first * *factor > 4294967295.0) {
    fail(word, wanted(what, "0 to 4294967295, with k (1024), m or g if wanted"));
  }
  return static_cast<std::uint32_t>(number->first * *factor);
}

Distribution distribution(const Word& word) {
  for (const Distribution d :
       {Distribution::kUniform, Distribution::kNormal, Distribution::kPareto, Distribution::kParetoNormal}) {
    if (word.text == to_string(d)) return d;
  }
  fail(word, wanted("distribution",
                    "uniform (any value in DELAY - JITTER to DELAY + JITTER alike), normal, pareto, "
                    "paretonormal"));
}

}  // namespace padr::shell::words
