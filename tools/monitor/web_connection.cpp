#include "tools/monitor/web_connection.h"

#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include "tools/monitor/guard.h"
#include "tools/monitor/viewer_link.h"

namespace padr::monitor {
namespace {

namespace beast = boost::beast;
namespace http = boost::beast::http;
using boost::system::error_code;

std::string_view view(beast::string_view s) {
  return {s.data(), s.size()};
}

bool only_reads(http::verb method) {
  return method == http::verb::get || method == http::verb::head;
}

/// The page may load only files of this server, and no other site may embed it.
std::string content_policy(std::string_view host) {
  return "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; "
         "manifest-src 'self'; connect-src 'self' ws://" +
         std::string(host) + " wss://" + std::string(host) +
         "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
}

}  // namespace

WebConnection::WebConnection(WebServer::Tcp::socket socket, std::shared_ptr<WebServer> server)
    : server_(std::move(server)), stream_(std::move(socket)), buffer_(2 * std::size_t{server_->limits().header_bytes}) {
  ++server_->counters().connections;
  error_code ignored;
  stream_.socket().set_option(boost::asio::ip::tcp::no_delay(true), ignored);
}

WebConnection::~WebConnection() {
  if (counted_) --server_->counters().connections;
}

void WebConnection::start() {
  read();
}

void WebConnection::read() {
  parser_.emplace();
  parser_->header_limit(server_->limits().header_bytes);
  parser_->body_limit(0);
  // Of the whole request, however its bytes come.
  stream_.expires_after(server_->limits().request);
  http::async_read(stream_, buffer_, *parser_,
                   [self = shared_from_this()](const error_code& error, std::size_t) { self->on_read(error); });
}

void WebConnection::on_read(const error_code& error) {
  if (server_->site() == nullptr) return;
  if (!error) {
    ++server_->counters().requests;
    return answer(parser_->get());
  }
  if (error == beast::error::timeout) {
    // One that only waited for another request has done nothing wrong.
    if (parser_->got_some()) ++server_->counters().timeouts;
    return;
  }
  // An HTTP error, unlike one of the connection, deserves an answer.
  if (error == http::error::end_of_stream ||
      error.category() != http::make_error_code(http::error::bad_line_ending).category())
    return;
  ++server_->counters().malformed;
  HttpRequest request;
  request.version(11);
  request.keep_alive(false);
  const bool long_header = error == http::error::header_limit || error == http::error::buffer_overflow;
  const bool has_body = error == http::error::body_limit;
  if (has_body && !only_reads(parser_->get().method()))
    return refuse(request, http::status::method_not_allowed, "only GET and HEAD");
  refuse(request,
         long_header ? http::status::request_header_fields_too_large
                     : (has_body ? http::status::payload_too_large : http::status::bad_request),
         "this request is not supported: " + error.message());
}

void WebConnection::answer(const HttpRequest& request) {
  const std::string_view host = view(request[http::field::host]);
  if (request.count(http::field::host) != 1 || !host_allowed(host, server_->names()))
    return refuse(request, http::status::misdirected_request,
                  "this host name is not served; use an IP address, localhost, or a name given with --allow-host");
  if (!only_reads(request.method())) return refuse(request, http::status::method_not_allowed, "only GET and HEAD");
  const auto target = split_target(view(request.target()));
  if (!target) return refuse(request, http::status::bad_request, "no such target");
  if (target->path == "/ws") return upgrade(request);
  send(request, server_->site()->get(target->path, target->query));
}

void WebConnection::refuse(const HttpRequest& request, http::status status, const std::string& why) {
  Reply reply;
  reply.status = static_cast<unsigned>(status);
  reply.body = why + "\n";
  send(request, std::move(reply));
}

void WebConnection::upgrade(HttpRequest request) {
  if (!beast::websocket::is_upgrade(request))
    return refuse(request, http::status::upgrade_required, "this is for WebSockets");
  // Browsers say where a page comes from; a page of somebody else's must not get in. Programs say nothing.
  if (request.count(http::field::origin) > 0 &&
      (request.count(http::field::origin) > 1 ||
       !same_origin(view(request[http::field::origin]), view(request[http::field::host]))))
    return refuse(request, http::status::forbidden, "only pages that come from here may connect");
  if (server_->counters().viewers >= server_->limits().viewers)
    return refuse(request, http::status::service_unavailable, "too many pages are open");
  counted_ = false;  // the link counts instead
  const auto link = std::make_shared<ViewerLink>(std::move(stream_), server_);
  link->start(std::move(request));
}

void WebConnection::send(const HttpRequest& request, Reply reply) {
  if (reply.status >= 400) ++server_->counters().refused;
  reply_ = {};
  reply_.version(request.version());
  reply_.result(reply.status);
  reply_.keep_alive(request.keep_alive() && reply.status < 400);
  reply_.set(http::field::server, "padr-monitor");
  reply_.set(http::field::content_type, reply.type);
  reply_.set(http::field::cache_control, "no-cache");
  reply_.set("X-Content-Type-Options", "nosniff");
  reply_.set("Referrer-Policy", "no-referrer");
  reply_.set("Cross-Origin-Resource-Policy", "same-origin");
  if (reply.status < 400) reply_.set("Content-Security-Policy", content_policy(view(request[http::field::host])));
  if (reply.status == static_cast<unsigned>(http::status::method_not_allowed))
    reply_.set(http::field::allow, "GET, HEAD");
  if (reply.status == static_cast<unsigned>(http::status::upgrade_required))
    reply_.set(http::field::upgrade, "websocket");
  if (!reply.etag.empty()) {
    reply_.set(http::field::etag, reply.etag);
    if (view(request[http::field::if_none_match]) == reply.etag) {
      reply_.result(http::status::not_modified);
      reply.body.clear();
    }
  }
  const std::size_t size = reply.body.size();
  if (request.method() != http::verb::head) reply_.body() = std::move(reply.body);
  if (reply_.result() != http::status::not_modified) reply_.content_length(size);
  write();
}

void WebConnection::write() {
  stream_.expires_after(server_->limits().reply);
  http::async_write(stream_, reply_, [self = shared_from_this()](const error_code& error, std::size_t) {
    if (error == beast::error::timeout) ++self->server_->counters().timeouts;
    if (error) return;
    if (self->reply_.keep_alive()) return self->read();
    error_code ignored;
    self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
  });
}

}  // namespace padr::monitor
