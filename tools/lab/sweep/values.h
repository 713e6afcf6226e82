#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

// Lists as the flags of a sweep take them: values with commas between them. Each function throws UserError that names
// the flag, the value and what is allowed, also for an empty list and for the same value twice.
namespace padr::lab::sweep {

/// Words as they stand, without line breaks.
std::vector<std::string> words_of(std::string_view flag, std::string_view text);
/// Whole numbers from `low` to `high`, and ranges of them such as 1-20.
std::vector<std::uint64_t> integers_of(std::string_view flag, std::string_view text, std::uint64_t low,
                                       std::uint64_t high);
/// Times in ms, 0 to 60 s; each a number with s, ms or us. One without a unit takes that of the next which has one:
/// "0,50,100ms".
std::vector<double> milliseconds_of(std::string_view flag, std::string_view text);
/// 0 to 100, each with or without %.
std::vector<double> percents_of(std::string_view flag, std::string_view text);

/// The shortest text that reads back as the same number.
std::string plain(double v);

}  // namespace padr::lab::sweep
