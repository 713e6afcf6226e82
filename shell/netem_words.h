#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/link/netem_spec.h"

/// The words of a netem specification and the values they spell. Used by netem_text.cpp and link_trace.cpp only.
namespace padr::shell::words {

struct Word {
  std::string_view text;
  std::size_t number = 0;  ///< 1, 2, ... as people count
  std::size_t column = 0;  ///< 1-based, in bytes
};

/// Splits at blanks.
std::vector<Word> split(std::string_view text);

/// In quotes; unprintable bytes are shown as \xNN and long texts cut, so it stays one line.
std::string quoted(std::string_view text);
/// `word 3 "20mss" (column 14)`.
std::string describe(const Word& word);

/// Throws UserError: `word 3 "20mss" (column 14): MESSAGE`.
[[noreturn]] void fail(const Word& word, const std::string& message);

/// Whether an optional value follows: tc looks at the first character only, so a misspelt number is an error, not a
/// keyword.
bool looks_like_number(const Word& word);
bool looks_like_signed_number(const Word& word);

/// Each throws UserError through fail() when `word` is no such value or out of range. `what` names the value.
link::Nanos duration(const Word& word, std::string_view what, bool* bare);
link::Chance percent(const Word& word, std::string_view what);
std::uint64_t rate(const Word& word, bool* bytes_per_second);
/// Whole number in [lo, hi].
std::int64_t integer(const Word& word, std::string_view what, std::int64_t lo, std::int64_t hi);
std::uint64_t seed(const Word& word);
/// A number with tc's size suffixes (k, kb = 1024, m, mb, g, gb, kbit, mbit, gbit), in [0, 2^32).
std::uint32_t size(const Word& word, std::string_view what);
link::Distribution distribution(const Word& word);

}  // namespace padr::shell::words
