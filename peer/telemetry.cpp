#include "peer/telemetry.h"

#include <boost/asio/ip/address.hpp>

#include "common/model/user_error.h"
#include "peer/status.h"
#include "shell/netem_text.h"
#include "shell/revision.h"
#include "shell/technique_text.h"
#include "shell/text.h"
#include "shell/unpredictable.h"

namespace padr::peer {
namespace {

namespace asio = boost::asio;

// What is told besides frames: a status every beat, who this is and pieces of the scenario every fourth.
constexpr Micros kBeat = 250'000;
constexpr int kHelloEvery = 4;
constexpr int kPiecesAtATime = 8;
// A name that nobody knows yet, such as that of a container that is not there, is asked for again this often.
constexpr int kResolveEvery = 40;  // beats
// Of the steps that a held up peer makes to catch up nobody wants to see all, and they come at once.
constexpr Micros kTooLate = 250'000;
constexpr int kAgreedPerStep = 3;
// Where the system says that nobody listens, frames are not told until a hello has gone unrefused.
constexpr Micros kNobody = kHelloEvery * kBeat + kBeat / 2;

/// Where orders may come from without proof of who sends them.
bool may_order(const Options& o, const Endpoint& monitor) {
  return o.monitor->control && (monitor.is_loopback() || o.insecure);
}

shell::Udp::endpoint any_towards(const shell::Udp::endpoint& to) {
  const auto address = to.address();
  if (address.is_v6())
    return {address.is_loopback() ? asio::ip::address_v6::loopback() : asio::ip::address_v6::any(), 0};
  return {address.is_loopback() ? asio::ip::address_v4::loopback() : asio::ip::address_v4::any(), 0};
}

}  // namespace

Telemetry::Telemetry(asio::io_context& io, const Options& options, Log& log, const shell::Clock& clock)
    : options_(options),
      log_(log),
      clock_(clock),
      io_(io),
      resolver_(io),
      sampler_(options.monitor->rate, options.monitor->detail) {
  from_.process = shell::unpredictable();
  token_ = shell::unpredictable();
  std::optional<shell::Udp::endpoint> where;
  try {
    where = shell::resolve(io, "--monitor", options.monitor->where);
  } catch (const UserError& e) {
    log_.net->warn("{}; trying again from time to time", e.what());
  }
  if (where) found(*where);
}

void Telemetry::found(const shell::Udp::endpoint& where) {
  to_ = shell::to_endpoint(where);
  obeys_ = may_order(options_, *to_);
  if (options_.monitor->control && !obeys_)
    throw UserError("--control: " + options_.monitor->where.text +
                    " is not on this machine, and nothing proves who sends orders; give a loopback address to "
                    "--monitor, or --insecure if you trust the network");
  socket_ = std::make_unique<shell::UdpSocket>(io_, any_towards(where));
  log_.net->info("sending telemetry to the monitor at {}{}", to_string(*to_), obeys_ ? ", and obeying it" : "");
}

// By a thread of Asio's: a name server that does not answer holds nobody up.
void Telemetry::resolve_again() {
  const shell::HostPort& where = options_.monitor->where;
  resolver_.async_resolve(
      where.host, std::to_string(where.port),
      [this](const boost::system::error_code& error, const shell::Udp::resolver::results_type& all) {
        if (error || all.empty() || socket_) return;
        try {
          found(all.begin()->endpoint());
          if (obey_) start(obey_, afterwards_);
        } catch (const std::exception& e) {
          log_.net->error("{}", e.what());
        }
      });
}

void Telemetry::start(Obey obey, std::function<void()> afterwards) {
  obey_ = std::move(obey);
  afterwards_ = std::move(afterwards);
  if (socket_)
    socket_->start([this](const Endpoint& from, std::span<const std::byte> bytes) { receive(from, bytes); },
                   [this](const Endpoint&) { nobody_until_ = clock_.now() + kNobody; }, afterwards_);
}

void Telemetry::close() {
  resolver_.cancel();
  if (socket_) socket_->close();
}

void Telemetry::receive(const Endpoint& from, std::span<const std::byte> datagram) {
  const auto order = obeys_ && from == to_ ? monitor::decode_order(datagram) : std::nullopt;
  const bool known = order && order->process == from_.process && order->token == token_;
  if (!known || (order->issuer == issuer_ && order->number <= taken_)) {
    ++stats_.rejected;
    return;
  }
  issuer_ = order->issuer;
  taken_ = order->number;
  ++stats_.orders;
  obey_(*order);
}

void Telemetry::send(const monitor::Message& message) {
  if (!socket_) return;
  for (const monitor::Bytes& datagram : monitor::encode(from_, message)) {
    if (socket_->send(*to_, datagram)) {
      ++stats_.datagrams;
      stats_.bytes += datagram.size();
    } else {
      ++stats_.untold;
    }
  }
}

void Telemetry::begun(const node::Replica& replica, int incarnation) {
  incarnation_ = incarnation;
  from_.session = replica.config().session;
  from_.slot = replica.self();
  from_.incarnation = replica.config().incarnation;
  sampler_.begin(replica, incarnation == 0 ? "is in the session" : "plays in life " + std::to_string(incarnation + 1));
  beat_ = 0;  // hello
  next_ = 0;
}

void Telemetry::stepped(const Step& s) {
  agreed_told_ = 0;
  sampler_.observe(s.replica);
  if (s.driven != driven_) {
    driven_ = s.driven;
    say({0, s.replica.now(), driven_ ? monitor::EventKind::kDrive : monitor::EventKind::kDriveEnd, kNoEntity,
         s.replica.self(), drive_order_, ""});
    drive_order_ = 0;
  }
  if (!listened_to() || s.lateness > kTooLate || !sampler_.due(s.replica.now())) return;
  sampler_.frame(s.replica, s.target, frame_);
  frame_.driven = s.driven;
  send(frame_);
}

void Telemetry::confirmed(int incarnation, const sync::FoldState& state, std::uint64_t hash) {
  if (!listened_to() || incarnation != incarnation_ || options_.monitor->detail != monitor::Detail::kAll ||
      !sampler_.due(state.tick) || agreed_told_ >= kAgreedPerStep)
    return;
  ++agreed_told_;
  monitor::Sampler::agreed(state, hash, options_.technique.authority, agreed_);
  send(agreed_);
}

void Telemetry::update(const Situation& s, Micros now) {
  tell_news(false);
  if (now < next_) return;
  next_ = now + kBeat;
  if (!socket_ && beat_ % kResolveEvery == kResolveEvery - 1) resolve_again();
  if (beat_ % kHelloEvery == 0) {
    tell_hello(s);
    tell_scenario();
  }
  ++beat_;
  if (!s.player.playing()) return;
  tell_status(s);
  tell_news(true);
}

void Telemetry::end(const Situation& s, const std::string& reason, Micros now) {
  const Tick tick = s.player.playing() ? s.player.replica().now() : 0;
  say({0, tick, monitor::EventKind::kEnd, kNoEntity, from_.slot, 0, reason});
  next_ = now;
  update(s, now);
}

void Telemetry::tell_hello(const Situation& s) {
  const node::Session& session = s.player.session();
  monitor::Hello h;
  h.version = std::string(shell::version()) + " " + std::string(shell::revision());
  h.control = obeys_;
  h.token = obeys_ ? token_ : 0;
  h.at = s.at;
  h.slots = session.slots();
  h.incarnation = std::max(incarnation_, 0);
  h.scenario = options_.scenario.label;
  h.scenario_seed = options_.scenario.seed;
  h.scene_hash = scene_hash(options_.scenario.scene);
  const std::size_t length = options_.scenario.text.size();
  h.scenario_bytes = length <= monitor::kMostScenario ? static_cast<std::uint32_t>(length) : 0;
  h.technique = shell::describe(s.player.technique());
  h.netem = shell::to_string(s.egress.spec_of_all());
  h.input = options_.input;
  h.rate = sampler_.rate();
  h.detail = sampler_.detail();
  if (!s.player.playing()) from_.session = session.number();
  send(h);
}

void Telemetry::tell_scenario() {
  const std::string& text = options_.scenario.text;
  if (text.size() > monitor::kMostScenario) return;
  monitor::ScenarioPart part;
  part.scene_hash = scene_hash(options_.scenario.scene);
  part.total = static_cast<std::uint32_t>(text.size());
  for (std::size_t told = 0, i = 0; i < kPiecesAtATime && told < text.size(); ++i) {
    if (scenario_at_ >= text.size()) scenario_at_ = 0;
    part.offset = static_cast<std::uint32_t>(scenario_at_);
    part.text = text.substr(scenario_at_, monitor::kMostPart);
    scenario_at_ += part.text.size();
    told += part.text.size();
    send(part);
  }
}

void Telemetry::tell_status(const Situation& s) {
  const Player& player = s.player;
  monitor::Status status = monitor::Sampler::status(player.replica());
  const Totals totals = player.totals();
  status.updates_by_cause = totals.replica.updates_by_cause;
  status.datagrams_sent = totals.replica.datagrams_sent;
  status.bytes_sent = totals.replica.wire_bytes_sent;
  status.repeats = totals.replica.repeats;
  status.datagrams_received = totals.replica.datagrams_received;
  status.dropped = 0;
  for (const std::uint64_t n : totals.replica.dropped) status.dropped += n;
  status.hash_checks = totals.replica.hash_checks;
  status.hash_mismatches = totals.replica.hash_mismatches;
  status.replayed_steps = totals.replayed_steps;
  status.steps = totals.ticks;
  status.late_ticks = player.ticks().late;
  status.worst_late_us = player.ticks().lateness.worst();
  status.paused = player.paused();
  status.untold = stats_.untold;
  for (monitor::LinkStatus& l : status.links) {
    l.netem = shell::to_string(s.egress.spec_of(l.to, l.at));
    l.cut_out = s.cuts.is_cut_out(l.at);
    l.cut_in = s.cuts.is_cut_in(l.at);
    l.carrier = player.carrier(l.to);
  }
  send(status);
}

// The last ones once more with what is new, and with every status: datagrams get lost.
void Telemetry::tell_news(bool again) {
  std::vector<monitor::Event> fresh = sampler_.take_events();
  for (monitor::Event& e : fresh) news_.push_back(std::move(e));
  if (news_.empty() || (fresh.empty() && !again)) return;
  // So many at once that they do not fit one datagram: then in several.
  std::size_t untold = fresh.size();
  while (untold > monitor::kMostEvents) {
    const auto first = news_.end() - static_cast<std::ptrdiff_t>(untold);
    send(monitor::Events{{first, first + static_cast<std::ptrdiff_t>(monitor::kMostEvents)}});
    untold -= monitor::kMostEvents;
  }
  while (news_.size() > monitor::kMostEvents) news_.pop_front();
  send(monitor::Events{{news_.begin(), news_.end()}});
}

}  // namespace padr::peer
