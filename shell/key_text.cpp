#include "shell/key_text.h"

#include <algorithm>

namespace padr::shell {
namespace {

constexpr std::string_view kDigits = "0123456789abcdef";
constexpr std::string_view kSpace = " \t\r\n";
constexpr std::string_view kLine = "padr-key";

std::optional<unsigned> digit(char c) {
  if (c >= 'A' && c <= 'F') c = static_cast<char>(c - 'A' + 'a');
  const auto at = kDigits.find(c);
  if (at == std::string_view::npos) return std::nullopt;
  return static_cast<unsigned>(at);
}

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
  for (const unsigned b : key) {
    text += kDigits[b >> 4U];
    text += kDigits[b & 15U];
  }
  return text;
}

std::optional<KeyBytes> parse_key(std::string_view text) {
  const std::string_view digits = word(text);
  KeyBytes key{};
  if (digits.size() != 2 * key.size() || !word(text).empty()) return std::nullopt;
  for (std::size_t i = 0; i < key.size(); ++i) {
    const auto high = digit(digits[2 * i]);
    const auto low = digit(digits[2 * i + 1]);
    if (!high || !low) return std::nullopt;
    key[i] = static_cast<std::uint8_t>(*high << 4U | *low);
  }
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
