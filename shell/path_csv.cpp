#include "shell/path_csv.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

#include "common/model/user_error.h"
#include "common/scenarios/numbers.h"
#include "shell/text.h"

namespace padr::shell {
namespace {

constexpr std::size_t kMaxRows = 1'000'000;  // more than four hours at 60 Hz
constexpr double kMaxSeconds = 1e10;         // wide enough for Unix time
constexpr float kMaxMetres = 10'000;         // beyond any play area, and still exact to a millimetre as float
constexpr std::string_view kBlanks = " \t";
constexpr std::size_t kColumns = 3;
constexpr std::array<std::string_view, kColumns> kNames{"t", "x", "y"};

struct Field {
  std::string_view text;  ///< without the blanks round it
  std::size_t column = 1;
};

Field trimmed(std::string_view text, std::size_t column) {
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {{}, column};
  text = text.substr(0, text.find_last_not_of(kBlanks) + 1);
  return {text.substr(first), column + first};
}

/// What is quoted from a file, on one line and not too long.
std::string quoted(std::string_view text) {
  std::string result(1, '"');
  for (const char c : text.substr(0, 40)) result += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  result += text.size() > 40 ? "...\"" : "\"";
  return result;
}

/// The number that is all of `text`; infinite if too large to be one.
template <typename Number>
std::optional<Number> number(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::invalid_argument || end != text.data() + text.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    // Too small for a float is not wrong: it is as good as 0.
    const bool tiny = std::is_same_v<Number, float> && std::abs(number<double>(text).value()) < 1;
    return tiny ? Number{0} : std::numeric_limits<Number>::infinity();
  }
  return value;
}

class Reader {
 public:
  Reader(std::string_view label, const PathUnits& units) : label_(label), units_(units) {}

  std::vector<scenarios::PathPoint> read(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    while (!text.empty()) {
      const auto end = text.find('\n');
      std::string_view line = text.substr(0, end);
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
      ++line_;
      if (line.ends_with('\r')) line.remove_suffix(1);
      const Field content = trimmed(line, 1);
      if (!content.text.empty() && !content.text.starts_with('#')) row(line);
    }
    if (points_.size() < 2) {
      ++line_;
      fail(1, "the file ends after " + counted(points_.size(), "row") + ", allowed: at least 2 rows t,x,y");
    }
    return std::move(points_);
  }

 private:
  void row(std::string_view line) {
    const std::array<Field, kColumns> fields = split(line);
    if (first_) {
      first_ = false;
      if (is_header(fields)) return;
    }
    if (points_.size() == kMaxRows) {
      fail(1, "one row too many, allowed: at most " + std::to_string(kMaxRows) + " rows");
    }
    scenarios::PathPoint point;
    const auto time = value<double>(fields[0], 0, kMaxSeconds * units_.per_second, units_.time);
    point.seconds = time / units_.per_second;
    point.position.x = value<float>(fields[1], 1, kMaxMetres, units_.length);
    point.position.y = value<float>(fields[2], 2, kMaxMetres, units_.length);
    if (units_.merge && !points_.empty() && point.seconds == points_.back().seconds) points_.pop_back();
    if (!points_.empty() && point.seconds <= points_.back().seconds) {
      const std::string unit = " " + std::string(units_.time);
      fail(fields[0].column, "t is " + scenarios::number_text(time) + unit + ", allowed: more than " +
                                 scenarios::number_text(last_) + unit + ", the t of the row before");
    }
    last_ = time;
    points_.push_back(point);
  }

  std::array<Field, kColumns> split(std::string_view line) const {
    std::array<Field, kColumns> fields;
    std::size_t count = 0;
    std::size_t begin = 0;
    for (;;) {
      const auto comma = line.find(',', begin);
      const auto end = comma == std::string_view::npos ? line.size() : comma;
      if (count == kColumns)
        fail(begin + 1, "a fourth column, allowed: the three columns t,x,y, and a row on each line");
      fields[count++] = trimmed(line.substr(begin, end - begin), begin + 1);
      if (comma == std::string_view::npos) break;
      begin = comma + 1;
    }
    if (count < kColumns) {
      const auto other = line.find_first_of(";\t\r");
      if (count == 1 && other != std::string_view::npos)
        fail(other + 1, std::string("a ") +
                            (line[other] == ';'    ? "semicolon"
                             : line[other] == '\t' ? "tab"
                                                   : "carriage return without a newline") +
                            ", allowed: commas between the three columns t,x,y, and a row on each line");
      fail(line.size() + 1, std::string(kNames[count]) + " is missing, allowed: the three columns t,x,y");
    }
    return fields;
  }

  bool is_header(const std::array<Field, kColumns>& fields) const {
    if (number<double>(fields[0].text)) return false;
    for (std::size_t i = 0; i < kColumns; ++i) {
      if (fields[i].text == kNames[i]) continue;
      fail(fields[i].column,
           quoted(fields[i].text) + " in the first line, allowed: the header t,x,y or a row of numbers");
    }
    return true;
  }

  template <typename Number>
  Number value(const Field& field, std::size_t index, Number limit, std::string_view unit) const {
    const std::optional<Number> v = number<Number>(field.text);
    if (!v || !std::isfinite(*v) || *v < -limit || *v > limit) {
      fail(field.column, std::string(kNames[index]) + " is " + quoted(field.text) + (v ? "" : ", not a number") +
                             ", allowed: " + scenarios::number_text(-limit) + " .. " + scenarios::number_text(limit) +
                             " " + std::string(unit));
    }
    return *v;
  }

  [[noreturn]] void fail(std::size_t column, const std::string& message) const {
    throw UserError(label_ + ":" + std::to_string(line_) + ":" + std::to_string(column) + ": " + message);
  }

  std::string label_;
  PathUnits units_;
  double last_ = 0;  ///< t of the row before, as written
  std::size_t line_ = 0;
  bool first_ = true;
  std::vector<scenarios::PathPoint> points_;
};

}  // namespace

scenarios::Path parse_path_csv(std::string_view text, std::string_view label, const PathUnits& units) {
  return scenarios::Path(Reader(label, units).read(text));
}

std::string write_path_csv(const scenarios::Path& path) {
  std::string text = "t,x,y\n";
  for (const scenarios::PathPoint& p : path.points()) {
    text += scenarios::number_text(p.seconds) + ",";
    text += scenarios::number_text(p.position.x) + ",";
    text += scenarios::number_text(p.position.y) + "\n";
  }
  return text;
}

}  // namespace padr::shell
