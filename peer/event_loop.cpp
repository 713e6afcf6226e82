#include "peer/event_loop.h"

#include <algorithm>

#include "common/model/own_address.h"
#include "common/model/user_error.h"
#include "peer/addresses.h"
#include "peer/summary.h"
#include "shell/run_main.h"
#include "shell/text.h"
#include "shell/unpredictable.h"

namespace padr::peer {
namespace {

/// Time that a peer which has been told to leave goes on coming in. A transfer takes less, as a rule.
constexpr Micros kComes = 2 * kMicrosPerSecond;

node::SessionConfig session_config(const Options& o, const std::vector<Contact>& join, const Endpoint& local,
                                   const PortMapping* mapping) {
  node::SessionConfig c;
  for (const Contact& member : join)
    if (!c.join)
      c.join = member.at;
    else
      c.others.push_back(member.at);
  c.wanted = o.wait_peers;
  c.slots = o.slots;
  c.spectates = o.spectates;
  c.scenario = o.scenario.label + " seed " + std::to_string(o.scenario.seed);
  c.seed = shell::unpredictable();
  c.secret = shell::unpredictable();
  c.patience = o.join_timeout > 0 ? std::max<Micros>(1, in_micros(o.join_timeout)) : 0;  // 0: for ever
  c.own_addresses = own_addresses(local);
  if (mapping != nullptr && mapping->outside()) c.own_addresses.insert(c.own_addresses.begin(), *mapping->outside());
  if (c.own_addresses.size() > kMostOwnAddresses) c.own_addresses.resize(kMostOwnAddresses);
  return c;
}

}  // namespace

EventLoop::EventLoop(const Options& options, Log& log, const shell::Clock& clock) : Loop(options, log, clock) {
  const std::vector<std::string> links = shape_links();
  open_all_files();
  if (options.monitor) telemetry_ = std::make_unique<Telemetry>(io_, options, log, clock);
  player_ =
      std::make_unique<Player>(options, session_config(options, join_, local_, mapping_.get()),
                               gate_config(options, keylog_.get()), log, *recordings_, telemetry_.get(), clock_.now());
  if (telemetry_) controls_ = std::make_unique<Controls>(*player_, *egress_, cuts_, *telemetry_, log);
  say_where(links);
  for (std::size_t i = 0; i < join_.size(); ++i)
    log_.session->info("{} {} ({})", i == 0 ? "joining" : "or", join_[i].text, to_string(join_[i].at));
  if (join_.empty())
    log_.session->info("founded, waiting for {}",
                       shell::counted(options.wait_peers, options.spectates ? "player" : "peer") +
                           (options.spectates ? "" : " in all"));
}

void EventLoop::open_all_files() {
  recordings_ = std::make_unique<Recordings>(options_, log_);
  if (!options_.keylog.empty()) keylog_ = std::make_unique<Keylog>(options_.keylog, log_);
  open_files();
  if (!options_.health.empty()) health_ = std::make_unique<Health>(options_.health, log_);
}

void EventLoop::start() {
  Loop::start();
  if (!telemetry_) return;
  const auto obey = [this](const monitor::Order& order) {
    if (!ending()) controls_->obey(order, clock_.now());
  };
  telemetry_->start(obey, [this] { wake(); });
}

void EventLoop::finish() {
  player_->finish();
  const auto close_keylog = [this] {
    if (keylog_) keylog_->close();
  };
  shell::do_all({[this] { or_fail([this] { recordings_->close(); }); }, [&] { or_fail(close_keylog); },
                 [this] { Loop::finish(); },
                 [this] {
                   if (health_) health_->remove();
                 }});
}

void EventLoop::receive(const Endpoint& from, std::span<const std::byte> datagram, Micros now) {
  if (log_.net->should_log(spdlog::level::trace)) log_.net->trace("{} bytes from {}", datagram.size(), to_string(from));
  player_->receive(from, datagram, now);
}

void EventLoop::advance(Micros now) {
  player_->advance(now);
  give_up_coming(now);
  if (ending()) return;
  send_out(now);
  end_if_over(now);
  if (player_->playing()) say_status(now);
  if (health_) health_->update(*player_, now);
  if (controls_) controls_->update(now);
  if (telemetry_ && !ending()) telemetry_->update(situation(), now);
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
  if (player_->failed()) return end(shell::kExitFailure, player_->session().failure());
  if (!player_->playing() || !player_->done(now)) return;
  if (!player_->has_begun()) return end(shell::kExitFailure, signal_ + " before the session started");
  if (player_->totals().replica.hash_mismatches > 0) return end(shell::kExitFailure, "confirmed worlds differed");
  end(shell::kExitFine, stopping_ ? "stopped" : "played to the end");
}

void EventLoop::say_status(Micros now) {
  const Micros since = player_->session().local_at(tick_start(player_->replica().now()));
  if (is_time_for_status(since, now)) log_.status->info("{}", status_.line(*player_, now));
}

Micros EventLoop::next_due() const {
  Micros due = player_->next_due();
  if (health_) due = std::min(due, health_->next_due());
  if (telemetry_) due = std::min(due, telemetry_->next_due());
  if (comes_until_) due = std::min(due, *comes_until_);
  if (const auto over = cuts_.next_due()) due = std::min(due, *over);
  return due;
}

void EventLoop::stop(const std::string& signal, Micros now) {
  signal_ = signal;
  if (player_->playing()) {
    if (!player_->leaving()) player_->leave(signal, false, now);
  } else {
    // Once welcomed it may have been admitted already, and then the others would wait for it.
    const bool comes = player_->session().phase() == node::SessionPhase::kEntering;
    comes_until_ = comes ? now + kComes : now;
    give_up_coming(now);
  }
}

void EventLoop::give_up_coming(Micros now) {
  if (!comes_until_ || (now < *comes_until_ && !player_->playing())) return;
  comes_until_.reset();
  if (player_->playing()) return player_->leave(signal_, false, now);
  player_->give_up(now);
  send_out(now);
  end(shell::kExitFailure, signal_ + " before the session started");
}

void EventLoop::end(int code, const std::string& reason) {
  Loop::end(code, reason);
  if (telemetry_) telemetry_->end(situation(), reason, clock_.now());
}

std::string EventLoop::summary_text() const {
  return summary({options_, *player_, *egress_, *socket_, telemetry_.get(), local_, exit_code_, reason_});
}

}  // namespace padr::peer
