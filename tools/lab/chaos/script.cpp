#include "tools/lab/chaos/script.h"

#include <fmt/printf.h>

#include <algorithm>
#include <array>

#include "common/model/rng.h"
#include "tools/lab/chaos/lies.h"

namespace padr::lab {
namespace {

using Kind = ChaosEvent::Kind;

constexpr std::array<const char*, 8> kNames{"start", "leave", "kill", "pause", "divide", "links", "fight", "cut"};

/// Of ten events: three starts, and one or two of each other kind.
constexpr std::array<Kind, 12> kDraw{Kind::kStart, Kind::kStart, Kind::kStart, Kind::kLeave,
                                     Kind::kKill,  Kind::kKill,  Kind::kPause, Kind::kDivide,
                                     Kind::kPause, Kind::kShape, Kind::kFight, Kind::kStart};

Micros micros(double s) {
  return static_cast<Micros>(s * 1e6);
}

}  // namespace

const std::vector<std::string>& chaos_links() {
  static const std::vector<std::string> kLinks{"delay 50ms 10ms loss 1%",
                                               "delay 5ms",
                                               "delay 60ms 20ms loss 5%",
                                               "delay 150ms 50ms loss 10%",
                                               "delay 30ms 30ms loss 20%",
                                               "delay 40ms loss gemodel 2% 20%",
                                               "delay 20ms 5ms duplicate 5% reorder 10%"};
  return kLinks;
}

ChaosScript make_script(std::uint64_t seed, Micros length, int most, int least) {
  Rng rng(derive_seed(seed, 0xC4A05));
  ChaosScript s;
  s.seed = seed;
  s.length = length;
  s.founders = least + static_cast<int>(rng.below(static_cast<std::uint32_t>(std::max(1, most / 2 - 1))));
  int there = s.founders;
  for (Micros at = micros(rng.uniform(3, 8)); at < length; at += micros(rng.uniform(1, 9))) {
    ChaosEvent e;
    e.kind = kDraw[rng.below(kDraw.size())];
    e.at = at;
    e.pick = rng.next_u64();
    const bool ends = e.kind == Kind::kLeave || e.kind == Kind::kKill;
    if (ends && there <= least) e.kind = Kind::kStart;
    if (e.kind == Kind::kStart && there >= most) e.kind = Kind::kFight;
    if (e.kind == Kind::kStart) ++there;
    if (e.kind == Kind::kLeave || e.kind == Kind::kKill) --there;
    if (e.kind == Kind::kPause) e.span = micros(rng.uniform(0.2, 8));
    if (e.kind == Kind::kDivide) e.span = micros(rng.uniform(0.5, 12));
    if (e.kind == Kind::kFight) e.span = micros(rng.uniform(2, 8));
    s.events.push_back(e);
  }
  return s;
}

ChaosScript with_cuts(ChaosScript s) {
  Rng rng(derive_seed(s.seed, 0xC075));
  for (Micros at = micros(rng.uniform(4, 8)); at < s.length; at += micros(rng.uniform(1, 12))) {
    ChaosEvent e;
    e.kind = Kind::kCut;
    e.pick = rng.next_u64();
    const bool flaps = rng.chance(0.3);
    Micros begin = at;
    for (int left = flaps ? 2 + static_cast<int>(rng.below(8)) : 1; left > 0; --left) {
      e.at = begin;
      e.span = micros(flaps ? rng.uniform(0.1, 2.5) : rng.uniform(0.5, 25));
      if (e.at < s.length) s.events.push_back(e);
      begin += e.span + micros(rng.uniform(0.05, 2));
    }
  }
  std::stable_sort(s.events.begin(), s.events.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
  return s;
}

ChaosScript with_liar(ChaosScript s, const Behaviour* how) {
  Rng rng(derive_seed(s.seed, 0x11A2));
  LyingScript liar;
  const auto all = behaviours();
  const Behaviour& drawn = all[rng.below(static_cast<std::uint32_t>(all.size()))];
  liar.how = how != nullptr ? how : &drawn;
  liar.pick = rng.next_u64();
  for (Micros at = micros(rng.uniform(4, 10)); at < s.length;) {
    const Micros to = std::min(s.length, at + micros(rng.uniform(3, 15)));
    liar.times.push_back({at, to});
    at = to + micros(rng.uniform(1, 10));
  }
  s.liar = std::move(liar);
  return s;
}

namespace {

std::string describe(const LyingScript& liar) {
  std::string text = "  one lies, behaviour " + std::string(liar.how->name) + ":";
  for (const LyingScript::Span& t : liar.times)
    text += fmt::sprintf(" %.2f to %.2f s", static_cast<double>(t.from) / 1e6, static_cast<double>(t.to) / 1e6);
  return text + "\n";
}

}  // namespace

std::string describe(const ChaosScript& s) {
  std::string text = "seed " + std::to_string(s.seed) + ", " + std::to_string(s.founders) + " peers begin\n";
  if (s.liar) text += describe(*s.liar);
  for (const ChaosEvent& e : s.events) {
    text += fmt::sprintf("  %7.2f s  %-7s", static_cast<double>(e.at) / 1e6,
                         e.suspends() ? "suspend" : kNames[static_cast<std::size_t>(e.kind)]);
    if (e.span > 0) text += fmt::sprintf(" for %.2f s", static_cast<double>(e.span) / 1e6);
    if (e.kind == Kind::kShape) text += " " + chaos_links()[e.pick % chaos_links().size()];
    text += "\n";
  }
  return text;
}

}  // namespace padr::lab
