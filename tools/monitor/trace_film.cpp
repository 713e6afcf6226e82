#include "tools/monitor/trace_film.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <span>
#include <system_error>

#include "common/model/user_error.h"
#include "common/monitor/sampler.h"
#include "common/trace/fidelity.h"
#include "shell/files.h"
#include "shell/technique_text.h"
#include "shell/text.h"
#include "tools/lab/replay.h"

namespace padr::monitor {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> traces_in(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    std::error_code error;
    if (!fs::is_directory(path, error)) {
      files.push_back(path);
      continue;
    }
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(path, error))
      if (entry.path().extension() == ".trace") found.push_back(entry.path().string());
    if (error) throw UserError("--trace: cannot read '" + path + "': " + error.message());
    if (found.empty()) throw UserError("--trace: there is no *.trace in '" + path + "'");
    std::sort(found.begin(), found.end());
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

/// One incarnation of one peer, played again.
class Actor {
 public:
  Actor(std::uint64_t process, NamedTrace trace)
      : file_(std::move(trace.name)),
        bytes_(std::move(trace.bytes)),
        reader_(std::as_bytes(std::span(bytes_)), file_),
        origin_{process, reader_.header().session, reader_.header().peer, reader_.header().incarnation} {
    trace::TraceReader scan(std::as_bytes(std::span(bytes_)), file_);
    while (const auto event = scan.next()) {
      const auto* step = std::get_if<trace::Step>(&*event);
      if (step == nullptr) continue;
      if (begins_ < 0) begins_ = step->tick;
      if (first_ < 0 && !step->outside) first_ = step->tick;
      last_ = step->tick;
    }
  }

  const trace::Header& header() const { return reader_.header(); }
  const std::string& file() const { return file_; }
  Tick first() const { return first_; }
  Tick last() const { return last_; }

  void begin(int rate) {
    sampler_ = std::make_unique<Sampler>(rate, Detail::kAll);
    replay_ = std::make_unique<lab::Replay>(reader_, [this](const sync::FoldState& s, std::uint64_t hash) {
      if (!sampler_->due(s.tick)) return;
      Agreed a;
      Sampler::agreed(s, hash, header().technique.authority, a);
      agreed_.push_back(std::move(a));
    });
  }
  const Scene& scene() const { return replay_->scene(); }

  /// As far as the step to `tick`, and says to the session what there is to say.
  void advance(Tick tick, ObservedSession& session) {
    // The slot is an earlier incarnation's until then.
    if (tick < begins_) return;
    while (!over_ && at_ < tick) {
      const auto event = replay_->next();
      if (!event) {
        over_ = true;
        Event end{
            0,
            std::max(at_, Tick{0}),
            EventKind::kEnd,
            kNoEntity,
            kNoPeer,
            0,
            replay_->result().identical() ? "its trace ends" : "replays differently: " + replay_->result().difference};
        sampler_->say(std::move(end));
        tell_events(session);
        return;
      }
      if (const auto* retune = std::get_if<trace::Retune>(&*event)) retuned(retune->technique, session);
      if (const auto* push = std::get_if<trace::Push>(&*event))
        sampler_->say({0, at_, EventKind::kPush, push->body, origin_.slot, 0, ""});
      if (const auto* remark = std::get_if<trace::Remark>(&*event)) remarked(*remark);
      if (const auto* step = std::get_if<trace::Step>(&*event)) stepped(*step, session);
    }
  }

  /// What its player has at a tick up to which it has been advanced.
  trace::PlayerView view(Tick tick) {
    live_.clear();
    if (over_ || at_ != tick || outside_ || replay_->replica()->config().spectates) return {};
    const world::View& w = replay_->replica()->live().world();
    for (EntityId e = 0; e < w.entities(); ++e) live_.push_back(w.state(e));
    return {true, live_, target_};
  }
  PeerId slot() const { return origin_.slot; }

  /// Why it ended before its trace did; empty if it did not.
  std::string difference() const { return replay_->result().difference; }

 private:
  void tell(ObservedSession& session, Message message) {
    session.take({origin_, std::move(message)}, {}, FilmMaker::time_of(std::max(at_, Tick{0})));
  }

  void tell_events(ObservedSession& session) {
    auto events = sampler_->take_events();
    if (!events.empty()) tell(session, Events{std::move(events)});
  }

  void say_hello(const Technique& technique, ObservedSession& session) {
    const trace::Header& h = header();
    Hello hello;
    // The number of a version is not in it.
    hello.version = h.revision + " of " + h.program;
    hello.slots = h.slots;
    hello.scenario = h.scenario;
    hello.scenario_seed = h.scenario_seed;
    hello.scene_hash = h.scene_hash;
    hello.technique = shell::describe(technique);
    hello.netem = h.netem;
    hello.input = h.input;
    hello.rate = sampler_->rate();
    tell(session, hello);
  }

  void retuned(const Technique& technique, ObservedSession& session) {
    say_hello(technique, session);
    sampler_->say({0, at_, EventKind::kKnob, kNoEntity, origin_.slot, 0, shell::describe(technique)});
  }

  void remarked(const trace::Remark& r) {
    for (std::size_t k = 0; k < kEventKinds; ++k)
      if (kEventNames[k] == r.kind) sampler_->say({0, at_, static_cast<EventKind>(k), kNoEntity, r.peer, 0, r.text});
  }

  void stepped(const trace::Step& step, ObservedSession& session) {
    const bool first = at_ < 0;
    at_ = step.tick;
    target_ = step.target;
    outside_ = step.outside || step.leaving;
    // As padr-report counts: not while it waits for others.
    if (first_ >= 0 && at_ >= first_) {
      if (step.lateness > kMicrosPerSecond / kTicksPerSecond) ++late_;
      worst_ = std::max(worst_, step.lateness);
    }
    const node::Replica& replica = *replay_->replica();
    if (first) {
      say_hello(header().technique, session);
      sampler_->begin(replica, "");
      tell_events(session);
      return;
    }
    sampler_->observe(replica);
    for (const node::MemberChange& c : replay_->take_changes()) sampler_->observe(c);
    tell_events(session);
    for (Agreed& a : agreed_) tell(session, std::move(a));
    agreed_.clear();
    if (!sampler_->due(at_)) return;
    Frame frame;
    sampler_->frame(replica, step.target, frame);
    tell(session, std::move(frame));
    Status status = Sampler::status(replica);
    status.steps = static_cast<std::uint64_t>(std::max(0, at_ - first_));
    status.late_ticks = late_;
    status.worst_late_us = worst_;
    tell(session, std::move(status));
  }

  std::string file_;
  std::string bytes_;
  trace::TraceReader reader_;
  Origin origin_;
  Tick begins_ = -1;  ///< of its first step, which may be before it plays
  Tick first_ = -1;   ///< played
  Tick last_ = -1;
  std::unique_ptr<Sampler> sampler_;
  std::vector<Agreed> agreed_;  ///< confirmed since the last step
  std::unique_ptr<lab::Replay> replay_;
  Tick at_ = -1;
  Vec2 target_;  ///< m, of the last step
  bool outside_ = false;
  std::vector<BodyState> live_;  ///< for view
  std::uint64_t late_ = 0;
  Micros worst_ = 0;
  bool over_ = false;
};

using Cast = std::vector<std::unique_ptr<Actor>>;

/// Fidelity and physics-consistency-cost of all of them.
class Deeds {
 public:
  explicit Deeds(const Cast& actors)
      : actors_(actors), meter_(actors.front()->scene(), actors.front()->header().slots, slots_of(actors)) {}

  void tick(Tick t, ObservedSession& session) {
    views_.clear();
    for (const auto& a : actors_) views_.push_back(a->view(t));
    meter_.tick(t, views_);
    for (std::size_t i = 0; i < actors_.size(); ++i)
      if (views_[i].there)
        session.measured(actors_[i]->slot(), meter_.series(i).back().error_m(), meter_.pcc().series(i).back().cost_m);
  }

 private:
  static std::vector<PeerId> slots_of(const Cast& actors) {
    std::vector<PeerId> slots;
    for (const auto& a : actors) slots.push_back(a->slot());
    return slots;
  }

  const Cast& actors_;
  trace::FidelityMeter meter_;
  std::vector<trace::PlayerView> views_;
};

/// Throws UserError if they are not of one session.
Cast cast(std::vector<NamedTrace> traces) {
  Cast actors;
  for (NamedTrace& t : traces) actors.push_back(std::make_unique<Actor>(actors.size() + 1, std::move(t)));
  const trace::Header& one = actors.front()->header();
  for (const auto& a : actors) {
    const trace::Header& h = a->header();
    if (h.session != one.session || h.scene_hash != one.scene_hash || h.slots != one.slots)
      throw UserError("--trace: " + a->file() + " is of another session than " + actors.front()->file());
  }
  return actors;
}

}  // namespace

Film film_traces(const std::vector<std::string>& paths, const Note& note) {
  std::vector<NamedTrace> traces;
  for (const std::string& file : shell::without_empty(traces_in(paths), note))
    traces.push_back({file, lab::read_trace_file(file)});
  return film_traces(std::move(traces), note);
}

Film film_traces(std::vector<NamedTrace> traces, const Note& note) {
  const Cast actors = cast(std::move(traces));
  Tick first = -1;
  Tick last = -1;
  for (const auto& a : actors) {
    if (a->first() < 0) continue;
    first = first < 0 ? a->first() : std::min(first, a->first());
    last = std::max(last, a->last());
  }
  if (first < 0) throw UserError("--trace: nobody plays in " + actors.front()->file());
  const trace::Header& h = actors.front()->header();
  const Tick sample = sample_for(last - first, 4 * actors.size() + 1, static_cast<std::size_t>(h.entities()));
  for (const auto& a : actors) a->begin(kTicksPerSecond / sample);
  FilmMaker maker(std::make_unique<ObservedSession>(SessionKey{h.session, h.scene_hash}, actors.front()->scene(),
                                                    shell::valid_utf8(h.scenario), h.scenario_seed, h.slots, 0),
                  sample, last - first);
  Deeds deeds(actors);
  for (Tick t = first; t <= last; ++t) {
    for (const auto& a : actors) a->advance(t, maker.session());
    deeds.tick(t, maker.session());
    if (t % sample == 0) maker.take(t);
    if ((t - first + 1) % (20 * kTicksPerSecond) == 0)
      note("replayed " + std::to_string((t - first + 1) / kTicksPerSecond) + " of " +
           std::to_string((last - first) / kTicksPerSecond) + " s");
  }
  for (const auto& a : actors)
    if (!a->difference().empty()) note(a->file() + ": shown as far as it replays as recorded: " + a->difference());
  return maker.finish();
}

}  // namespace padr::monitor
