#include <boost/asio/buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <string_view>

#include "tests/fuzz/bytes.h"
#include "tools/monitor/guard.h"
#include "tools/monitor/request.h"

// What anybody may send to padr-monitor's port: a request with its headers, or, once it is a page, a message.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace padr;
  namespace http = boost::beast::http;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  monitor::read_request(text);

  http::request_parser<http::empty_body> parser;
  parser.header_limit(8 * 1024);
  parser.body_limit(0);
  boost::system::error_code error;
  parser.put(boost::asio::buffer(text.data(), text.size()), error);
  const auto of = [](boost::beast::string_view s) { return std::string_view(s.data(), s.size()); };
  const std::string_view host = error ? text : of(parser.get()[http::field::host]);
  monitor::host_allowed(host, {});
  monitor::same_origin(error ? text : of(parser.get()[http::field::origin]), host);
  if (const auto target = monitor::split_target(error ? text : of(parser.get().target())))
    monitor::query_field(target->query, "peer");
  return 0;
}
