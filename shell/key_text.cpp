#include "shell/key_text.h"

#include <algorithm>
#include <boost/algorithm/hex.hpp>
#include <iterator>

namespace padr::shell {
namespace {

constexpr std::string_view kSpace = " \t\r\n";
constexpr std::string_view kLine = "padr-key";

/// The next word of `text`, which loses it.
std::string_view word(std::string_view& text) {
  text.remove_prefix(std::min(text.size(), text.find_first_not_of(kSpace)));
  const std::string_view found = text.substr(0, text.find_first_of(kSpace));
  text.remove_prefix(found.size());
  return found;
}

}  // namespace

std::string key_text(const KeyBytes& key) {
  std::string text;
  boost::algorithm::hex_lower(key, std::back_inserter(text));
  return text;
}

bool parse_key(std::string_view text, KeyBytes& key) {
  const std::string_view digits = word(text);
  if (digits.size() != 2 * key.size() || !word(text).empty()) return false;
  try {
    boost::algorithm::unhex(digits, key.begin());
  } catch (const boost::algorithm::hex_decode_error&) {
    return false;
  }
  return true;
}

std::optional<KeyBytes> parse_key(std::string_view text) {
  KeyBytes key{};
  if (!parse_key(text, key)) return std::nullopt;
  return key;
}

std::string keylog_line(const KeylogEntry& e) {
  return std::string(kLine) + ' ' + key_text(e.from) + ' ' + key_text(e.to) + ' ' + key_text(e.key) + '\n';
}

std::optional<KeylogEntry> parse_keylog_line(std::string_view line) {
  if (word(line) != kLine) return std::nullopt;
  const auto from = parse_key(word(line));
  const auto to = parse_key(word(line));
  const auto key = parse_key(word(line));
  if (!from || !to || !key || !word(line).empty()) return std::nullopt;
  return KeylogEntry{*from, *to, *key};
}

}  // namespace padr::shell
