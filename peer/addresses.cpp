#include "peer/addresses.h"

#include "common/model/user_error.h"

namespace padr::peer {

std::optional<shell::Udp::endpoint> join_address(boost::asio::io_context& io, const Options& o) {
  if (!o.join) return std::nullopt;
  if (!o.listen) return shell::resolve(io, "--join", *o.join);
  const shell::Udp::endpoint own = shell::resolve(io, "--listen", *o.listen);
  return shell::resolve(io, "--join", *o.join, &own);
}

shell::Udp::endpoint listen_address(boost::asio::io_context& io, const Options& o,
                                    const std::optional<shell::Udp::endpoint>& join) {
  const bool v6 = join && join->address().is_v6();
  if (!o.listen) {
    if (join && !join->address().is_loopback())
      throw UserError("--join: " + o.join->text + " is not on this machine, and without --listen a peer stays on the " +
                      "loopback address; give --listen " + (v6 ? "'[::]:0'" : "0.0.0.0:0") +
                      (o.key ? "" : " and --key-file FILE, or --insecure"));
    if (v6) return {boost::asio::ip::address_v6::loopback(), 0};
    return {boost::asio::ip::address_v4::loopback(), 0};
  }
  shell::Udp::endpoint listen = shell::resolve(io, "--listen", *o.listen);
  if (!listen.address().is_loopback() && !o.insecure && !o.key)
    throw UserError("--listen: " + o.listen->text +
                    " can be reached by other machines, and nothing proves who sends a " +
                    "datagram; give --key-file FILE, a loopback address, or --insecure if you trust the network");
  if (join && listen.address().is_loopback() && !join->address().is_loopback())
    throw UserError("--listen: " + o.listen->text + " is a loopback address, which cannot reach --join " +
                    o.join->text);
  return listen;
}

}  // namespace padr::peer
