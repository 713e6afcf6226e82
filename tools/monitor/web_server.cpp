#include "tools/monitor/web_server.h"

#include <boost/asio/socket_base.hpp>
#include <system_error>

#include "tools/monitor/viewer_link.h"
#include "tools/monitor/web_connection.h"

namespace padr::monitor {
namespace {

using boost::system::error_code;

}  // namespace

WebServer::WebServer(boost::asio::io_context& io, const Tcp::endpoint& address, std::vector<std::string> names,
                     WebLimits limits, Site& site)
    : names_(std::move(names)), limits_(limits), site_(&site), acceptor_(io), pause_(io) {
  error_code error;
  acceptor_.open(address.protocol(), error);
  if (!error) acceptor_.set_option(boost::asio::socket_base::reuse_address(true), error);
  if (!error) acceptor_.bind(address, error);
  if (!error) acceptor_.listen(64, error);
  if (!error) return;
  const bool v6 = address.address().is_v6();
  const std::string host = address.address().to_string();
  throw std::system_error(error,
                          "cannot listen on " + (v6 ? "[" + host + "]" : host) + ":" + std::to_string(address.port()));
}

WebServer::~WebServer() = default;

void WebServer::start() {
  accept();
}

void WebServer::stop() {
  error_code ignored;
  acceptor_.close(ignored);
  pause_.cancel();
  const auto viewers = viewers_;
  for (const auto& [id, link] : viewers)
    if (const auto l = link.lock()) l->say_goodbye();
  site_ = nullptr;
}

void WebServer::accept() {
  acceptor_.async_accept([this, self = shared_from_this()](const error_code& error, Tcp::socket socket) {
    if (!acceptor_.is_open()) return;
    if (error) {
      // Out of descriptors or memory: what is there goes on, and some of it ends.
      pause_.expires_after(std::chrono::milliseconds(100));
      pause_.async_wait([this, self](const error_code& stopped) {
        if (!stopped && acceptor_.is_open()) accept();
      });
      return;
    }
    if (stats_.connections >= limits_.connections) {
      ++stats_.turned_away;
    } else {
      std::make_shared<WebConnection>(std::move(socket), self)->start();
    }
    accept();
  });
}

void WebServer::came(ViewerId id, const std::shared_ptr<ViewerLink>& link, bool local, std::string_view query) {
  viewers_[id] = link;
  if (site_ != nullptr) site_->came(id, local, query);
}

void WebServer::left(ViewerId id) {
  if (viewers_.erase(id) > 0 && site_ != nullptr) site_->left(id);
}

ViewerLink* WebServer::find(ViewerId viewer) {
  const auto found = viewers_.find(viewer);
  return found == viewers_.end() ? nullptr : found->second.lock().get();
}

void WebServer::tell(ViewerId viewer, const Shared& text, bool may_miss) {
  if (ViewerLink* link = find(viewer)) link->tell(text, may_miss);
}

void WebServer::show(ViewerId viewer, const Shared& views) {
  if (ViewerLink* link = find(viewer)) link->show(views);
}

void WebServer::dismiss(ViewerId viewer, const std::string& why) {
  if (ViewerLink* link = find(viewer)) link->dismiss(why);
}

}  // namespace padr::monitor
