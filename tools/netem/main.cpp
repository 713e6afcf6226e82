#include <utility>  // Boost.Asio 1.74 uses std::exchange without including this

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/model/rng.h"
#include "common/model/user_error.h"
#include "shell/netem_flags.h"
#include "shell/run_main.h"
#include "shell/stop_signals.h"
#include "tools/netem/options.h"
#include "tools/netem/relay.h"

namespace padr::netem {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// A datagram would go round for ever, as a new client each time.
void refuse_circles(const std::vector<std::unique_ptr<Relay>>& relays) {
  for (const auto& first : relays) {
    const Relay* at = first.get();
    for (std::size_t hops = 0; hops < relays.size() && at != nullptr; ++hops) {
      const auto next = std::find_if(relays.begin(), relays.end(), [at](const auto& r) { return at->leads_to(*r); });
      at = next == relays.end() ? nullptr : next->get();
      if (at == first.get()) throw UserError("--link: " + first->name() + " would relay in a circle, back to itself");
    }
  }
}

/// Calls itself every `interval` on absolute deadlines, so the period does not drift.
class Periodic {
 public:
  Periodic(asio::io_context& io, Micros interval, std::function<void()> action)
      : timer_(io), interval_(interval), action_(std::move(action)) {
    timer_.expires_after(interval_);
    wait();
  }

 private:
  void wait() {
    timer_.async_wait([this](const error_code& error) {
      if (error) return;
      action_();
      timer_.expires_at(timer_.expiry() + interval_);
      wait();
    });
  }
  asio::steady_timer timer_;
  std::chrono::microseconds interval_;
  std::function<void()> action_;
};

int run(const Options& options) {
  asio::io_context io(1);
  const Clock clock;
  asio::signal_set signals(io);
  shell::add_stop_signals(signals);
  signals.async_wait([&io](const error_code& error, int) {
    if (!error) io.stop();
  });

  std::vector<std::unique_ptr<Relay>> relays;
  const Relay::Limits limits{options.max_clients, in_micros(options.client_idle)};
  for (const LinkOptions& l : options.links)
    relays.push_back(std::make_unique<Relay>(io, clock, l, derive_seed(options.seed, relays.size()), limits));
  refuse_circles(relays);
  for (std::size_t i = 0; i < relays.size(); ++i)
    spdlog::info("{}: there {}, back {}, seed {}", relays[i]->name(), shell::describe(options.links[i].to_target),
                 shell::describe(options.links[i].to_client), options.seed);
  for (const auto& relay : relays) relay->start();

  const auto stats = spdlog::stdout_logger_st("stats");
  stats->set_pattern("%Y-%m-%dT%H:%M:%S.%e %v");
  const auto print_stats = [&](const char* when) {
    errno = 0;
    for (const auto& relay : relays) stats->info("{} {}", when, relay->stats_line());
    stats->flush();
    if (std::ferror(stdout) != 0) shell::cannot_write_to_standard_output();
  };

  const Periodic sweep(io, kMicrosPerSecond, [&] {
    for (const auto& relay : relays) relay->forget_idle_clients();
  });
  std::unique_ptr<Periodic> reports;
  if (options.stats_interval > 0) {
    reports = std::make_unique<Periodic>(io, std::max<Micros>(in_micros(options.stats_interval), 10'000),
                                         [&] { print_stats("now"); });
  }
  asio::steady_timer end(io);
  if (options.duration > 0) {
    end.expires_after(std::chrono::microseconds(in_micros(options.duration)));
    end.async_wait([&io](const error_code& error) {
      if (!error) io.stop();
    });
  }
  io.run();
  print_stats("end");
  return shell::kExitFine;
}

}  // namespace
}  // namespace padr::netem

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_logger_st("padr-netem"));
  spdlog::set_pattern("%Y-%m-%dT%H:%M:%S.%e %l %v");
  return padr::shell::run_main("padr-netem", [argc, argv] {
    const auto options = padr::netem::parse_options(argc, argv);
    if (!options) return padr::shell::kExitFine;
    for (const auto& line : options->warnings) spdlog::warn("{}", line);
    return padr::netem::run(*options);
  });
}
