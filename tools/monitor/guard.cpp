#include "tools/monitor/guard.h"

#include <algorithm>
#include <boost/algorithm/string/predicate.hpp>
#include <boost/asio/ip/address.hpp>

namespace padr::monitor {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// A letter or a digit of ASCII, or one of these marks.
bool is_plain(char c, std::string_view marks) {
  return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || marks.find(c) != std::string_view::npos;
}

bool is_port(std::string_view text) {
  return !text.empty() && text.size() <= 5 && std::all_of(text.begin(), text.end(), is_digit);
}

bool is_address(std::string_view host) {
  boost::system::error_code error;
  if (host.starts_with('[') && host.ends_with(']'))
    boost::asio::ip::make_address_v6(host.substr(1, host.size() - 2), error);
  else
    boost::asio::ip::make_address_v4(host, error);
  return !error;
}

}  // namespace

bool host_allowed(std::string_view host, std::span<const std::string> names) {
  std::string_view name = host;
  if (const auto colon = host.rfind(':'); colon != std::string_view::npos && host.back() != ']') {
    if (!is_port(host.substr(colon + 1))) return false;
    name = host.substr(0, colon);
  }
  if (is_address(name) || boost::algorithm::iequals(name, "localhost")) return true;
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& n) { return boost::algorithm::iequals(name, n); });
}

bool is_host_name(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return is_plain(c, "-._"); });
}

bool same_origin(std::string_view origin, std::string_view host) {
  for (const std::string_view scheme : {"http://", "https://"})
    if (origin.starts_with(scheme)) return boost::algorithm::iequals(origin.substr(scheme.size()), host);
  return false;
}

std::optional<Target> split_target(std::string_view target) {
  // Links get fields added on their way, such as ?utm_source=a+b; a path is a name here or nowhere.
  const auto printed = [](char c) { return c > ' ' && c < 0x7F; };
  const auto plain = [](char c) { return is_plain(c, "/._-"); };
  const std::string_view path = target.substr(0, target.find('?'));
  const std::string_view query = path.size() == target.size() ? "" : target.substr(path.size() + 1);
  if (!path.starts_with('/') || !std::all_of(path.begin(), path.end(), plain) ||
      !std::all_of(query.begin(), query.end(), printed))
    return std::nullopt;
  return Target{path, query};
}

std::optional<std::string_view> query_field(std::string_view query, std::string_view name) {
  while (!query.empty()) {
    const std::string_view field = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), field.size() + 1));
    if (field.starts_with(name) && field.size() > name.size() && field[name.size()] == '=')
      return field.substr(name.size() + 1);
  }
  return std::nullopt;
}

bool same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned differs = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    differs |= unsigned{static_cast<unsigned char>(a[i])} ^ unsigned { static_cast<unsigned char>(b[i]) };
  return differs == 0;
}

}  // namespace padr::monitor
