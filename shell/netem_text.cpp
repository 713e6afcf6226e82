#include "shell/netem_text.h"

#include <algorithm>
#include <array>
#include <set>

#include "common/model/user_error.h"
#include "shell/netem_words.h"

namespace padr::shell {

namespace {

using link::Distribution;
using link::Nanos;
using link::NetemSpec;

using words::Word;

/// Recursive descent over words. Rules that need the whole line (reorder needs a delay, ...) are checked at its end,
/// because tc takes the options in any order.
class Parser {
 public:
  Parser(std::string_view text, std::vector<std::string>* warnings, const ReadFile& read)
      : words_(words::split(text)), warnings_(warnings), read_(read) {}

  NetemSpec parse() {
    while (next_ < words_.size()) option();
    check_reorder();
    check_distribution();
    check_delay();
    check_trace();
    return spec_;
  }

 private:
  struct Option {
    std::string_view name;
    void (Parser::*read)(const Word& keyword);
  };

  // In tc's order, which decides what a prefix means: d is delay, l is limit, r is reorder.
  static constexpr std::array<Option, 15> options() {
    return {{{"limit", &Parser::limit},
             {"latency", &Parser::delay},
             {"delay", &Parser::delay},
             {"loss", &Parser::loss},
             {"drop", &Parser::loss},
             {"ecn", &Parser::ecn},
             {"reorder", &Parser::reorder},
             {"corrupt", &Parser::corrupt},
             {"gap", &Parser::gap},
             {"duplicate", &Parser::duplicate},
             {"distribution", &Parser::distribution},
             {"rate", &Parser::rate},
             {"slot", &Parser::slot},
             {"trace", &Parser::trace},
             {"seed", &Parser::seed}}};
  }

  void option() {
    const Word& keyword = words_[next_++];
    refuse_unit(keyword);
    for (const Option& option : options()) {
      if (!option.name.starts_with(keyword.text)) continue;
      const std::string_view canonical = option.name == "latency" ? "delay" : option.name;
      if (!seen_.insert(canonical).second) warn(keyword, "given twice; this one counts");
      (this->*option.read)(keyword);
      return;
    }
    if (keyword.text == "packets" || keyword.text == "bytes") {
      words::fail(keyword, "only allowed right after slot and its times, packets before bytes");
    }
    words::fail(
        keyword,
        "unknown; allowed here: limit, delay, distribution, loss, corrupt, duplicate, reorder, gap, rate, slot, "
        "trace, seed");
  }

  void refuse_unit(const Word& keyword) const {
    static constexpr std::array<std::string_view, 8> kUnits{"ms", "us", "ns", "sec", "%", "kbit", "mbit", "gbit"};
    const bool after_number = next_ > 1 && words::looks_like_number(words_[next_ - 2]);
    // Where words follow, "s" is short for slot, as in tc.
    const bool is_unit = std::find(kUnits.begin(), kUnits.end(), keyword.text) != kUnits.end() ||
                         (keyword.text == "s" && next_ == words_.size());
    if (after_number && is_unit) words::fail(keyword, "is a unit; write it right behind its number, without a blank");
  }

  // ---- words

  void warn(const Word& word, const std::string& message) {
    if (warnings_ != nullptr) warnings_->push_back(words::describe(word) + ": " + message);
  }

  const Word& need(const Word& keyword, std::string_view what) {
    if (next_ == words_.size()) words::fail(keyword, "is followed by nothing; " + std::string(what) + " must follow");
    return words_[next_++];
  }

  bool number_follows() const { return next_ < words_.size() && words::looks_like_number(words_[next_]); }
  bool signed_number_follows() const { return next_ < words_.size() && words::looks_like_signed_number(words_[next_]); }

  /// tc compares what follows slot by prefix too.
  bool take_if_prefix_of(std::string_view name) {
    if (next_ == words_.size() || !name.starts_with(words_[next_].text)) return false;
    ++next_;
    return true;
  }

  Nanos time(const Word& word, std::string_view what) {
    bool bare = false;
    const Nanos value = words::duration(word, what, &bare);
    if (bare && value != 0) {
      const std::string number(word.text);
      warn(word, "a bare number is microseconds, as in tc; write " + number + "us, or " + number +
                     "ms if milliseconds are meant");
    }
    return value;
  }

  /// `into` stays as it is if no number follows.
  void percent_if_any(link::Chance& into, std::string_view what) {
    if (number_follows()) into = words::percent(words_[next_++], what);
  }

  link::Knob knob(const Word& keyword, std::string_view what) {
    link::Knob knob;
    knob.chance = words::percent(need(keyword, "a percentage"), what);
    percent_if_any(knob.correlation, "correlation");
    if (knob.chance == 0) knob = {};  // one way to say never
    return knob;
  }

  void warn_of_correlation(const link::Knob& knob, const std::string& what, const std::string& otherwise = "") {
    if (knob.correlation == 0 || knob.chance == link::kAlways) return;
    warn(words_[next_ - 1],
         "correlated " + what + " does not keep its mean (5% 25%, for example, comes out as 0.2%)" + otherwise);
  }

  // ---- options

  void limit(const Word& keyword) {
    spec_.limit = words::size(need(keyword, "a number of packets"), "number of packets");
    if (spec_.limit == 0) warn(keyword, "limit 0 drops every packet");
  }

  void delay(const Word& keyword) {
    delay_keyword_ = keyword;
    link::DelaySpec& delay = spec_.delay;
    delay.jitter = 0;
    delay.correlation = 0;
    delay.mean = time(need(keyword, "a TIME"), "TIME");
    if (!number_follows()) return;
    const Word& jitter = words_[next_++];
    delay.jitter = time(jitter, "JITTER");
    if (delay.jitter > link::kMaxJitter) {
      warn(jitter, "cut to 2.147483647s, as the kernel does");
      delay.jitter = link::kMaxJitter;
    }
    if (!number_follows()) return;
    const Word& correlation = words_[next_++];
    delay.correlation = words::percent(correlation, "correlation");
    if (delay.jitter == 0) delay.correlation = 0;
    if (delay.correlation != 0) {
      warn(correlation, "netem's correlation of delays hardly has an effect; delays stay close to independent");
    }
  }

  void loss(const Word& keyword) {
    if (loss_seen_) words::fail(keyword, "a second loss; one loss model is allowed");
    loss_seen_ = true;
    const Word& model = need(keyword, "a percentage, or random, state or gemodel");
    if (words::looks_like_number(model)) {
      --next_;
      random_loss(keyword);
    } else if (model.text == "random") {
      random_loss(model);
    } else if (model.text == "state") {
      state_loss(model);
    } else if (model.text == "gemodel") {
      gemodel_loss(model);
    } else {
      words::fail(model, "not a loss model; allowed: a percentage, random, state, gemodel (in full)");
    }
  }

  void random_loss(const Word& keyword) {
    const link::Knob k = knob(keyword, "percentage");
    warn_of_correlation(k, "random loss", "; for bursts use loss gemodel P R");
    spec_.loss = k;
  }

  void state_loss(const Word& keyword) {
    link::FourStateLoss s;
    s.p13 = words::percent(need(keyword, "P13, a percentage"), "P13");
    s.p31 = link::kAlways - s.p13;
    s.p23 = link::kAlways;
    percent_if_any(s.p31, "P31");
    percent_if_any(s.p32, "P32");
    percent_if_any(s.p23, "P23");
    percent_if_any(s.p14, "P14");
    if (s.p13 > link::kAlways - s.p14) words::fail(keyword, "P13 + P14 must not be more than 100%");
    if (s.p31 > link::kAlways - s.p32) words::fail(keyword, "P31 + P32 must not be more than 100%");
    spec_.loss = s;
  }

  void gemodel_loss(const Word& keyword) {
    link::GilbertElliottLoss g;
    g.p = words::percent(need(keyword, "P, a percentage"), "P");
    g.r = link::kAlways - g.p;
    g.lose_bad = link::kAlways;
    percent_if_any(g.r, "R");
    percent_if_any(g.lose_bad, "1-H");
    percent_if_any(g.lose_good, "1-K");
    spec_.loss = g;
  }

  void ecn(const Word& keyword) {
    words::fail(keyword,
                "not available: datagrams are shaped as payloads, which carry no ECN bits; leave it out to lose "
                "packets instead of marking them");
  }

  void corrupt(const Word& keyword) {
    spec_.corrupt = knob(keyword, "percentage");
    warn_of_correlation(spec_.corrupt, "corruption");
  }
  void duplicate(const Word& keyword) {
    spec_.duplicate = knob(keyword, "percentage");
    warn_of_correlation(spec_.duplicate, "duplication");
  }
  void reorder(const Word& keyword) {
    reorder_keyword_ = keyword;
    spec_.reorder = knob(keyword, "percentage");
    warn_of_correlation(spec_.reorder, "reordering");
  }

  void gap(const Word& keyword) {
    gap_keyword_ = keyword;
    spec_.gap = static_cast<std::uint32_t>(words::integer(need(keyword, "a number of packets"), "gap", 0, 4294967295));
  }

  void distribution(const Word& keyword) {
    distribution_keyword_ = keyword;
    spec_.delay.distribution = words::distribution(need(keyword, "uniform, normal, pareto or paretonormal"));
  }

  void rate(const Word& keyword) {
    link::RateSpec& rate = spec_.rate;
    rate = {};
    const Word& value = need(keyword, "a RATE, such as 1mbit");
    bool bytes = false;
    rate.bits_per_second = words::rate(value, &bytes);
    if (bytes) warn(value, "bps is BYTES per second, as in tc; bit is bits per second");
    if (signed_number_follows()) {
      rate.overhead = static_cast<std::int32_t>(
          words::integer(words_[next_++], "OVERHEAD", -link::kMaxOverhead, link::kMaxOverhead));
    }
    if (number_follows()) {
      rate.cell = static_cast<std::uint32_t>(words::integer(words_[next_++], "CELL", 0, link::kMaxOverhead));
    }
    if (signed_number_follows()) {
      rate.cell_overhead = static_cast<std::int32_t>(
          words::integer(words_[next_++], "CELLOVERHEAD", -link::kMaxOverhead, link::kMaxOverhead));
    }
    if (rate.cell == 0 && rate.cell_overhead != 0) {
      warn(words_[next_ - 1], "CELLOVERHEAD without a CELL has no effect");
      rate.cell_overhead = 0;
    }
    if (rate.bits_per_second == 0) rate = {};
  }

  void slot(const Word& keyword) {
    link::SlotSpec& slot = spec_.slot;
    slot = {};
    const Word& first = need(keyword, "a TIME, or distribution");
    if (words::looks_like_number(first)) {
      slot.min = slot.max = time(first, "TIME");
      if (number_follows()) {
        const Word& max = words_[next_++];
        slot.max = time(max, "TIME");
        if (slot.max < slot.min) words::fail(max, "MAX must not be less than MIN");
      }
      slot.on = slot.max != 0;  // netem takes `slot 0` for no slots
    } else if (first.text == "distribution") {
      slot_distribution(first);
    } else {
      words::fail(first, "not a slot; allowed: MIN [MAX], or distribution NAME DELAY JITTER");
    }
    if (take_if_prefix_of("packets")) {
      slot.packets = static_cast<std::uint32_t>(
          words::integer(need(words_[next_ - 1], "a number of packets"), "number of packets", 0, 2147483647));
    }
    if (take_if_prefix_of("bytes"))
      slot.bytes = words::size(need(words_[next_ - 1], "a number of bytes"), "number of bytes");
    if (!slot.on) slot = {};
  }

  void slot_distribution(const Word& keyword) {
    link::SlotSpec& slot = spec_.slot;
    slot.on = true;
    slot.distribution = words::distribution(need(keyword, "uniform, normal, pareto or paretonormal"));
    slot.delay = time(need(keyword, "NAME DELAY JITTER"), "DELAY");
    const Word& jitter = need(keyword, "NAME DELAY JITTER");
    slot.jitter = time(jitter, "JITTER");
    if (slot.jitter == 0 || slot.jitter > link::kMaxJitter)
      words::fail(jitter, "JITTER must be from 1ns to 2.147483647s");
  }

  void trace(const Word& keyword) {
    trace_keyword_ = keyword;
    const Word& name = need(keyword, "a built-in link trace (" + link_trace_names() + ") or a file");
    try {
      spec_.trace = {load_link_trace(name.text, read_), std::string(name.text)};
    } catch (const UserError& e) {
      words::fail(name, e.what());
    }
    if (next_ < words_.size() && words_[next_].text == "random") {
      ++next_;
      spec_.trace.start.reset();
    } else if (number_follows()) {
      spec_.trace.start = time(words_[next_++], "START");
    }
  }

  void seed(const Word& keyword) { spec_.seed = words::seed(need(keyword, "a whole number")); }

  // ---- rules over the whole line

  void check_reorder() {
    if (spec_.reorder.chance == 0) {
      if (spec_.gap > 0) words::fail(gap_keyword_, "gap needs a reorder chance above 0%");
      return;
    }
    if (spec_.delay.mean == 0) {
      words::fail(reorder_keyword_, "reorder needs a delay above 0: packets overtake those that are delayed");
    }
    if (spec_.gap == 0) spec_.gap = 1;
  }

  void check_distribution() {
    if (distribution_keyword_.number != 0 && (spec_.delay.mean == 0 || spec_.delay.jitter == 0)) {
      words::fail(distribution_keyword_, "distribution needs a delay with TIME and JITTER above 0");
    }
  }

  void check_delay() {
    if (spec_.delay.jitter > spec_.delay.mean && spec_.delay.distribution == Distribution::kUniform) {
      warn(delay_keyword_, "jitter above the delay: delays that come out below 0 are sent at once");
    }
  }

  void check_trace() {
    if (!spec_.trace.opportunities) return;
    const auto refuse = [this](const std::string& other) {
      words::fail(trace_keyword_, "not allowed with " + other + ": both say when packets leave; leave one of them out");
    };
    if (spec_.rate.bits_per_second != 0) refuse("rate");
    if (spec_.slot.on) refuse("slot");
  }

  std::vector<Word> words_;
  std::size_t next_ = 0;
  std::vector<std::string>* warnings_;
  const ReadFile& read_;
  NetemSpec spec_;
  std::set<std::string_view> seen_;
  bool loss_seen_ = false;
  Word delay_keyword_, reorder_keyword_, gap_keyword_, distribution_keyword_, trace_keyword_;
};

}  // namespace

NetemSpec parse_netem(std::string_view text, std::vector<std::string>* warnings, const ReadFile& read) {
  return Parser(text, warnings, read).parse();
}

}  // namespace padr::shell
