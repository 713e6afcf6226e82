#include "common/scenarios/document.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <algorithm>

#include "common/model/user_error.h"
#include "common/scenarios/rules.h"

namespace padr::scenarios {
namespace {

namespace pb = google::protobuf;

// A scenario with 5,000 bodies written out takes well under 1 MB.
constexpr std::size_t kMaxTextBytes = 8U << 20U;

// " (in: ...)", or nothing if the line is no plain text: the file is none, perhaps, and would upset a terminal.
std::string in_line(std::string_view text, int line) {
  for (; line > 0; --line) {
    const auto end = text.find('\n');
    if (end == std::string_view::npos) return {};
    text.remove_prefix(end + 1);
  }
  text = text.substr(0, text.find_first_of("\r\n"));
  text.remove_prefix(std::min(text.size(), text.find_first_not_of(" \t")));
  const auto is_plain = [](char c) { return (c >= ' ' && c <= '~') || c == '\t'; };
  if (!std::all_of(text.begin(), text.end(), is_plain)) return {};
  return " (in: " + std::string(text.substr(0, 100)) + ")";
}

/// Keeps the first error: those after it are mostly its consequences.
class FirstError : public pb::io::ErrorCollector {
 public:
  void AddError(int line, pb::io::ColumnNumber column, const std::string& message) override {
    if (seen) return;
    seen = true;
    where = {"", std::max(line, 0) + 1, std::max(column, 0) + 1};
    what = message;
  }

  bool seen = false;
  Origin where;
  std::string what;
};

/// The parser blames a bad truth value on whatever follows it, perhaps lines later: go back to the field's name, which
/// is the first thing that the message quotes.
Origin blamed(const FirstError& error, std::string_view text) {
  if (!error.what.starts_with("Invalid value for boolean field")) return error.where;
  const auto quote = error.what.find('"') + 1;
  const std::string name = error.what.substr(quote, error.what.find('"', quote) - quote);
  std::size_t end = 0;
  for (int line = 1; line < error.where.line; ++line) end = text.find('\n', end) + 1;
  end = std::min(text.size(), end + static_cast<std::size_t>(error.where.column) - 1);
  const auto at = text.substr(0, end).rfind(name);
  if (at == std::string_view::npos) return error.where;
  const auto begin = text.substr(0, at).rfind('\n') + 1;  // npos + 1 is the first line's 0
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  return {"", static_cast<int>(line), static_cast<int>(at - begin) + 1};
}

}  // namespace

Document::Document(std::string_view text, std::string_view label) : label_(label) {
  if (text.size() > kMaxTextBytes) {
    fail({},
         "the file has " + std::to_string(text.size()) + " bytes, allowed: at most " + std::to_string(kMaxTextBytes));
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // a byte order mark, as Windows' editors write it
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) fail({}, "the file is in UTF-16, allowed: UTF-8");
  pb::TextFormat::Parser parser;
  pb::TextFormat::ParseInfoTree tree;
  FirstError error;
  parser.WriteLocationsTo(&tree);
  parser.RecordErrorsTo(&error);
  if (!parser.ParseFromString(std::string(text), &scenario_) || error.seen) {
    // The parser's message seldom names the field, so the line that does goes with it.
    const Origin where = blamed(error, text);
    const bool negative = error.what == "Expected integer, got: -";
    fail(where, error.what + (negative ? ", allowed: 0 or more" : "") + in_line(text, where.line - 1));
  }
  origins_[""] = {};
  check_rules(
      scenario_, tree, [this](const Origin& where) { origins_[where.field] = where; },
      [this](const Origin& where, const std::string& message) { fail(where, message); });
}

Origin Document::origin(std::string_view path) const {
  Origin result;
  for (std::string_view known = path;;) {
    if (const auto found = origins_.find(known); found != origins_.end()) {
      result = found->second;
      break;
    }
    const auto dot = known.rfind('.');
    known = dot == std::string_view::npos ? std::string_view{} : known.substr(0, dot);
  }
  result.field = std::string(path);
  return result;
}

void Document::fail(const Origin& where, const std::string& message) const {
  std::string text = label_ + ":" + std::to_string(where.line) + ":" + std::to_string(where.column) + ": ";
  if (!where.field.empty()) text += where.field + " ";
  text += message;
  // One line, whatever was quoted from the file.
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  throw UserError(text);
}

}  // namespace padr::scenarios
