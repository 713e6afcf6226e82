#include "tools/monitor/words.h"
#include "tools/monitor/samples.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "common/model/technique.h"
#include "shell/json.h"
#include "shell/netem_flags.h"
#include "shell/revision.h"
#include "shell/technique_text.h"
#include "shell/text.h"

namespace padr::monitor {
namespace {

using shell::Json;

/// Rounded: nobody reads a float's last bits.
double rounded(double v, double per_unit = 1e4) {
  return std::round(v * per_unit) / per_unit;
}

double seconds(Tick t) {
  return rounded(static_cast<double>(t) / kTicksPerSecond);
}

void pair(Json& j, std::string_view name, Vec2 v) {
  j.key(name).begin_array().value(rounded(double{v.x})).value(rounded(double{v.y})).end_array();
}

template <typename Numbers>
void numbers(Json& j, std::string_view name, const Numbers& values) {
  j.key(name).begin_array();
  for (const auto v : values) j.value(rounded(static_cast<double>(v), 100));
  j.end_array();
}

void maybe(Json& j, std::string_view name, const std::optional<double>& v) {
  j.key(name);
  if (v) {
    j.value(rounded(*v));
  } else {
    j.null();
  }
}

Json message(std::string_view type) {
  Json j(Json::Layout::kOneLine);
  j.begin_object().field("type", type);
  return j;
}

void shape(Json& j, const BodyDef& b) {
  if (b.shape == ShapeKind::kCircle) {
    j.field("shape", "circle").field("radius", rounded(double{b.radius}));
  } else {
    j.field("shape", "box");
    pair(j, "half", b.half);
  }
  j.field("mass", rounded(double{b.mass}));
  pair(j, "position", b.position);
  j.field("angle", rounded(double{b.angle}));
}

std::string_view word(Agreement::Verdict v) {
  constexpr std::array<std::string_view, 4> kWords{"unknown", "identical", "apart", "differs"};
  return kWords[static_cast<std::size_t>(v)];
}

std::string_view word(PeerRecord::Presence p) {
  if (p == PeerRecord::Presence::kHere) return "here";
  return p == PeerRecord::Presence::kSilent ? "silent" : "gone";
}

std::string_view word(Detail d) {
  if (d == Detail::kShown) return "shown";
  return d == Detail::kLive ? "live" : "all";
}

/// "--threshold 0.8:0.3 ..." as an object.
void knobs(Json& j, std::string_view settings) {
  std::map<std::string, std::string> told{
      {"end-update", "on"}, {"proxy-update", "on"}, {"rest-state", "on"}, {"time-stamps", "off"}, {"budget", "off"}};
  while (true) {
    const auto flag = settings.find("--");
    if (flag == std::string_view::npos) break;
    settings.remove_prefix(flag + 2);
    const auto blank = settings.find(' ');
    if (blank == std::string_view::npos) break;
    const std::string name(settings.substr(0, blank));
    settings.remove_prefix(blank + 1);
    told[name] = settings.substr(0, settings.find(' '));
  }
  j.begin_object();
  for (const shell::Knob& k : shell::knobs()) {
    const auto found = told.find(std::string(std::string_view(k.flag).substr(2)));
    if (found != told.end()) j.field(found->first, found->second);
  }
  j.end_object();
}

void rates(Json& j, const std::optional<PeerRates>& known) {
  j.key("rates");
  if (!known) {
    j.null();
    return;
  }
  const PeerRates& r = *known;
  j.begin_object();
  numbers(j, "updates_per_s", r.updates_per_s);
  j.field("datagrams_per_s", rounded(r.datagrams_per_s, 100)).field("kbit_per_s", rounded(r.kbit_per_s, 100));
  j.field("replayed_per_tick", rounded(r.replayed_per_tick, 100)).end_object();
}

void links(Json& j, const PeerRecord& p) {
  j.key("links").begin_array();
  for (const auto& [to, l] : p.links) {
    if (!l.there) continue;
    j.begin_object().field("to", int{to});
    const auto delay = [&j, measured = l.measured](const char* name, float ms) {
      maybe(j, name, measured ? std::optional(double{ms}) : std::nullopt);
    };
    delay("delay_ms", l.delay_p50_ms);
    delay("delay_p95_ms", l.delay_p95_ms);
    delay("delay_least_ms", l.delay_least_ms);
    j.field("round_trip_ms", rounded(double{l.round_trip_ms}))
        .field("loss_percent", rounded(double{l.loss_in} * 100, 10))
        .field("loss_of", l.loss_of)
        .field("lost", l.lost_in)
        .field("judged", l.judged_in);
    maybe(j, "carries_kbit_s", l.carries_kbit_s > 0 ? std::optional(double{l.carries_kbit_s}) : std::nullopt);
    j.field("queue_ms", rounded(double{l.queue_ms}));
    j.field("carried_by", l.carrier == kNoPeer ? std::nullopt : std::optional(int{l.carrier}));
    j.field("netem", l.netem).key("cut");
    if (!l.cut_out && !l.cut_in)
      j.null();
    else
      j.value(kWaysNames[static_cast<std::size_t>(!l.cut_in ? Ways::kOut : !l.cut_out ? Ways::kIn : Ways::kBoth)]);
    j.end_object();
  }
  j.end_array();
}

/// Of whom it has not taken something, and why; who has left since, too.
void drops(Json& j, const PeerRecord& p) {
  j.key("drops").begin_array();
  for (const auto& [from, l] : p.links) {
    if (l.cut_offs == 0 && std::all_of(l.dropped.begin(), l.dropped.end(), [](std::uint64_t n) { return n == 0; }))
      continue;
    j.begin_object().field("from", int{from}).field("cut_off", l.cut_offs);
    j.key("by_reason").begin_object();
    for (std::size_t d = 1; d < sync::kDropReasons; ++d)
      if (l.dropped[d] > 0) j.field(sync::kDropNames[d], l.dropped[d]);
    j.end_object().end_object();
  }
  j.end_array();
}

void numbers_of(Json& j, const PeerRecord& p, Agreement::Verdict verdict) {
  j.key("confirmed");
  if (p.status && p.status->confirmed >= 0) {
    j.begin_object().field("tick", p.status->confirmed).field("hash", shell::hex(p.status->hash));
    j.field("state", word(verdict));
    maybe(j, "lag_ms", p.lag_ms());
    j.end_object();
  } else {
    j.null();
  }
  const Status s = p.status.value_or(Status{});
  j.field("hash_mismatches", s.hash_mismatches).field("late_ticks", s.late_ticks);
  j.field("lateness_ms", static_cast<double>(s.worst_late_us) * 1e-3)
      .field("own_error_m", rounded(double{s.own_error_m}))
      .field("price", rounded(double{s.price}));
  j.field("paused", s.paused);
}

void peer(Json& j, const PeerRecord& p, Agreement::Verdict verdict, std::string_view driven, Micros now) {
  j.begin_object().field("slot", int{p.origin.slot}).field("incarnation", p.origin.incarnation);
  j.field("state", word(p.presence(now))).field("heard_ms", (now - p.heard) / 1000);
  const Hello h = p.hello.value_or(Hello{});
  j.field("address", h.at.is_set() ? to_string(h.at) : "").field("version", h.version);
  j.field("technique", h.technique.substr(0, h.technique.find(' '))).field("settings", h.technique);
  j.key("knobs");
  knobs(j, h.technique);
  j.field("controllable", h.control).field("driven", driven).field("detail", word(h.detail)).field("input", h.input);
  j.field("tick", p.newest ? p.newest->tick : (p.status ? p.status->tick : 0));
  rates(j, p.current_rates(now));
  numbers_of(j, p, verdict);
  j.key("frames").begin_object().field("received", p.frames).field("lost", p.lost).end_object();
  links(j, p);
  drops(j, p);
  j.end_object();
}

void point(Json& j, const SeriesPoint& p) {
  j.begin_object().field("type", "series").field("tick", p.tick).field("time", seconds(p.tick));
  j.key("peers").begin_array();
  for (const PeerPoint& q : p.peers) {
    j.begin_object().field("slot", int{q.slot});
    if (const auto& i = q.inconsistency) {
      j.field("at_tick", i->tick).field("combined_m", rounded(double{i->combined()}));
      j.field("avatars_m", rounded(double{i->avatars_m})).field("bodies_m", rounded(double{i->bodies_m}));
      j.field("shown_m", rounded(double{i->shown_m}));
    } else {
      for (const char* name : {"at_tick", "combined_m", "avatars_m", "bodies_m", "shown_m"}) j.key(name).null();
    }
    for (const auto& [name, m] : {std::pair{"fidelity_m", q.fidelity_m}, {"pcc_m", q.pcc_m}}) {
      if (m)
        j.field(name, rounded(double{*m}));
      else
        j.key(name).null();
    }
    if (q.updates_per_s) {
      numbers(j, "updates_per_s", *q.updates_per_s);
      j.field("kbit_per_s", rounded(double{q.kbit_per_s}, 100));
    } else {
      j.key("updates_per_s").null().key("kbit_per_s").null();
    }
    maybe(j, "lag_ms", q.lag_ms);
    maybe(j, "threshold_m", q.threshold_m);
    j.key("delay_ms").begin_object();
    for (const auto& [to, ms] : q.delay_ms) j.field(std::to_string(to), rounded(double{ms}, 100));
    j.end_object().end_object();
  }
  j.end_array().end_object();
}

}  // namespace

std::string hello_text(const HelloWords& h) {
  Json j = message("hello");
  j.field("protocol", 1).field("version", shell::version()).field("revision", shell::revision());
  j.field("mode", h.mode)
      .field("control", h.control)
      .field("needs_token", h.needs_token)
      .field("source", h.source)
      .field("sample", h.sample);
  j.key("samples").begin_array();
  for (const Sample& s : samples()) {
    j.begin_object().field("name", s.name).field("title", s.title);
    j.field("about", s.about).field("live", s.live).end_object();
  }
  j.end_array().key("knobs").begin_array();
  for (const shell::Knob& k : shell::knobs())
    j.begin_object().field("name", k.flag + 2).field("type", k.type).field("help", k.help).end_object();
  j.end_array().key("techniques").begin_array();
  for (const std::string_view name : technique_names()) j.value(name);
  j.end_array().key("causes").begin_array();
  for (const std::string_view name : sync::kCauseNames) j.value(name);
  j.end_array().field("netem_help", shell::netem_help()).end_object();
  return j.text();
}

std::string scene_text(const ObservedSession& s) {
  const Scene& scene = s.scene();
  Json j = message("scene");
  j.field("session", s.key().number).field("name", scene.name).field("title", scene.title);
  j.field("scenario", s.scenario())
      .field("seed", s.seed())
      .field("slots", s.slots())
      .field("tick_rate", kTicksPerSecond);
  pair(j, "lower", scene.lower);
  pair(j, "upper", scene.upper);
  pair(j, "gravity", scene.gravity);
  j.key("avatar").begin_object().field("radius", rounded(double{scene.avatar.radius}));
  j.field("mass", rounded(double{scene.avatar.mass}))
      .field("max_speed", rounded(double{scene.avatar.max_speed}))
      .end_object();
  j.key("spawns").begin_array();
  for (const Vec2 v : scene.avatar.spawns)
    j.begin_array().value(rounded(double{v.x})).value(rounded(double{v.y})).end_array();
  j.end_array().key("bodies").begin_array();
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    j.begin_object().field("id", b);
    shape(j, scene.bodies[b]);
    j.end_object();
  }
  j.end_array().key("statics").begin_array();
  for (const BodyDef& b : scene.statics) {
    j.begin_object();
    shape(j, b);
    j.end_object();
  }
  j.end_array().end_object();
  return j.text();
}

std::string peers_text(const ObservedSession& s, int other_sessions, const Driven& driven, Micros now) {
  Json j = message("peers");
  j.field("session", s.key().number).field("tick", s.tick()).field("time", seconds(s.tick()));
  j.field("other_sessions", other_sessions);
  const Agreement& a = s.agreement();
  j.key("agreement").begin_object().field("state", word(a.all())).field("compared", a.compared());
  j.field("tick", a.newest()).key("first_difference");
  if (a.first_difference()) {
    j.value(*a.first_difference());
  } else {
    j.null();
  }
  j.end_object().key("peers").begin_array();
  for (const PeerRecord* p : s.peers()) peer(j, *p, a.of(p->origin.slot), driven(p->origin.slot), now);
  j.end_array().end_object();
  return j.text();
}

std::string series_text(const SeriesPoint& p) {
  Json j(Json::Layout::kOneLine);
  point(j, p);
  return j.text();
}

std::string history_text(const std::deque<SeriesPoint>& points) {
  Json j = message("history");
  j.key("points").begin_array();
  const std::size_t every = (points.size() + kHistoryPoints - 1) / kHistoryPoints;
  // Counted from the end, so that the newest is always there.
  for (std::size_t i = 0; i < points.size(); ++i)
    if ((points.size() - 1 - i) % every == 0) point(j, points[i]);
  j.end_array().end_object();
  return j.text();
}

std::string events_text(std::span<const SessionEvent> events) {
  Json j = message("events");
  j.key("events").begin_array();
  for (const SessionEvent& e : events) {
    const auto kind = static_cast<std::size_t>(e.event.kind);
    j.begin_object().field("tick", e.event.tick).field("time", seconds(e.event.tick));
    j.key("peer");
    if (e.by == kNoPeer) {
      j.null();
    } else {
      j.value(int{e.by});
    }
    j.field("kind", kind < kEventKinds ? kEventNames[kind] : "unknown").key("entity");
    if (e.event.entity == kNoEntity) {
      j.null();
    } else {
      j.value(e.event.entity);
    }
    j.key("other");
    if (e.event.peer == kNoPeer) {
      j.null();
    } else {
      j.value(int{e.event.peer});
    }
    j.field("text", e.event.text).end_object();
  }
  j.end_array().end_object();
  return j.text();
}

std::string timeline_text(const TimelineWords& t) {
  Json j = message("timeline");
  j.field("first", t.first).field("last", t.last).field("tick", t.tick).field("playing", t.playing);
  j.field("speed", t.speed).field("sample", t.sample).end_object();
  return j.text();
}

std::string answer_text(std::optional<std::uint64_t> id, bool ok, std::string_view text, std::string_view about) {
  Json j = message("answer");
  j.key("id");
  if (id) {
    j.value(*id);
  } else {
    j.null();
  }
  j.field("ok", ok).field("text", text).field("about", about).end_object();
  return j.text();
}

std::string taken_text(PeerId slot) {
  Json j = message("taken");
  j.field("peer", int{slot}).end_object();
  return j.text();
}

std::string session_text(std::string_view hello, std::string_view scene, std::string_view peers,
                         std::string_view series) {
  Json j(Json::Layout::kOneLine);
  j.begin_object();
  for (const auto& [name, text] : {std::pair{"hello", hello}, {"scene", scene}, {"peers", peers}, {"series", series}}) {
    j.key(name);
    if (text.empty()) {
      j.null();
    } else {
      j.document(text);
    }
  }
  j.end_object();
  return j.text() + "\n";
}

}  // namespace padr::monitor
