#include "peer/crowd_loop.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>

#include "common/world/world.h"
#include "peer/addresses.h"
#include "tools/support/netem_flags.h"
#include "tools/support/run_main.h"
#include "tools/support/scenario_flags.h"
#include "tools/support/unpredictable.h"

namespace padr::peer {
namespace {

using boost::system::error_code;

/// What is still in the links when all is over may take so long to leave.
constexpr Micros kLastWords = 300'000;
constexpr Micros kOneTick = kMicrosPerSecond / kTicksPerSecond;

Micros us_of(double seconds) {
  return std::llround(seconds * static_cast<double>(kMicrosPerSecond));
}

}  // namespace

CrowdLoop::CrowdLoop(const Options& options, Log& log, const support::Clock& clock)
    : options_(options), log_(log), clock_(clock), io_(1), signals_(io_, SIGINT, SIGTERM), timer_(io_) {
  const std::optional<support::Udp::endpoint> join = join_address(io_, options);
  socket_ = std::make_unique<support::UdpSocket>(io_, listen_address(io_, options, join));
  record_.local = support::to_endpoint(socket_->local());
  log_.net->info("listening on {}", to_string(record_.local));
  shape_links();
  open_files();
  std::optional<Endpoint> contact;
  if (join) contact = support::to_endpoint(*join);
  make_peer(contact);
  if (contact) log_.session->info("joining the crowd of {} ({})", options.join->text, to_string(*contact));
  if (!contact) log_.session->info("founding a crowd, with seed {}", options.crowd->plane.seed);
}

void CrowdLoop::shape_links() {
  Egress::Specs specs;
  specs.all = options_.netem;
  specs.seed = options_.netem_seed;
  log_.net->info("links out: {}, seed {}", support::describe(specs.all), specs.seed);
  for (const NetemOverride& n : options_.netem_to) {
    const support::Udp family = socket_->local().protocol();
    const Endpoint to = support::to_endpoint(support::resolve(io_, "--netem-to", *n.address, &family));
    specs.by_address[to] = n.spec;
    log_.net->info("link to {}: {}", to_string(to), support::describe(n.spec));
  }
  egress_ = std::make_unique<Egress>(std::move(specs),
                                     [this](const Endpoint& to, std::span<const std::byte> bytes) { send(to, bytes); });
}

void CrowdLoop::open_files() {
  if (!options_.pcap.empty()) packets_ = std::make_unique<PacketLog>(options_, *socket_);
  if (!options_.json.empty() && options_.json != "-")
    json_ = std::make_unique<support::OutputFile>("--json", options_.json);
}

void CrowdLoop::make_peer(const std::optional<Endpoint>& contact) {
  const CrowdOptions& o = *options_.crowd;
  crowd::CrowdConfig c;
  c.plane = o.plane;
  c.technique = options_.technique;
  c.fingerprint = world::physics_fingerprint();
  c.seed = support::unpredictable();
  c.start = o.start;
  c.contact = contact;
  c.on_confirmed = [this](crowd::Region r, const sync::FoldState& s, std::uint64_t hash) {
    record_.confirm(r, s.tick, hash);
  };
  peer_ = std::make_unique<crowd::CrowdPeer>(c);
  input_ = support::load_input(options_.input, o.ground, 0, c.seed);
}

int CrowdLoop::run() {
  socket_->start([this](const Endpoint& from, std::span<const std::byte> bytes) { receive(from, bytes); },
                 [this](const Endpoint& at) { peer_->unreachable(at, clock_.now()); }, [this] { wake(); });
  signals_.async_wait([this](const error_code& error, int signal) {
    if (!error) on_signal(signal);
  });
  wake();
  io_.run();
  if (packets_) {
    packets_->close();
    if (packets_->dropped() > 0)
      log_.net->error("--pcap: {} datagrams are not in it, the disk was too slow", packets_->dropped());
  }
  write_summary();
  const auto level = record_.exit_code == 0 ? spdlog::level::info : spdlog::level::err;
  log_.session->log(level, "ended: {}", record_.reason);
  return record_.exit_code;
}

void CrowdLoop::receive(const Endpoint& from, std::span<const std::byte> datagram) {
  if (packets_) packets_->received(from, datagram, PacketLog::now());
  if (!drain_until_) peer_->receive(from, datagram, clock_.now());
}

void CrowdLoop::send(const Endpoint& to, std::span<const std::byte> datagram) {
  socket_->post(to, datagram);
}

void CrowdLoop::flush() {
  // Before it goes: nobody must seem to have received it earlier.
  const std::int64_t time = packets_ ? PacketLog::now() : 0;
  socket_->flush([this, time](const Endpoint& to, std::span<const std::byte> datagram, bool sent) {
    if (sent && packets_) packets_->sent(to, datagram, time);
    if (!sent && net_limit_.pass(clock_.now()))
      log_.net->warn("cannot send to {}: {} ({} such messages held back)", to_string(to), socket_->last_error(),
                     net_limit_.take_suppressed());
  });
}

void CrowdLoop::wake() {
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

void CrowdLoop::advance(Micros now) {
  turn(now);
  // Peers have a number in every region, so links are told apart by address.
  for (const node::Parcel& p : peer_->take_outgoing()) egress_->session(p.to, p.bytes, now);
  tell();
  end_if_over(now);
  if (peer_->playing() && !left_at_) say_status(now);
}

void CrowdLoop::turn(Micros now) {
  if (peer_->playing() && !left_at_ && now >= peer_->next_step()) {
    const Micros lateness = now - peer_->next_step();
    record_.lateness.add(lateness);
    if (lateness > kOneTick) ++record_.late;
  }
  peer_->turn([this](Tick t) { return input_->target(t - std::max(record_.first_tick, 0)); }, now);
  if (peer_->playing() && record_.first_tick < 0) note_playing(now);
  const auto length = static_cast<Tick>(std::llround(options_.duration * kTicksPerSecond));
  if (length > 0 && record_.first_tick >= 0 && !left_at_ && peer_->now() - record_.first_tick >= length)
    leave("the time to play is over", now);
}

void CrowdLoop::note_playing(Micros now) {
  record_.first_tick = peer_->now();
  record_.joined_at = now;
  log_.session->info("in the crowd: at home in region {},{} at tick {}", peer_->home().x, peer_->home().y,
                     record_.first_tick);
  log_.play->info("technique {}", describe(options_.technique));
}

void CrowdLoop::tell() {
  for (const auto& [region, note] : peer_->take_notes())
    log_.session->log(note.problem ? spdlog::level::warn : spdlog::level::debug, "region {},{}: {}", region.x, region.y,
                      note.text);
}

void CrowdLoop::leave(const std::string& why, Micros now) {
  record_.look(*peer_);
  log_.session->info("leaving {} regions at tick {}: {}", record_.places.size(), record_.last_tick, why);
  left_at_ = now;
  peer_->leave(now);
}

void CrowdLoop::end_if_over(Micros now) {
  if (drain_until_) return;
  if (left_at_) {
    if (!peer_->gone() && now - *left_at_ < us_of(options_.linger)) return;
    return end(support::kExitFine, stopping_ ? "stopped" : "played to the end");
  }
  if (peer_->playing()) return;
  if (!peer_->finder().failure().empty()) return end(support::kExitFailure, peer_->finder().failure());
  if (options_.join_timeout > 0 && now >= us_of(options_.join_timeout))
    end(support::kExitFailure, fmt::format("{} within {} s",
                                           peer_->finder().met() ? "could not come into the region of --start"
                                                                 : "no answer from " + options_.join->text,
                                           options_.join_timeout));
}

void CrowdLoop::say_status(Micros now) {
  if (options_.status_interval <= 0) return;
  const Micros interval = std::max<Micros>(us_of(options_.status_interval), 1);
  if (next_status_ < 0) next_status_ = now + interval;
  if (now < next_status_) return;
  next_status_ += interval * ((now - next_status_) / interval + 1);
  CrowdRecord here;
  here.look(*peer_);
  std::size_t others = 0;
  Tick oldest = here.last_tick;
  for (const CrowdRecord::Place& p : here.places) others = std::max(others, p.others.size());
  for (const CrowdRecord::Place& p : here.places) oldest = std::min(oldest, p.confirmed);
  const std::uint64_t bytes = peer_->stats().wire_bytes;
  const double seconds = std::max(1e-3, static_cast<double>(now - told_at_) / kMicrosPerSecond);
  log_.status->info(
      "{:6.1f} s  at {:.1f},{:.1f} in region {},{}  {} regions, up to {} others in one  confirmed -{:.0f} ms  sent "
      "{:.1f} kbit/s  crossings {}  late {}",
      static_cast<double>(here.last_tick) / kTicksPerSecond, here.position.x, here.position.y, here.home.x, here.home.y,
      here.places.size(), others, (here.last_tick - oldest) * 1000.0 / kTicksPerSecond,
      static_cast<double>(bytes - told_bytes_) * 8e-3 / seconds, peer_->stats().handovers, record_.late);
  told_bytes_ = bytes;
  told_at_ = now;
}

void CrowdLoop::set_timer(Micros now) {
  Micros due = drain_until_ ? *drain_until_ : peer_->next_due();
  if (left_at_ && !drain_until_) due = std::min(due, *left_at_ + us_of(options_.linger));
  if (const auto next = egress_->next_due()) due = std::min(due, *next);
  due = std::max(due, now);
  if (due == timer_due_) return;
  timer_due_ = due;
  timer_.expires_at(clock_.at(due));
  timer_.async_wait([this](const error_code& error) {
    if (error) return;
    timer_due_.reset();
    wake();
  });
}

void CrowdLoop::on_signal(int signal) {
  const std::string name = signal == SIGINT ? "SIGINT" : "SIGTERM";
  if (stopping_ || drain_until_) {
    record_.exit_code = support::kExitFailure;
    record_.reason = "quit at once on a second " + name;
    io_.stop();
    return;
  }
  stopping_ = true;
  signals_.async_wait([this](const error_code& error, int again) {
    if (!error) on_signal(again);
  });
  if (!peer_->playing()) {
    end(support::kExitFailure, name + " before it came into the crowd");
  } else if (!left_at_) {
    leave(name, clock_.now());
  }
  wake();
}

void CrowdLoop::end(int code, const std::string& reason) {
  record_.exit_code = code;
  record_.reason = reason;
  drain_until_ = clock_.now() + kLastWords;
}

void CrowdLoop::write_summary() {
  if (options_.json.empty()) return;
  const std::string text = summary(options_, record_, *peer_, socket_->stats());
  if (options_.json == "-") {
    std::fputs(text.c_str(), stdout);
    std::fflush(stdout);
    return;
  }
  json_->write(text);
  json_->close();
}

}  // namespace padr::peer
