#include "tools/monitor/viewer_link.h"

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>

#include "tools/monitor/guard.h"

namespace padr::monitor {
namespace {

namespace websocket = boost::beast::websocket;
using boost::system::error_code;

/// When this many messages wait, messages that a page may miss are left out.
constexpr std::size_t kFew = 4;
constexpr std::chrono::seconds kPatience{2};

/// Whether a proxy says that it passes the request on for somebody: RFC 7239, RFC 9110 (7.6.3), and what is common.
bool is_forwarded(const HttpRequest& request) {
  constexpr std::array<std::string_view, 6> kBy{"Forwarded",         "Via",      "X-Forwarded-For", "X-Forwarded-Host",
                                                "X-Forwarded-Proto", "X-Real-IP"};
  return std::any_of(kBy.begin(), kBy.end(), [&](std::string_view name) {
    return request.find({name.data(), name.size()}) != request.end();
  });
}

}  // namespace

ViewerLink::ViewerLink(boost::beast::tcp_stream stream, std::shared_ptr<WebServer> server)
    : server_(std::move(server)),
      socket_(std::move(stream)),
      patience_(socket_.get_executor()),
      allowance_(server_->limits().messages_per_s) {
  ++server_->counters().viewers;
  socket_.next_layer().expires_never();  // the WebSocket keeps its own time
  websocket::stream_base::timeout timeout{};
  timeout.handshake_timeout = server_->limits().request;
  timeout.idle_timeout = server_->limits().idle;
  timeout.keep_alive_pings = true;
  socket_.set_option(timeout);
  socket_.read_message_max(server_->limits().message_bytes);
  socket_.auto_fragment(false);  // a message is one frame, written without copying it
  error_code error;
  const auto from = socket_.next_layer().socket().remote_endpoint(error);
  const auto address = from.address();
  local_ = !error && (address.is_loopback() ||
                      (address.is_v6() && address.to_v6().is_v4_mapped() &&
                       boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, address.to_v6()).is_loopback()));
}

ViewerLink::~ViewerLink() {
  end();
  --server_->counters().viewers;
  --server_->counters().connections;
}

void ViewerLink::start(HttpRequest request) {
  request_ = std::move(request);
  local_ = local_ && !is_forwarded(request_);
  socket_.async_accept(request_, [self = shared_from_this()](const error_code& error) {
    if (error) return;
    self->open_ = true;
    self->id_ = self->server_->next_viewer();
    const auto asked = self->request_.target();
    const auto target = split_target({asked.data(), asked.size()});
    self->server_->came(self->id_, self, self->local_, target ? target->query : std::string_view());
    self->read();
  });
}

void ViewerLink::read() {
  socket_.async_read(buffer_, [self = shared_from_this()](const error_code& error, std::size_t) {
    if (error) {
      if (error == websocket::error::message_too_big) ++self->server_->counters().dismissed;
      self->end();
      return;
    }
    self->on_message();
    self->buffer_.consume(self->buffer_.size());
    self->read();
  });
}

void ViewerLink::on_message() {
  if (closing_ || !open_) return;
  if (!socket_.got_text()) return dismiss("binary messages are not taken");
  if (too_many()) return dismiss("too many messages");
  const auto bytes = buffer_.cdata();
  server_->site()->said(id_, {static_cast<const char*>(bytes.data()), bytes.size()});
}

bool ViewerLink::too_many() {
  const auto now = Steady::now();
  const double most = server_->limits().messages_per_s;
  allowance_ = std::min(most, allowance_ + most * std::chrono::duration<double>(now - counted_at_).count()) - 1;
  counted_at_ = now;
  return allowance_ < 0;
}

void ViewerLink::tell(const Shared& text, bool may_miss) {
  if (!open_ || closing_) return;
  if (may_miss && texts_.size() >= kFew) {
    ++server_->counters().skipped;
    return;
  }
  if (queued_ + text->size() > server_->limits().queue_bytes) return dismiss("too slow");
  queued_ += text->size();
  texts_.push_back(text);
  write_next();
}

void ViewerLink::show(const Shared& views) {
  if (!open_ || closing_) return;
  if (views_) ++server_->counters().skipped;
  views_ = views;
  write_next();
}

void ViewerLink::write_next() {
  if (sending_) {
    if (Steady::now() - sending_since_ > server_->limits().write) dismiss("too slow");
    return;
  }
  if (closing_ || (texts_.empty() && !views_)) return;
  const bool text = !texts_.empty();
  if (text) {
    sending_ = std::move(texts_.front());
    texts_.pop_front();
    queued_ -= sending_->size();
  } else {
    sending_ = std::move(views_);
  }
  sending_since_ = Steady::now();
  socket_.text(text);
  socket_.async_write(boost::asio::buffer(*sending_),
                      [self = shared_from_this()](const error_code& error, std::size_t size) {
                        self->sending_.reset();
                        if (error) return self->end();
                        if (self->closing_) return self->send_close();
                        ++self->server_->counters().sent_messages;
                        self->server_->counters().sent_bytes += size;
                        self->write_next();
                      });
}

void ViewerLink::dismiss(const std::string& why) {
  if (closing_) return;
  ++server_->counters().dismissed;
  close(websocket::close_code::policy_error, why);
}

void ViewerLink::say_goodbye() {
  close(websocket::close_code::going_away, "padr-monitor ends");
}

void ViewerLink::close(websocket::close_code code, const std::string& why) {
  if (closing_) return;
  closing_ = true;
  texts_.clear();
  views_.reset();
  farewell_ = {code, why.c_str()};
  end();
  // Something may be half on its way to somebody who never takes it.
  patience_.expires_after(kPatience);
  patience_.async_wait([self = shared_from_this()](const error_code& error) {
    if (!error) self->socket_.next_layer().close();
  });
  if (!sending_) send_close();
}

void ViewerLink::send_close() {
  socket_.async_close(farewell_, [self = shared_from_this()](const error_code&) { self->patience_.cancel(); });
}

void ViewerLink::end() {
  if (!open_) return;
  open_ = false;
  server_->left(id_);
}

}  // namespace padr::monitor
