#pragma once

#include <utility>  // Boost.Asio 1.74 uses std::exchange without including this

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <memory>
#include <optional>

#include "tools/monitor/web_server.h"

namespace padr::monitor {

using HttpRequest = boost::beast::http::request<boost::beast::http::empty_body>;
using HttpReply = boost::beast::http::response<boost::beast::http::string_body>;

/// One connection: requests one after the other, until one of them makes it a viewer's.
class WebConnection : public std::enable_shared_from_this<WebConnection> {
 public:
  WebConnection(WebServer::Tcp::socket socket, std::shared_ptr<WebServer> server);
  ~WebConnection();
  WebConnection(const WebConnection&) = delete;
  WebConnection& operator=(const WebConnection&) = delete;

  void start();

 private:
  void read();
  void on_read(const boost::system::error_code& error);
  void answer(const HttpRequest& request);
  void refuse(const HttpRequest& request, boost::beast::http::status status, const std::string& why);
  void upgrade(HttpRequest request);
  void send(const HttpRequest& request, Reply reply);
  void write();

  std::shared_ptr<WebServer> server_;
  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  HttpReply reply_;
  bool counted_ = true;  ///< among the server's connections
};

}  // namespace padr::monitor
