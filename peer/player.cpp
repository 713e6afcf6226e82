#include "peer/player.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "shell/netem_flags.h"
#include "shell/session_words.h"
#include "shell/technique_text.h"
#include "shell/text.h"

namespace padr::peer {
namespace {

constexpr Micros kTickLength = kMicrosPerSecond / kTicksPerSecond;
/// The same newcomer is said to be refused for the same reason so often at most.
constexpr Micros kRefusedAgain = 10 * kMicrosPerSecond;

Totals operator+(const Totals& a, const Totals& b) {
  Totals sum = a;
  node::ReplicaStats& s = sum.replica;
  for (std::size_t c = 0; c < s.updates_by_cause.size(); ++c) s.updates_by_cause[c] += b.replica.updates_by_cause[c];
  for (std::size_t d = 0; d < s.dropped.size(); ++d) s.dropped[d] += b.replica.dropped[d];
  s.bundles += b.replica.bundles;
  s.datagrams_sent += b.replica.datagrams_sent;
  s.wire_bytes_sent += b.replica.wire_bytes_sent;
  s.repeats += b.replica.repeats;
  s.datagrams_received += b.replica.datagrams_received;
  s.hash_checks += b.replica.hash_checks;
  s.hash_mismatches += b.replica.hash_mismatches;
  if (s.first_mismatch < 0) s.first_mismatch = b.replica.first_mismatch;
  sum.replayed_steps += b.replayed_steps;
  sum.ticks += b.ticks;
  return sum;
}

/// Of a meeting point, bytes/s; at 64 kbit/s each, those of 125 players.
constexpr double kMeetingPointCarries = 1e6;

}  // namespace

Player::Player(const Options& options, const node::SessionConfig& session, std::optional<node::ChannelConfig> channels,
               Log& log, Recordings& recordings, Watcher* watcher, Micros now)
    : options_(options),
      log_(log),
      recordings_(recordings),
      watcher_(watcher),
      technique_(options.technique),
      participant_(options.scenario.scene, config(session, std::move(channels)), now),
      last_input_(std::numeric_limits<Tick>::max()) {}

node::ParticipantConfig Player::config(const node::SessionConfig& session,
                                       std::optional<node::ChannelConfig> channels) {
  node::ParticipantConfig c;
  c.session = session;
  c.channels = std::move(channels);
  c.replica.technique = options_.technique;
  c.linger = in_micros(options_.linger);
  if (options_.meeting_point) c.carries = kMeetingPointCarries;
  c.recording = [this](int incarnation) {
    history_.begin(incarnation);
    return recordings_.of(incarnation);
  };
  c.on_confirmed = [this](int incarnation, const sync::FoldState& s, std::uint64_t hash) {
    history_.confirm(incarnation, s.tick, hash);
    if (watcher_ != nullptr) watcher_->confirmed(incarnation, s, hash);
  };
  return c;
}

void Player::receive(const Endpoint& from, std::span<const std::byte> datagram, Micros now) {
  if (!paused()) {
    participant_.receive(from, datagram, now);
  } else if (still_.waiting.size() < Standstill::kRoom) {
    still_.waiting.push_back({from, {datagram.begin(), datagram.end()}});
  }
}

void Player::retune(const Technique& technique) {
  technique_ = technique;
  participant_.retune(technique);
}

void Player::pause(Micros until, Micros now) {
  still_.until = until;
  if (until <= now) go_on(now);
}

void Player::go_on(Micros now) {
  still_.until = -1;
  catching_up_ = true;
  for (const Standstill::Datagram& d : std::exchange(still_.waiting, {})) participant_.receive(d.from, d.bytes, now);
}

void Player::advance(Micros now) {
  if (paused() && now < still_.until) return;
  if (paused()) go_on(now);
  if (now >= participant_.next_due()) participant_.advance(now);
  while (playing()) {
    if (incarnation() != known_incarnation_) begin_incarnation();
    if (!participant_.step_due(now) || done(now)) break;
    step(now);
  }
  tell(now);
}

Micros Player::next_due() const {
  if (paused()) return still_.until;
  const Micros due = participant_.next_due();
  if (!playing()) return due;
  // Upkeep that comes due within a tick of the next step can wait for it: one wake-up instead of two.
  const Micros step = participant_.next_step();
  return due > step - kTickLength ? step : due;
}

void Player::begin_incarnation() {
  const node::Session& s = session();
  const Tick next = replica().now() + 1;
  past_ = past_ + present_;
  present_ = {};
  known_incarnation_ = incarnation();
  history_.play(known_incarnation_, self(), replica().config().incarnation,
                known_incarnation_ == 0 && next == 1 ? 0 : next);
  if (watcher_ != nullptr) watcher_->begun(replica(), known_incarnation_);
  const std::string ours = "session " + fmt::format("{}", s.number());
  if (known_incarnation_ > 0) {
    log_.session->warn("{}: life {} begins at tick {}, as peer {}", ours, known_incarnation_ + 1, next, self());
    return;
  }
  const std::string input = options_.spectates ? "rest" : options_.input;
  input_ = shell::load_input(input, options_.scenario.scene, self(), options_.scenario.seed);
  const double round_trip_ms = static_cast<double>(s.round_trip()) / 1e3;
  waited_ = !replica().playing() || replica().config().incarnation == 0;
  if (replica().config().incarnation == 0) return;
  if (const int wanted = replica().start().wanted; wanted > present()) {
    log_.session->info("{}: waiting as peer {}, {} of {} are here, round trip {:.1f} ms", ours, self(), present(),
                       wanted, round_trip_ms);
  } else if (!waited_) {
    log_.session->info("{}: in as peer {}, with {}, at tick {}, round trip {:.1f} ms", ours, self(),
                       shell::counted(present() - 1, "other"), next, round_trip_ms);
    say_what_is_played();
  }
}

void Player::say_what_is_played() {
  log_.play->info("scenario {}, technique {}", options_.scenario.label, shell::describe(options_.technique));
  for (PeerId p = 0; p < session().slots(); ++p)
    if (p != self() && replica().seat(p).at.is_set())
      log_.session->info("peer {} is at {}", p, to_string(replica().seat(p).at));
}

// A path, and the time to play, begin where play does or, for whoever comes later, where this peer comes in.
void Player::follow_start(Micros now) {
  const sync::Start start = replica().start();
  if (start.wanted > 0 || first_tick_ >= 0) return;
  if (waited_) {
    waited_ = false;
    tell_events(now);  // before what follows from them, even if both come in one step
    log_.session->info("session {} of {} starts in {:.2f} s; this is peer {}", session().number(),
                       shell::counted(present(), "peer"),
                       std::max(0.0, static_cast<double>(start.at - replica().now()) / kTicksPerSecond), self());
    say_what_is_played();
  }
  if (!replica().playing()) return;
  first_tick_ = std::max(start.at, history_.incarnations().front().came);
  if (options_.duration > 0 && !leaving())
    last_input_ = first_tick_ + static_cast<Tick>(std::llround(options_.duration * kTicksPerSecond));
}

void Player::step(Micros now) {
  follow_start(now);
  watch_clock(now);
  if (!leaving() && replica().now() >= last_input_) leave("the time to play is over", true, now);
  const Tick of_input = has_begun() ? std::min(replica().now() + 1, last_input_) - first_tick_ : 0;
  const world::View& live = replica().live().world();
  const Vec2 target = steering_.target(input_->target(of_input), live, live.avatar(self()), now);
  const Micros lateness = now - participant_.next_step();
  participant_.step(target, now);
  present_.replica = replica().stats();
  if (channels() != nullptr) present_.replica.wire_bytes_sent += present_.replica.datagrams_sent * wire::kSealGrowth;
  present_.replayed_steps = replica().agreed().replayed_steps();
  ++present_.ticks;
  watch_hashes();
  if (watcher_ != nullptr) watcher_->stepped({replica(), target, steering_.driven(), lateness});
}

void Player::watch_clock(Micros now) {
  const Micros lateness = now - participant_.next_step();
  if (catching_up_ && lateness > kTickLength) {
    stepped_at_ = now;
    return;
  }
  catching_up_ = false;
  if (!has_begun()) return;
  ticks_.lateness.add(lateness);
  if (lateness > kTickLength) ++ticks_.late;
  if (joined_at_ < 0) joined_at_ = now;
  const Micros stall = stepped_at_ < 0 ? 0 : now - stepped_at_ - kTickLength;
  ticks_.longest_stall = std::max(ticks_.longest_stall, stall);
  if (stall > TickStats::kStall) ++ticks_.stalls;
  stepped_at_ = now;
}

void Player::watch_hashes() {
  if (mismatch_told_ || replica().stats().hash_mismatches == 0) return;
  mismatch_told_ = true;
  log_.play->error("CONFIRMED WORLDS DIFFER from tick {} on (told once, counted further)",
                   replica().stats().first_mismatch);
}

// Strangers may ask to join fifty times a second, and the log must not fill the disk. A newcomer asks a full session
// several times.
void Player::tell_events(Micros now) {
  for (const node::SessionEvent& e : participant_.take_events()) {
    const std::string words = shell::words_of(e);
    if (e.kind == node::SessionEvent::Kind::kRefused && !tells_refusal(words, now)) continue;
    log_.session->log(shell::is_problem(e) ? spdlog::level::warn : spdlog::level::info, "{}", words);
  }
  if (now - refused_at_ >= kRefusedAgain) refused_untold_ += std::exchange(refused_again_, 0);
  if (refused_untold_ == 0 || !refusals_.take(1, now)) return;
  log_.session->info("refused {} more", std::exchange(refused_untold_, 0));
}

bool Player::tells_refusal(const std::string& words, Micros now) {
  if (words == refused_ && now - refused_at_ < kRefusedAgain) {
    ++refused_again_;
    return false;
  }
  if (refused_untold_ > 0 || !refusals_.take(1, now)) {
    ++refused_untold_;
    return false;
  }
  refused_ = words;
  refused_at_ = now;
  return true;
}

void Player::tell(Micros now) {
  tell_events(now);
  for (const node::MemberChange& c : participant_.take_changes()) {
    if (has_begun()) history_.change(c);
    if (watcher_ != nullptr) watcher_->changed(c);
  }
}

void Player::leave(const std::string& why, bool stay, Micros now) {
  log_.session->info("leaving at tick {}: {}", replica().now(), why);
  if (paused()) go_on(now);
  steering_.take({}, now);  // nobody drives it any more
  last_input_ = std::min(last_input_, replica().now());
  participant_.leave(now, stay);
}

int Player::present() const {
  return session().present();
}

Totals Player::totals() const {
  return past_ + present_;
}

}  // namespace padr::peer
