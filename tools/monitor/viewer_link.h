#pragma once

#include <utility>  // Boost.Asio 1.74 uses std::exchange without including this

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <chrono>
#include <cstddef>
#include <deque>
#include <memory>
#include <string>

#include "tools/monitor/web_connection.h"

namespace padr::monitor {

/// One viewer's WebSocket. What waits for it is bounded: of views the newest, of other messages so many bytes.
class ViewerLink : public std::enable_shared_from_this<ViewerLink> {
 public:
  ViewerLink(boost::beast::tcp_stream stream, std::shared_ptr<WebServer> server);
  ~ViewerLink();
  ViewerLink(const ViewerLink&) = delete;
  ViewerLink& operator=(const ViewerLink&) = delete;

  /// Accepts the request to become a WebSocket.
  void start(HttpRequest request);

  void tell(const Shared& text, bool may_miss);
  void show(const Shared& views);
  /// For what it did.
  void dismiss(const std::string& why);
  void say_goodbye();

 private:
  using Steady = std::chrono::steady_clock;
  void read();
  void on_message();
  bool too_many();
  void write_next();
  void close(boost::beast::websocket::close_code code, const std::string& why);
  void send_close();
  void end();

  std::shared_ptr<WebServer> server_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  boost::beast::flat_buffer buffer_;
  HttpRequest request_;
  ViewerId id_ = 0;
  bool local_ = false;
  bool open_ = false;
  bool closing_ = false;
  boost::beast::websocket::close_reason farewell_;
  boost::asio::steady_timer patience_;  ///< with one who is being said goodbye to
  std::deque<Shared> texts_;
  std::size_t queued_ = 0;  ///< bytes in texts_
  Shared views_;
  Shared sending_;
  Steady::time_point sending_since_;
  double allowance_;  ///< messages that it may still send at once
  Steady::time_point counted_at_ = Steady::now();
};

}  // namespace padr::monitor
