#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace padr::shell {

/// Builds one JSON document (RFC 8259) in the order in which it is said. Calls must nest properly: that is asserted.
///
///   Json j;
///   j.begin_object().key("name").value("arena").key("ticks").value(600).end_object();
///   j.text();
class Json {
 public:
  enum class Layout : std::uint8_t { kIndented, kOneLine };
  explicit Json(Layout layout = Layout::kIndented);
  Json(Json&&) noexcept;
  ~Json();

  Json& begin_object();
  Json& end_object() { return close(); }
  Json& begin_array();
  Json& end_array() { return close(); }
  Json& key(std::string_view name);

  Json& value(std::string_view text);
  Json& value(const char* text) { return value(std::string_view(text)); }
  /// Null if it is not finite, as JSON has no such numbers.
  Json& value(double number);
  Json& value(bool truth);
  Json& value(std::int64_t number);
  Json& value(std::uint64_t number);
  template <std::integral T>
  requires(!std::same_as<T, bool>) Json& value(T number) {
    if constexpr (std::signed_integral<T>)
      return value(static_cast<std::int64_t>(number));
    else
      return value(static_cast<std::uint64_t>(number));
  }
  /// Null if there is none.
  template <typename T>
  Json& value(const std::optional<T>& v) {
    return v ? value(*v) : null();
  }
  Json& null();
  /// key() and value() in one.
  template <typename T>
  Json& field(std::string_view name, const T& v) {
    return key(name).value(v);
  }

  /// A finished document as a value.
  Json& document(std::string_view text);

  /// The finished document; indented ones have a newline at their end.
  std::string text() const;

 private:
  Json& add(nlohmann::ordered_json value);
  Json& open(nlohmann::ordered_json value);
  Json& close();

  Layout layout_;
  std::unique_ptr<nlohmann::ordered_json> root_;
  std::vector<nlohmann::ordered_json*> open_;  ///< the innermost last
  std::string key_;                            ///< of the next value in an object
};

}  // namespace padr::shell
