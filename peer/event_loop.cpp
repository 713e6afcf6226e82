#include "peer/event_loop.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>

#include "common/model/user_error.h"
#include "common/world/world.h"
#include "peer/addresses.h"
#include "peer/summary.h"
#include "tools/support/files.h"
#include "tools/support/netem_flags.h"
#include "tools/support/run_main.h"
#include "tools/support/unpredictable.h"

namespace padr::peer {
namespace {

using boost::system::error_code;

/// What is still in the links when all is over may take so long to leave.
constexpr Micros kDrain = 300'000;

node::SessionConfig session_config(const Options& o, const std::optional<Endpoint>& join) {
  node::SessionConfig c;
  c.join = join;
  c.wanted = o.wait_peers;
  c.slots = o.slots;
  c.scene_hash = scene_hash(o.scenario.scene);
  c.fingerprint = world::physics_fingerprint();
  c.authority = o.technique.authority;
  c.scenario = o.scenario.label + " seed " + std::to_string(o.scenario.seed);
  c.sealed = o.key.has_value();
  c.seed = support::unpredictable();
  c.patience = std::llround(o.join_timeout * static_cast<double>(kMicrosPerSecond));
  return c;
}

}  // namespace

EventLoop::EventLoop(const Options& options, Log& log, const support::Clock& clock)
    : options_(options), log_(log), clock_(clock), io_(1), signals_(io_, SIGINT, SIGTERM), timer_(io_) {
  const std::optional<support::Udp::endpoint> join = join_address(io_, options);
  socket_ = std::make_unique<support::UdpSocket>(io_, listen_address(io_, options, join));
  local_ = support::to_endpoint(socket_->local());
  const std::vector<std::string> lines = shape_links();
  open_files();
  std::optional<Endpoint> member;
  if (join) member = support::to_endpoint(*join);
  if (options.monitor) teller_ = std::make_unique<Teller>(io_, options, log, clock);
  player_ = std::make_unique<Player>(options, session_config(options, member), gate_config(options, keylog_.get()), log,
                                     *recordings_, teller_.get(), clock_.now());
  if (teller_) controls_ = std::make_unique<Controls>(*player_, *egress_, cuts_, *teller_, log);
  log_.net->info("listening on {}", to_string(local_));
  for (const std::string& line : lines) log_.net->info("{}", line);
  if (member) log_.session->info("joining {} ({})", options.join->text, to_string(*member));
  if (!member) log_.session->info("founded, waiting for {} peers in all", options.wait_peers);
}

std::vector<std::string> EventLoop::shape_links() {
  Egress::Specs specs;
  specs.all = options_.netem;
  specs.seed = options_.netem_seed;
  std::vector<std::string> lines{"links out: " + support::describe(specs.all) + ", seed " + std::to_string(specs.seed)};
  for (const NetemOverride& n : options_.netem_to) {
    std::string where = "peer " + std::to_string(n.peer.value_or(0));
    if (n.peer) {
      specs.by_peer[*n.peer] = n.spec;
    } else {
      const support::Udp family = socket_->local().protocol();
      const Endpoint to = support::to_endpoint(support::resolve(io_, "--netem-to", *n.address, &family));
      specs.by_address[to] = n.spec;
      where = to_string(to);
    }
    lines.push_back("link to " + where + ": " + support::describe(n.spec));
  }
  egress_ = std::make_unique<Egress>(std::move(specs),
                                     [this](const Endpoint& to, std::span<const std::byte> bytes) { send(to, bytes); });
  return lines;
}

// Only once the port is ours: whoever has it may be writing to these very files.
void EventLoop::open_files() {
  recordings_ = std::make_unique<Recordings>(options_, log_);
  if (!options_.keylog.empty()) keylog_ = std::make_unique<Keylog>(options_.keylog);
  if (!options_.pcap.empty()) packets_ = std::make_unique<PacketLog>(options_, *socket_);
  if (!options_.json.empty() && options_.json != "-")
    json_ = std::make_unique<support::OutputFile>("--json", options_.json);
  if (!options_.health.empty()) health_ = std::make_unique<Health>(options_.health, log_);
}

int EventLoop::run() {
  socket_->start([this](const Endpoint& from, std::span<const std::byte> bytes) { receive(from, bytes); },
                 [this](const Endpoint& at) { player_->unreachable(at, clock_.now()); }, [this] { wake(); });
  if (teller_)
    teller_->start(
        [this](const monitor::Order& order) {
          if (!drain_until_) controls_->obey(order, clock_.now());
        },
        [this] { wake(); });
  signals_.async_wait([this](const error_code& error, int signal) {
    if (!error) on_signal(signal);
  });
  wake();
  io_.run();
  player_->finish();
  recordings_->close();
  if (packets_) {
    packets_->close();
    if (packets_->dropped() > 0)
      log_.net->error("--pcap: {} datagrams are not in it, the disk was too slow", packets_->dropped());
  }
  write_summary();
  if (health_) health_->remove();
  if (exit_code_ == 0) {
    log_.session->info("ended: {}", reason_);
  } else {
    log_.session->error("ended: {}", reason_);
  }
  return exit_code_;
}

void EventLoop::send(const Endpoint& to, std::span<const std::byte> datagram) {
  if (cuts_.is_cut(to)) return;
  socket_->post(to, datagram);
}

void EventLoop::flush() {
  // Before it goes: nobody must seem to have received it earlier.
  const std::int64_t time = packets_ ? PacketLog::now() : 0;
  socket_->flush([this, time](const Endpoint& to, std::span<const std::byte> datagram, bool sent) {
    if (sent) {
      if (packets_) packets_->sent(to, datagram, time);
    } else if (net_limit_.pass(clock_.now())) {
      log_.net->warn("cannot send to {}: {} ({} such messages held back)", to_string(to), socket_->last_error(),
                     net_limit_.take_suppressed());
    }
  });
}

void EventLoop::receive(const Endpoint& from, std::span<const std::byte> datagram) {
  if (cuts_.is_cut(from)) return;
  if (packets_) packets_->received(from, datagram, PacketLog::now());
  if (drain_until_) return;
  if (log_.net->should_log(spdlog::level::trace)) log_.net->trace("{} bytes from {}", datagram.size(), to_string(from));
  player_->receive(from, datagram, clock_.now());
}

void EventLoop::wake() {
  const Micros now = clock_.now();
  if (!drain_until_) advance(now);
  egress_->pump(now);
  flush();
  if (drain_until_ && (!egress_->next_due() || now >= *drain_until_)) {
    io_.stop();
    return;
  }
  set_timer(now);
}

void EventLoop::advance(Micros now) {
  player_->advance(now);
  send_out(now);
  end_if_over(now);
  if (player_->playing()) say_status(now);
  if (health_) health_->update(*player_, now);
  if (controls_) controls_->update(now);
  if (teller_ && !drain_until_) teller_->update(situation(), now);
}

void EventLoop::send_out(Micros now) {
  if (player_->playing()) egress_->sit(player_->self());
  for (const node::Parcel& p : player_->take_outgoing()) {
    if (p.state_to == kNoPeer) {
      egress_->session(p.to, p.bytes, now);
    } else {
      egress_->state(p.state_to, p.to, p.bytes, now);
    }
  }
}

void EventLoop::end_if_over(Micros now) {
  if (player_->failed()) return end(support::kExitFailure, player_->session().failure());
  if (!player_->playing() || !player_->done(now)) return;
  if (player_->totals().node.hash_mismatches > 0) return end(support::kExitFailure, "confirmed worlds differed");
  end(support::kExitFine, stopping_ ? "stopped" : "played to the end");
}

void EventLoop::say_status(Micros now) {
  if (options_.status_interval <= 0) return;
  const auto interval = std::max<Micros>(std::llround(options_.status_interval * kMicrosPerSecond), 1);
  if (next_status_ < 0) next_status_ = player_->session().local_at(tick_start(player_->node().now())) + interval;
  if (now < next_status_) return;
  log_.status->info("{}", status_.line(*player_, now));
  next_status_ += interval * ((now - next_status_) / interval + 1);
}

void EventLoop::set_timer(Micros now) {
  Micros due = drain_until_ ? *drain_until_ : player_->next_due();
  if (const auto next = egress_->next_due()) due = std::min(due, *next);
  if (health_ && !drain_until_) due = std::min(due, health_->next_due());
  if (teller_ && !drain_until_) due = std::min(due, teller_->next_due());
  if (const auto over = cuts_.next_due(); over && !drain_until_) due = std::min(due, *over);
  due = std::max(due, now);
  if (due == timer_due_) return;  // datagrams that came in between seldom change it
  timer_due_ = due;
  timer_.expires_at(clock_.at(due));
  timer_.async_wait([this](const error_code& error) {
    if (error) return;
    timer_due_.reset();
    wake();
  });
}

void EventLoop::on_signal(int signal) {
  const std::string name = signal == SIGINT ? "SIGINT" : "SIGTERM";
  if (stopping_ || drain_until_) {
    exit_code_ = support::kExitFailure;
    reason_ = "quit at once on a second " + name;
    io_.stop();
    return;
  }
  stopping_ = true;
  signals_.async_wait([this](const error_code& error, int again) {
    if (!error) on_signal(again);
  });
  const Micros now = clock_.now();
  if (player_->playing()) {
    if (!player_->leaving()) player_->leave(name, false, now);
  } else {
    player_->give_up();
    send_out(now);
    end(support::kExitFailure, name + " before the session started");
  }
  wake();
}

void EventLoop::end(int code, const std::string& reason) {
  exit_code_ = code;
  reason_ = reason;
  const Micros now = clock_.now();
  if (teller_) teller_->end(situation(), reason, now);
  drain_until_ = now + kDrain;
}

void EventLoop::write_summary() {
  if (options_.json.empty()) return;
  const std::string text =
      summary({options_, *player_, *egress_, *socket_, teller_.get(), local_, exit_code_, reason_});
  if (options_.json == "-") {
    std::fputs(text.c_str(), stdout);
    std::fflush(stdout);
    return;
  }
  json_->write(text);
  json_->close();
}

}  // namespace padr::peer
