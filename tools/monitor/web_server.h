#pragma once

#include <utility>  // Boost.Asio 1.74 uses std::exchange without including this

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tools/monitor/site.h"

namespace padr::monitor {

class ViewerLink;

/// What strangers may cost.
struct WebLimits {
  std::size_t connections = 256;  ///< at a time, viewers included
  std::size_t viewers = 64;
  std::uint32_t header_bytes = 8 * 1024;
  std::size_t message_bytes = 8 * 1024;  ///< of a viewer's message, all its fragments together
  std::size_t queue_bytes = 32U << 20U;  ///< that wait for one viewer; beyond, it is dismissed
  double messages_per_s = 200;           ///< of one viewer, over a second or so
  std::chrono::seconds request{10};      ///< until a request is there, however slowly it comes
  std::chrono::seconds reply{30};        ///< until it is taken
  std::chrono::seconds idle{30};         ///< until a viewer that does not answer pings is given up
  std::chrono::seconds write{20};        ///< for one message to a viewer
};

/// Counted since the start, but for those in the first line.
struct WebStats {
  std::size_t connections = 0, viewers = 0;  ///< now
  std::uint64_t requests = 0;
  std::uint64_t refused = 0;      ///< requests that were answered with an error
  std::uint64_t malformed = 0;    ///< no HTTP, or too much of it
  std::uint64_t timeouts = 0;     ///< connections that were too slow
  std::uint64_t turned_away = 0;  ///< connections beyond the limit
  std::uint64_t viewers_ever = 0;
  std::uint64_t dismissed = 0;                      ///< viewers that were too slow or sent what they may not
  std::uint64_t sent_messages = 0, sent_bytes = 0;  ///< to viewers
  std::uint64_t skipped = 0;                        ///< messages that a viewer was too slow for
};

/// HTTP and WebSocket on one port. One thread; a viewer that is slow misses what may be missed, and costs no more than
/// the limits say. To be made by make_shared: its connections keep it until they are gone.
class WebServer : public std::enable_shared_from_this<WebServer> {
 public:
  using Tcp = boost::asio::ip::tcp;

  /// `names`: see host_allowed. Throws std::system_error if the address cannot be used.
  WebServer(boost::asio::io_context& io, const Tcp::endpoint& address, std::vector<std::string> names, WebLimits limits,
            Site& site);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  void start();
  /// Takes nobody any more, says goodbye to viewers, and does not call the site again.
  void stop();
  Tcp::endpoint local() const { return acceptor_.local_endpoint(); }

  /// JSON. `may_miss`: not sent while others wait. Nothing happens if the viewer has left.
  void tell(ViewerId viewer, const Shared& text, bool may_miss = false);
  /// Binary: of those that wait, the last is sent.
  void show(ViewerId viewer, const Shared& views);
  void dismiss(ViewerId viewer, const std::string& why);

  const WebStats& stats() const { return stats_; }

  // For its connections.
  const WebLimits& limits() const { return limits_; }
  const std::vector<std::string>& names() const { return names_; }
  /// Null after stop().
  Site* site() { return site_; }
  WebStats& counters() { return stats_; }
  void came(ViewerId id, const std::shared_ptr<ViewerLink>& link, bool local, std::string_view query);
  void left(ViewerId id);
  ViewerId next_viewer() { return ++stats_.viewers_ever; }

 private:
  void accept();
  ViewerLink* find(ViewerId viewer);

  std::vector<std::string> names_;
  WebLimits limits_;
  Site* site_;
  WebStats stats_;
  Tcp::acceptor acceptor_;
  boost::asio::steady_timer pause_;  ///< when the system has no descriptors left
  std::map<ViewerId, std::weak_ptr<ViewerLink>> viewers_;
};

}  // namespace padr::monitor
