#include "shell/json.h"

#include <array>
#include <cassert>
#include <charconv>
#include <cmath>

namespace padr::shell {
namespace {

void append_quoted(std::string& out, std::string_view text) {
  constexpr std::string_view kHex = "0123456789abcdef";
  out += '"';
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20) {
      out += "\\u00";
      out += kHex[byte >> 4U];
      out += kHex[byte & 0xFU];
    } else {
      out += c;
    }
  }
  out += '"';
}

}  // namespace

void Json::line() {
  if (layout_ == Layout::kOneLine) return;
  out_ += '\n';
  out_.append(2 * open_.size(), ' ');
}

void Json::before_token() {
  if (after_key_) {
    after_key_ = false;
    return;
  }
  if (open_.empty()) {
    assert(out_.empty());
    return;
  }
  assert(open_.back() == ']');
  if (!first_) out_ += ',';
  first_ = false;
  line();
}

Json& Json::key(std::string_view name) {
  assert(!open_.empty() && open_.back() == '}' && !after_key_);
  if (!first_) out_ += ',';
  first_ = false;
  line();
  append_quoted(out_, name);
  out_ += layout_ == Layout::kOneLine ? ":" : ": ";
  after_key_ = true;
  return *this;
}

Json& Json::open(char bracket) {
  before_token();
  out_ += bracket;
  open_.push_back(bracket == '{' ? '}' : ']');
  first_ = true;
  return *this;
}

Json& Json::close(char bracket) {
  assert(!open_.empty() && open_.back() == bracket && !after_key_);
  open_.pop_back();
  if (!first_) line();
  out_ += bracket;
  first_ = false;
  return *this;
}

Json& Json::raw(std::string_view token) {
  before_token();
  out_ += token;
  return *this;
}

Json& Json::value(std::string_view text) {
  before_token();
  append_quoted(out_, text);
  return *this;
}

Json& Json::value(double number) {
  if (!std::isfinite(number)) return null();
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  return raw({text.data(), static_cast<std::size_t>(end - text.data())});
}

std::string Json::text() const {
  assert(open_.empty());
  return layout_ == Layout::kOneLine ? out_ : out_ + "\n";
}

}  // namespace padr::shell
