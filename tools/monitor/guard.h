#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace padr::monitor {

// Who may ask: decided from the headers of a request alone.

/// Whether a request for this Host header (RFC 9110, 7.2) is meant for us: an IP address, localhost, or one of `names`,
/// with any port or none. A page of somebody else's that points a name of its own at our address asks for that name.
bool host_allowed(std::string_view host, std::span<const std::string> names);

/// Whether it may be one of `names`: of letters and digits of ASCII, hyphens, full stops and underscores.
bool is_host_name(std::string_view text);

/// Whether a page of this Origin (RFC 6454) is one that we served under this Host: the same host and port.
bool same_origin(std::string_view origin, std::string_view host);

/// The target of a request, split.
struct Target {
  std::string_view path;
  std::string_view query;  ///< without its question mark
};
/// Nothing if its path is not absolute or not of plain characters, as nothing that we serve needs any escape, or if its
/// query has others than printed ones. Escapes in the query stay as they are.
std::optional<Target> split_target(std::string_view target);

/// The value of a field in a query; nothing if it is not there.
std::optional<std::string_view> query_field(std::string_view query, std::string_view name);

/// Takes as long for every wrong secret of the same length.
bool same_secret(std::string_view a, std::string_view b);

}  // namespace padr::monitor
