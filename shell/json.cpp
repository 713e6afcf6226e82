#include "shell/json.h"

#include <cassert>
#include <nlohmann/json.hpp>
#include <utility>

namespace padr::shell {

using nlohmann::ordered_json;

Json::Json(Layout layout) : layout_(layout), root_(std::make_unique<ordered_json>()) {}
Json::Json(Json&&) noexcept = default;
Json::~Json() = default;

Json& Json::add(ordered_json value) {
  if (open_.empty()) {
    *root_ = std::move(value);
  } else if (open_.back()->is_array()) {
    open_.back()->push_back(std::move(value));
  } else {
    open_.back()->emplace(std::exchange(key_, {}), std::move(value));
  }
  return *this;
}

Json& Json::open(ordered_json value) {
  ordered_json* const parent = open_.empty() ? nullptr : open_.back();
  add(std::move(value));
  open_.push_back(parent == nullptr ? root_.get() : &parent->back());
  return *this;
}

Json& Json::close() {
  assert(!open_.empty());
  open_.pop_back();
  return *this;
}

Json& Json::begin_object() {
  return open(ordered_json::object());
}

Json& Json::begin_array() {
  return open(ordered_json::array());
}

Json& Json::key(std::string_view name) {
  assert(!open_.empty() && open_.back()->is_object());
  key_ = name;
  return *this;
}

Json& Json::value(std::string_view text) {
  return add(text);
}

Json& Json::value(double number) {
  return add(number);
}

Json& Json::value(bool truth) {
  return add(truth);
}

Json& Json::value(std::int64_t number) {
  return add(number);
}

Json& Json::value(std::uint64_t number) {
  return add(number);
}

Json& Json::null() {
  return add(nullptr);
}

Json& Json::document(std::string_view text) {
  return add(ordered_json::parse(text));
}

std::string Json::text() const {
  assert(open_.empty());
  const bool one_line = layout_ == Layout::kOneLine;
  // What is no UTF-8 is replaced: file names and other peers' texts may be anything.
  std::string text = root_->dump(one_line ? -1 : 2, ' ', false, ordered_json::error_handler_t::replace);
  return one_line ? text : text + "\n";
}

}  // namespace padr::shell
