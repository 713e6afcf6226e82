#include "peer/health.h"

#include <filesystem>
#include <system_error>

#include "common/model/user_error.h"
#include "peer/status.h"
#include "shell/files.h"
#include "shell/json.h"
#include "shell/text.h"

namespace padr::peer {
namespace {

std::string to_json(const HealthState& s) {
  shell::Json j;
  j.begin_object().field("healthy", s.healthy).field("playing", s.playing);
  if (s.peer) {
    j.field("peer", *s.peer).field("present", s.present);
    j.field("confirmed_tick", s.confirmed).field("confirmed_hash", shell::hex(s.hash));
    j.field("confirmed_still_ms", s.still / 1000);
  }
  return j.end_object().text();
}

}  // namespace

Health::Health(const std::string& file, Log& log) : file_(shell::replaceable("--health", file)), log_(log) {
  const std::string why = write({});
  if (!why.empty()) throw UserError(why);
}

void Health::update(const Player& player, Micros now) {
  const HealthState s = state(player, now);
  if (now < next_) return;
  next_ = now + kPeriod;
  const std::string why = write(s);
  if (why != wrong_ && !why.empty()) log_.status->warn("{}; this is said once, until it is possible", why);
  wrong_ = why;
}

void Health::remove() {
  std::error_code ignored;  // whoever reads it sees that it gets old
  std::filesystem::remove(file_, ignored);
}

HealthState Health::state(const Player& player, Micros now) {
  HealthState s;
  s.playing = player.has_begun();
  if (!player.playing()) return s;
  const auto confirmed = player.confirmed();
  // Another incarnation may begin at an earlier tick than the one before has confirmed.
  if (player.incarnation() != incarnation_ || confirmed.tick > confirmed_) advanced_ = now;
  incarnation_ = player.incarnation();
  confirmed_ = confirmed.tick;
  s.peer = player.self();
  s.present = player.present();
  s.confirmed = confirmed.tick;
  s.hash = confirmed.hash;
  s.still = now - advanced_;
  s.healthy = s.playing && s.still < kPatience && confirmed.tick >= 0;
  return s;
}

std::string Health::write(const HealthState& s) const {
  try {
    shell::replace_text("--health", file_, to_json(s));
    return {};
  } catch (const std::exception& e) {
    return e.what();
  }
}

}  // namespace padr::peer
