#include <array>
#include <charconv>
#include <cmath>
#include <span>
#include <string>
#include <variant>

#include "shell/netem_text.h"

namespace padr::shell {

namespace {

using link::Chance;
using link::Distribution;
using link::Nanos;

/// The largest unit that leaves a whole number.
std::string time_text(Nanos t) {
  if (t % link::kNanosPerSecond == 0) return std::to_string(t / link::kNanosPerSecond) + "s";
  if (t % 1'000'000 == 0) return std::to_string(t / 1'000'000) + "ms";
  if (t % link::kNanosPerMicro == 0) return std::to_string(t / link::kNanosPerMicro) + "us";
  return std::to_string(t) + "ns";
}

/// The shortest decimal that reads back as the same fixed-point value.
std::string percent_text(Chance c) {
  const double exact = 100.0 * c / link::kAlways;
  char buffer[32];
  for (int digits = 0; digits < 17; ++digits) {
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, exact, std::chars_format::fixed, digits).ptr;
    double back = 0;
    std::from_chars(buffer, end, back);
    if (std::llround(back / 100.0 * link::kAlways) == static_cast<long long>(c)) return std::string(buffer, end) + "%";
  }
  return std::to_string(exact) + "%";
}

std::string rate_text(std::uint64_t bits) {
  if (bits % 1'000'000'000 == 0) return std::to_string(bits / 1'000'000'000) + "gbit";
  if (bits % 1'000'000 == 0) return std::to_string(bits / 1'000'000) + "mbit";
  if (bits % 1'000 == 0) return std::to_string(bits / 1'000) + "kbit";
  return std::to_string(bits) + "bit";
}

/// A chance, and what is read where it is left out.
struct Omittable {
  Chance is;
  Chance otherwise;
};

class Writer {
 public:
  Writer& word(std::string_view w) {
    if (!text_.empty()) text_ += ' ';
    text_ += w;
    return *this;
  }
  Writer& percent(Chance c) { return word(percent_text(c)); }
  /// Up to the last one that has to be written.
  void optional(std::span<const Omittable> chances) {
    while (!chances.empty() && chances.back().is == chances.back().otherwise)
      chances = chances.first(chances.size() - 1);
    for (const Omittable& c : chances) percent(c.is);
  }
  Writer& time(Nanos t) { return word(time_text(t)); }
  Writer& number(std::int64_t n) { return word(std::to_string(n)); }

  void knob(std::string_view name, const link::Knob& k) {
    if (k.chance == 0) return;
    word(name).percent(k.chance);
    if (k.correlation != 0) percent(k.correlation);
  }

  void delay(const link::DelaySpec& d) {
    if (d.mean == 0 && d.jitter == 0) return;
    word("delay").time(d.mean);
    if (d.jitter == 0) return;
    time(d.jitter);
    if (d.correlation != 0) percent(d.correlation);
    if (d.distribution != Distribution::kUniform) word("distribution").word(to_string(d.distribution));
  }

  void loss(const link::NetemSpec& spec) {
    if (const auto* random = std::get_if<link::Knob>(&spec.loss)) {
      knob("loss", *random);
    } else if (const auto* s = std::get_if<link::FourStateLoss>(&spec.loss)) {
      word("loss").word("state").percent(s->p13);
      optional(std::array<Omittable, 4>{
          {{s->p31, link::kAlways - s->p13}, {s->p32, 0}, {s->p23, link::kAlways}, {s->p14, 0}}});
    } else if (const auto* g = std::get_if<link::GilbertElliottLoss>(&spec.loss)) {
      word("loss").word("gemodel").percent(g->p);
      optional(
          std::array<Omittable, 3>{{{g->r, link::kAlways - g->p}, {g->lose_bad, link::kAlways}, {g->lose_good, 0}}});
    }
  }

  void rate(const link::RateSpec& r) {
    if (r.bits_per_second == 0) return;
    word("rate").word(rate_text(r.bits_per_second));
    if (r.overhead == 0 && r.cell == 0 && r.cell_overhead == 0) return;
    number(r.overhead);
    if (r.cell == 0 && r.cell_overhead == 0) return;
    number(r.cell);
    if (r.cell_overhead != 0) number(r.cell_overhead);
  }

  void slot(const link::SlotSpec& s) {
    if (!s.on) return;
    word("slot");
    if (s.distribution) {
      word("distribution").word(to_string(*s.distribution)).time(s.delay).time(s.jitter);
    } else {
      time(s.min);
      if (s.max != s.min) time(s.max);
    }
    if (s.packets != 0) word("packets").number(s.packets);
    if (s.bytes != 0) word("bytes").number(s.bytes);
  }

  void trace(const link::TraceSpec& t) {
    if (!t.opportunities) return;
    word("trace").word(t.name);
    if (!t.start) {
      word("random");
    } else if (*t.start != 0) {
      time(*t.start);
    }
  }

  std::string text() && { return std::move(text_); }

 private:
  std::string text_;
};

}  // namespace

std::string_view to_string(Distribution distribution) {
  switch (distribution) {
    case Distribution::kUniform:
      return "uniform";
    case Distribution::kNormal:
      return "normal";
    case Distribution::kPareto:
      return "pareto";
    case Distribution::kParetoNormal:
      return "paretonormal";
  }
  return "uniform";
}

std::string to_string(const link::NetemSpec& spec) {
  Writer w;
  w.delay(spec.delay);
  w.loss(spec);
  w.knob("corrupt", spec.corrupt);
  w.knob("duplicate", spec.duplicate);
  w.knob("reorder", spec.reorder);
  if (spec.gap > 1) w.word("gap").number(spec.gap);
  w.rate(spec.rate);
  w.slot(spec.slot);
  w.trace(spec.trace);
  if (spec.limit != link::NetemSpec{}.limit) w.word("limit").number(spec.limit);
  if (spec.seed) w.word("seed").word(std::to_string(*spec.seed));
  return std::move(w).text();
}

}  // namespace padr::shell
