#include "tools/capture/rebuild_output.h"

#include <algorithm>

#include "shell/json.h"
#include "shell/text.h"
#include "tools/capture/names.h"
#include "tools/plot/gnuplot.h"
#include "tools/plot/palette.h"

namespace padr::capture {
namespace {

Tick last_tick(const Rebuilt& r) {
  return r.stretches.empty() ? -1 : r.stretches.back().to;
}

std::string begin_of(const Stretch& s) {
  return s.transfer ? "from the transfer of tick " + std::to_string(s.from) : "from tick 0";
}

}  // namespace

std::string rebuilt_text(const Setting& setting, const SessionLog& session_log, const Rebuilt& r,
                         std::uint64_t last_hash) {
  std::string out =
      "session " + std::to_string(session_log.session) + ": " + setting.label +
      (setting.authority ? ", dynamic authority" : ", avatar-only") +
      (setting.checked ? ", scene taken from the Join message" : ", scene as given: the capture has no Join message") +
      "\n";
  if (r.stretches.empty())
    return out +
           "nothing to begin with: neither how the session began (--wait-peers) nor a whole transfer is in the "
           "capture\n";
  for (const Stretch& s : r.stretches)
    out += begin_of(s) + " to tick " + std::to_string(s.to) + (s.gap ? "; GAP: " : "; it ends there: ") + s.why + "\n";
  out += std::to_string(r.agreeing()) + " of " + std::to_string(r.hashes.size()) + " hashes agree, to tick " +
         std::to_string(last_tick(r)) + " (confirmed world " + shell::hex(last_hash) + ")\n";
  for (const Rebuilt::Hash& h : r.hashes)
    if (!h.agrees)
      out += "DIFFERS: tick " + std::to_string(h.check.tick) + " by peer " + session_log.names()(h.check.by) +
             ", packet " + std::to_string(h.check.packet) + "\n";
  const auto add = [&out](std::uint64_t n, const std::string& what) {
    if (n > 0) out += std::to_string(n) + " " + what + "\n";
  };
  add(r.before, "hashes told of ticks before the transfer that it begins with");
  add(r.unreached, "hashes told of ticks that could not be rebuilt");
  add(r.given_up, "hashes told by peers of a side that was given up, not compared");
  add(r.unbelievable, "updates that no peer would believe");
  add(r.bad_transfers, "transfers that do not decode");
  return out;
}

std::string rebuilt_json(const Setting& setting, const SessionLog& session_log, const Rebuilt& r,
                         std::uint64_t last_hash, const std::vector<std::string>& command) {
  shell::Json j;
  j.begin_object().key("command").begin_array();
  for (const std::string& word : command) j.value(word);
  j.end_array().field("session", static_cast<int>(session_log.session)).field("scenario", setting.label);
  j.field("scene_checked", setting.checked).field("authority", setting.authority).field("slots", setting.slots);
  j.key("stretches").begin_array();
  for (const Stretch& s : r.stretches) {
    j.begin_object().field("from", s.from).field("begins_with", s.transfer ? "transfer" : "session");
    j.field("to", s.to).field("why", s.why).field("gap", s.gap).end_object();
  }
  j.end_array().field("last_tick", last_tick(r)).field("confirmed_hash", shell::hex(last_hash));
  j.field("hashes", r.hashes.size()).field("agreeing", r.agreeing()).field("before", r.before);
  j.field("unreached", r.unreached).field("given_up", r.given_up).field("unbelievable_updates", r.unbelievable);
  j.field("bad_transfers", r.bad_transfers).key("differing").begin_array();
  for (const Rebuilt::Hash& h : r.hashes) {
    if (h.agrees) continue;
    j.begin_object().field("tick", h.check.tick).field("peer", static_cast<int>(h.check.by.slot));
    j.field("incarnation", h.check.by.incarnation).field("packet", h.check.packet).end_object();
  }
  j.end_array().end_object();
  return j.text();
}

StatesCsv::StatesCsv(const std::string& file) : out_("--csv", file) {
  out_.write(std::string_view("tick,entity,x,y,angle,vx,vy,spin,awake,owner\n"));
}

void StatesCsv::add(const sync::FoldState& s) {
  const std::size_t bodies = s.authority.size();
  std::string rows;
  for (std::size_t e = 0; e < s.world.entities.size(); ++e) {
    if (e >= bodies && !s.avatars[e - bodies].present) continue;  // a spectator has none
    const world::Kinematics& k = s.world.entities[e];
    rows += std::to_string(s.tick) + "," + std::to_string(e);
    for (const float v : {k.position.x, k.position.y, k.angle, k.velocity.x, k.velocity.y, k.spin})
      rows += "," + plot::number(v, 9);
    rows += k.awake ? ",1," : ",0,";
    const PeerId owner = e < bodies ? s.authority[e].holder() : static_cast<PeerId>(e - bodies);
    if (owner != kNoPeer) rows += std::to_string(owner);
    rows += '\n';
  }
  out_.write(std::string_view(rows));
}

void WorldPicture::add(const sync::FoldState& s) {
  Moment m;
  m.tick = s.tick;
  for (const sync::AvatarModel& avatar : s.avatars) m.present.push_back(avatar.present);
  for (const world::Kinematics& k : s.world.entities) {
    m.positions.push_back(k.position);
    m.angles.push_back(k.angle);
  }
  for (const sync::Authority& a : s.authority) m.owners.push_back(a.holder());
  moments_.push_back(std::move(m));
}

plot::Frame WorldPicture::frame(const Setting& setting, std::size_t at) const {
  constexpr std::size_t kTrail = 5 * kTicksPerSecond;
  const Moment& now = moments_[at];
  const std::size_t bodies = setting.scene.bodies.size();
  plot::Frame f;
  for (std::size_t p = 0; p < now.present.size(); ++p) {
    if (!now.present[p]) continue;
    plot::Trail trail{.points = {}, .colour = plot::colour_by_number(p)};
    for (std::size_t i = at - std::min(at, kTrail); i <= at; ++i)
      if (moments_[i].present[p]) trail.points.push_back(moments_[i].positions[bodies + p]);
    f.trails.push_back(std::move(trail));
  }
  for (std::size_t b = 0; b < bodies; ++b) {
    const PeerId owner = now.owners[b];
    f.things.push_back({setting.scene.bodies[b], now.positions[b], now.angles[b], plot::Role::kBody, "",
                        owner == kNoPeer ? std::string_view() : plot::colour_by_number(owner)});
  }
  for (std::size_t p = 0; p < now.present.size(); ++p) {
    if (!now.present[p]) continue;
    BodyDef shape;
    shape.radius = setting.scene.avatar.radius;
    f.things.push_back(
        {shape, now.positions[bodies + p], 0, plot::Role::kAvatar, std::to_string(p), plot::colour_by_number(p)});
  }
  return f;
}

std::vector<plot::KeyEntry> WorldPicture::key() const {
  std::vector<plot::KeyEntry> entries{{plot::Role::kBody, "body of nobody"}};
  const auto seen = [this](std::size_t p) {
    return std::any_of(moments_.begin(), moments_.end(), [p](const Moment& m) { return m.present[p]; });
  };
  // Further ones have the same colours again; avatars tell their numbers.
  for (std::size_t p = 0; p < std::min(moments_.front().present.size(), plot::kColours); ++p)
    if (seen(p)) entries.push_back({plot::Role::kAvatar, "peer " + std::to_string(p), plot::colour_by_number(p)});
  return entries;
}

std::string WorldPicture::svg(const Setting& setting) const {
  if (moments_.empty()) return "";
  constexpr std::size_t kFrames = 4;
  plot::FilmStrip film;
  film.name = "rebuilt";
  film.title = "The confirmed world, rebuilt from packets: " + setting.label;
  film.scene = setting.scene;
  film.lower = setting.scene.lower;
  film.upper = setting.scene.upper;
  plot::FilmRow row{"Agreed by all peers", "avatars, their last 5 s and the bodies they own: in the peer's colour", {}};
  for (std::size_t i = 0; i < kFrames; ++i) {
    const std::size_t at = i * (moments_.size() - 1) / (kFrames - 1);
    film.columns.push_back(shell::fixed_or_dash(static_cast<double>(moments_[at].tick) / kTicksPerSecond, 1) + " s");
    row.frames.push_back(frame(setting, at));
  }
  film.rows.push_back(std::move(row));
  film.key = key();
  return plot::film_svg(film).text;
}

}  // namespace padr::capture
