#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace padr::shell {

/// Writes one JSON document (RFC 8259), indented or in one line, as text. Calls must nest properly: that is asserted.
///
///   Json j;
///   j.begin_object().key("name").value("arena").key("ticks").value(600).end_object();
///   j.text();
class Json {
 public:
  enum class Layout : std::uint8_t { kIndented, kOneLine };
  explicit Json(Layout layout = Layout::kIndented) : layout_(layout) {}

  Json& begin_object() { return open('{'); }
  Json& end_object() { return close('}'); }
  Json& begin_array() { return open('['); }
  Json& end_array() { return close(']'); }
  Json& key(std::string_view name);

  Json& value(std::string_view text);
  Json& value(const char* text) { return value(std::string_view(text)); }
  /// The shortest text that reads back as the same number; null if it is not finite, as JSON has no such numbers.
  Json& value(double number);
  Json& value(bool truth) { return raw(truth ? "true" : "false"); }
  template <std::integral T>
  requires(!std::same_as<T, bool>) Json& value(T number) { return raw(std::to_string(number)); }
  Json& null() { return raw("null"); }
  /// key() and value() in one.
  template <typename T>
  Json& field(std::string_view name, const T& v) {
    return key(name).value(v);
  }

  /// A finished document of this class, in one line, as a value.
  Json& document(std::string_view text) { return raw(text); }

  /// The finished document; indented ones have a newline at their end.
  std::string text() const;

 private:
  Json& open(char bracket);
  Json& close(char bracket);
  Json& raw(std::string_view token);
  void before_token();
  void line();

  Layout layout_;
  std::string out_;
  std::vector<char> open_;  ///< closing brackets still due
  bool first_ = true;       ///< nothing yet in the innermost bracket
  bool after_key_ = false;
};

}  // namespace padr::shell
