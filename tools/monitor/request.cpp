#include "tools/monitor/request.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/model/technique.h"
#include "common/model/user_error.h"
#include "common/monitor/codec.h"
#include "shell/netem_flags.h"
#include "shell/technique_text.h"
#include "shell/text.h"

namespace padr::monitor {
namespace {

using nlohmann::json;

constexpr double kMostId = 9007199254740992.0;  // what a page's numbers hold exactly
constexpr double kFarthest = 1.0e6;             // m

/// Reads fields of one message. Throws UserError, one line that names the field.
class Fields {
 public:
  explicit Fields(const json& object) : object_(object) {}

  bool has(const char* name) const { return object_.contains(name); }

  std::string text(const char* name, std::size_t most) const {
    const json& v = at(name);
    if (!v.is_string()) fail(name, "is not a text");
    const auto& s = v.get_ref<const std::string&>();
    if (s.size() > most) fail(name, "is longer than " + std::to_string(most) + " bytes");
    if (std::any_of(s.begin(), s.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }))
      fail(name, "has control characters");
    return s;
  }
  bool truth(const char* name) const {
    const json& v = at(name);
    if (!v.is_boolean()) fail(name, "is neither true nor false");
    return v.get<bool>();
  }
  double number(const char* name, double low, double high) const { return number_of(name, at(name), low, high); }
  std::int64_t whole(const char* name, double low, double high) const {
    const json& given = at(name);
    const double v = given.is_number() ? given.get<double>() : std::nan("");
    if (!(v >= low && v <= high) || v != std::floor(v))
      fail(name, "is not a whole number from " + shell::fixed(low, 0) + " to " + shell::fixed(high, 0));
    return static_cast<std::int64_t>(v);
  }
  Vec2 pair(const char* name, double most) const {
    const json& v = at(name);
    if (!v.is_array() || v.size() != 2) fail(name, "is not a pair of numbers");
    return {static_cast<float>(number_of(name, v[0], -most, most)),
            static_cast<float>(number_of(name, v[1], -most, most))};
  }
  /// A slot, or kNoPeer for the word.
  PeerId peer(const char* name, const char* word) const {
    const json& v = at(name);
    if (word != nullptr && v.is_string() && v.get_ref<const std::string&>() == word) return kNoPeer;
    if (!v.is_number())
      fail(name, std::string("is no slot") + (word == nullptr ? "" : std::string(" and not \"") + word + '"'));
    return static_cast<PeerId>(whole(name, 0, kMaxPeers - 1));
  }
  const json& at(const char* name) const {
    const auto found = object_.find(name);
    if (found == object_.end()) fail(name, "is missing");
    return *found;
  }
  [[noreturn]] static void fail(const char* name, const std::string& what) {
    throw UserError(std::string(name) + ": " + what);
  }

 private:
  static double number_of(const char* name, const json& v, double low, double high) {
    const double n = v.is_number() ? v.get<double>() : std::nan("");
    if (!(n >= low && n <= high)) fail(name, "is not a number from " + plain(low) + " to " + plain(high));
    return n;
  }
  static std::string plain(double v) { return v == std::floor(v) ? shell::fixed(v, 0) : json(v).dump(); }
  const json& object_;
};

Request subscribe(const Fields& f) {
  Subscribe s;
  if (f.has("rate")) s.rate = static_cast<int>(f.whole("rate", 1, kTicksPerSecond));
  if (!f.has("views")) return s;
  const json& views = f.at("views");
  if (!views.is_array() || views.size() > kWhiches) Fields::fail("views", "is not a list of views");
  s.views = 0;
  for (const json& v : views) {
    const auto found = v.is_string()
                           ? std::find(kWhichNames.begin(), kWhichNames.end(), v.get_ref<const std::string&>())
                           : kWhichNames.end();
    if (found == kWhichNames.end())
      Fields::fail("views", "has something other than shown, live, predicted, confirmed, authority");
    s.views |= 1U << static_cast<unsigned>(found - kWhichNames.begin());
  }
  return s;
}

Request drive(const Fields& f) {
  Drive d;
  const PeerId peer = f.peer("peer", nullptr);
  if (f.has("release") && f.truth("release")) {
    d.kind = Drive::Kind::kRelease;
  } else if (f.has("target")) {
    d = {Drive::Kind::kPoint, f.pair("target", kFarthest)};
  } else {
    d = {Drive::Kind::kDirection, f.pair("direction", 1)};
  }
  return Command{peer, d};
}

Request knob(const Fields& f) {
  Knob k{f.text("name", 40), f.text("value", 100)};
  if (k.name == "technique") {
    technique_by_name(k.value);
    return Command{f.peer("peer", "all"), k};
  }
  for (const shell::Knob& known : shell::knobs()) {
    if (std::string_view(known.flag).substr(2) != k.name) continue;
    Technique t;
    known.set(t, k.value);
    return Command{f.peer("peer", "all"), k};
  }
  Fields::fail("name", "'" + k.name + "' is no knob");
}

Request netem(const Fields& f, std::string& doubt) {
  Netem n{f.peer("to", "all"), f.text("spec", kMostText)};
  std::vector<std::string> doubts;
  if (!n.spec.empty()) shell::parse_netem_field("spec", n.spec, &doubts);
  for (const std::string& d : doubts) doubt += (doubt.empty() ? "" : "; ") + d;
  return Command{f.peer("peer", "all"), n};
}

Request cut(const Fields& f) {
  const PeerId peer = f.peer("peer", nullptr);
  Cut c{f.peer("with", "all"), static_cast<float>(f.number("seconds", 0, double{kMostSeconds}))};
  if (f.has("ways")) {
    const auto found = std::find(kWaysNames.begin(), kWaysNames.end(), f.text("ways", 10));
    if (found == kWaysNames.end()) Fields::fail("ways", "is none of both, out, in");
    c.ways = static_cast<Ways>(found - kWaysNames.begin());
  }
  if (c.peer == peer) Fields::fail("with", "is the peer itself");
  return Command{peer, c};
}

Request push(const Fields& f) {
  const Push p{static_cast<EntityId>(f.whole("body", 0, kNoEntity - 1)), f.pair("velocity", double{kMostPush})};
  if (length(p.velocity) > kMostPush)
    Fields::fail("velocity", "is more than " + shell::fixed(double{kMostPush}, 0) + " m/s");
  return Command{f.peer("peer", "any"), p};
}

Request request_of(const std::string& type, const Fields& f, std::string& doubt) {
  if (type == "subscribe") return subscribe(f);
  if (type == "token") return GiveToken{f.text("token", 200)};
  if (type == "drive") return drive(f);
  if (type == "knob") return knob(f);
  if (type == "netem") return netem(f, doubt);
  if (type == "cut") return cut(f);
  if (type == "pause") return Command{f.peer("peer", "all"), Pause{f.truth("on") ? kMostSeconds : 0}};
  if (type == "push") return push(f);
  if (type == "play") return Play{true};
  if (type == "halt") return Play{false};
  if (type == "seek") return Seek{static_cast<Tick>(f.whole("tick", 0, 2e9))};
  if (type == "step") return StepBy{static_cast<Tick>(f.whole("ticks", -1e6, 1e6))};
  if (type == "speed") return Speed{f.number("speed", 0.05, 20)};
  Fields::fail("type", "'" + type + "' is not known");
}

}  // namespace

Asked read_request(std::string_view text) {
  Asked a;
  const json message = json::parse(text, nullptr, false);
  if (!message.is_object()) {
    a.wrong = "not a JSON object";
    return a;
  }
  try {
    const Fields f(message);
    if (f.has("id")) a.id = static_cast<std::uint64_t>(f.whole("id", 0, kMostId));
    a.about = f.text("type", 40);
    a.request = request_of(a.about, f, a.doubt);
  } catch (const UserError& e) {
    a.wrong = shell::valid_utf8(e.what());
  }
  return a;
}

}  // namespace padr::monitor
