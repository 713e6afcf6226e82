#pragma once

#include <boost/asio/signal_set.hpp>
#include <string_view>

namespace padr::shell {

/// Adds the signals that end a program properly: SIGINT, SIGTERM, and SIGHUP unless it is ignored, as nohup has it.
/// From then on a reader of the program's output that ends is a failed write, and does not kill the program: Ctrl-C
/// reaches both `padr-peer` and the `tee` behind it.
void add_stop_signals(boost::asio::signal_set& signals);
/// "SIGINT", for instance, of one of these.
std::string_view name_of_signal(int signal);

}  // namespace padr::shell
