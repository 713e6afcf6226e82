#include "peer/crowd_loop.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>

#include "common/world/fingerprint.h"
#include "shell/run_main.h"
#include "shell/scenario_flags.h"
#include "shell/session_words.h"
#include "shell/technique_text.h"
#include "shell/text.h"
#include "shell/unpredictable.h"

namespace padr::peer {
namespace {

constexpr Micros kOneTick = kMicrosPerSecond / kTicksPerSecond;

}  // namespace

CrowdLoop::CrowdLoop(const Options& options, Log& log, const shell::Clock& clock) : Loop(options, log, clock) {
  say_where(shape_links());
  open_files();
  make_peer();
  if (!join_.empty())
    log_.session->info("joining the crowd of {} ({})", join_.front().text, to_string(join_.front().at));
  if (join_.empty()) log_.session->info("founding a crowd, with seed {}", options.crowd->plane.seed);
}

void CrowdLoop::make_peer() {
  const CrowdOptions& o = *options_.crowd;
  crowd::CrowdConfig c;
  c.plane = o.plane;
  c.technique = options_.technique;
  c.fingerprint = world::physics_fingerprint();
  c.seed = shell::unpredictable();
  c.secret = shell::unpredictable();
  c.start = o.start;
  if (!join_.empty()) c.contact = join_.front().at;
  c.on_confirmed = [this](crowd::Region r, const sync::FoldState& s, std::uint64_t hash) {
    record_.confirm(r, s.tick, hash);
  };
  peer_ = std::make_unique<crowd::CrowdPeer>(c);
  input_ = shell::load_input(options_.input, o.ground, 0, c.seed);
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
  if (options_.duration > 0 && record_.first_tick >= 0 && !left_at_ && peer_->now() - record_.first_tick >= length)
    leave("the time to play is over", now);
}

void CrowdLoop::note_playing(Micros now) {
  record_.first_tick = peer_->now();
  record_.joined_at = now;
  log_.session->info("in the crowd: at home in region {},{} at tick {}", peer_->home().x, peer_->home().y,
                     record_.first_tick);
  log_.play->info("technique {}", shell::describe(options_.technique));
}

void CrowdLoop::tell() {
  for (const auto& [region, event] : peer_->take_events())
    log_.session->log(shell::is_problem(event) ? spdlog::level::warn : spdlog::level::debug, "region {},{}: {}",
                      region.x, region.y, shell::words_of(event));
}

// It joins by one address only: what is not reached before it has met anybody is that.
void CrowdLoop::unreachable(const Endpoint& at, Micros now) {
  nobody_listens_ |= !peer_->finder().met();
  peer_->unreachable(at, now);
}

void CrowdLoop::leave(const std::string& why, Micros now) {
  record_.look(*peer_);
  log_.session->info("leaving {} at tick {}: {}", shell::counted(record_.places.size(), "region"), record_.last_tick,
                     why);
  left_at_ = now;
  peer_->leave(now);
}

void CrowdLoop::end_if_over(Micros now) {
  if (ending()) return;
  if (left_at_) {
    if (!peer_->gone() && now - *left_at_ < in_micros(options_.linger)) return;
    return end(shell::kExitFine, stopping_ ? "stopped" : "played to the end");
  }
  if (peer_->playing()) return;
  if (!peer_->finder().failure().empty()) return end(shell::kExitFailure, peer_->finder().failure());
  if (options_.join_timeout > 0 && now >= in_micros(options_.join_timeout))
    end(shell::kExitFailure,
        peer_->finder().met()
            ? fmt::format("could not enter the region of --start within {} s", options_.join_timeout)
            : fmt::format("no answer from {} within {} s{}", join_.front().text, options_.join_timeout,
                          nobody_listens_ ? ": nobody listens there" : "; it may play in a session, not in a crowd"));
}

void CrowdLoop::say_status(Micros now) {
  if (!is_time_for_status(now, now)) return;
  CrowdRecord here;
  here.look(*peer_);
  std::size_t others = 0;
  Tick oldest = here.last_tick;
  for (const CrowdRecord::Place& p : here.places) others = std::max(others, p.others.size());
  for (const CrowdRecord::Place& p : here.places) oldest = std::min(oldest, p.confirmed);
  const std::uint64_t bytes = peer_->stats().wire_bytes;
  const double seconds = std::max(1e-3, static_cast<double>(now - told_at_) / kMicrosPerSecond);
  log_.status->info(
      "{:6.1f} s  at {:.1f},{:.1f} in region {},{}  {}, up to {} in one  confirmed -{:.0f} ms  sent "
      "{:.1f} kbit/s  crossings {}  late {}",
      static_cast<double>(here.last_tick) / kTicksPerSecond, here.position.x, here.position.y, here.home.x, here.home.y,
      shell::counted(here.places.size(), "region"), shell::counted(others, "other"),
      (here.last_tick - oldest) * 1000.0 / kTicksPerSecond, static_cast<double>(bytes - told_bytes_) * 8e-3 / seconds,
      peer_->stats().handovers, record_.late);
  told_bytes_ = bytes;
  told_at_ = now;
}

Micros CrowdLoop::next_due() const {
  const Micros due = peer_->next_due();
  return left_at_ ? std::min(due, *left_at_ + in_micros(options_.linger)) : due;
}

void CrowdLoop::stop(const std::string& signal, Micros now) {
  if (left_at_) return;  // its region may be over already, while others linger
  if (!peer_->playing()) {
    end(shell::kExitFailure, signal + " before it came into the crowd");
  } else {
    leave(signal, now);
  }
}

std::string CrowdLoop::summary_text() const {
  return summary({options_, record_, *peer_, socket_->stats(), local_, exit_code_, reason_});
}

}  // namespace padr::peer
