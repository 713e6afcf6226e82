#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace padr::monitor {

/// A browser's WebSocket, counted from 1 and never used again.
using ViewerId = std::uint64_t;

/// Bytes that go to several viewers and are kept once.
using Shared = std::shared_ptr<const std::string>;

/// Answer to a GET.
struct Reply {
  unsigned status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
  std::string etag;  ///< with its quotes; empty: none
};

/// What a web server serves.
class Site {
 public:
  virtual ~Site() = default;

  virtual Reply get(std::string_view path, std::string_view query) = 0;

  /// `local`: it comes from this machine. `query`: of the address that it opened, without its question mark.
  virtual void came(ViewerId viewer, bool local, std::string_view query) = 0;
  /// A text message.
  virtual void said(ViewerId viewer, std::string_view text) = 0;
  virtual void left(ViewerId viewer) = 0;
};

}  // namespace padr::monitor
