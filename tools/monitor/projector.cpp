#include "tools/monitor/projector.h"

#include <algorithm>
#include <cmath>

#include "tools/monitor/prometheus.h"

namespace padr::monitor {
namespace {

constexpr Micros kTimelineEvery = kMicrosPerSecond / 10;

}  // namespace

Projector::Projector(const Options& options, std::string mode, std::string source, Film film, std::string sample)
    : PageServer(options, std::move(mode), std::move(source), std::move(sample)),
      film_(std::move(film)),
      screen_(film_),
      position_(film_.first()) {
  screen_.go_to(film_.first());
}

void Projector::put(Film film) {
  film_ = std::move(film);
  seek(film_.first());
  forget_shown();
  introduce_all();
}

void Projector::advance(Micros now) {
  set_now(now);
  const double passed = static_cast<double>(now - last_) / kMicrosPerSecond;
  last_ = now;
  if (empty()) return;
  if (playing_) {
    position_ = std::min<double>(film_.last(), position_ + passed * speed_ * kTicksPerSecond);
    screen_.go_to(static_cast<Tick>(position_));
    tell_table();
    if (position_ >= film_.last()) {
      halt();
      tell_timeline();
    } else if (now >= next_timeline_) {
      next_timeline_ = now + kTimelineEvery;
      tell_timeline();
    }
  }
  show(screen_);
}

void Projector::begin() {
  if (empty()) return;
  seek(film_.first());
  playing_ = true;
  tell_timeline();
}

void Projector::introduce(ViewerId viewer) {
  if (empty()) return;
  tell(viewer, film_.scene);
  tell(viewer, history_text(film_.series));
  const auto& events = film_.session->events();
  tell(viewer, events_text(std::vector<SessionEvent>(events.begin(), events.end())));
  if (const Film::Table* t = screen_.table()) {
    tell(viewer, t->peers);
    if (const std::string series = screen_.series(); !series.empty()) tell(viewer, series);
  }
  tell(viewer, timeline());
}

void Projector::act(ViewerId viewer, const Asked& asked) {
  if (empty()) return answer(viewer, asked, false, "the recording is still being read");
  if (const auto* p = std::get_if<Play>(&*asked.request)) {
    playing_ = p->on;
    if (!p->on) halt();
    if (p->on && position_ >= film_.last()) seek(film_.first());
  } else if (const auto* k = std::get_if<Seek>(&*asked.request)) {
    seek(k->tick);
  } else if (const auto* s = std::get_if<StepBy>(&*asked.request)) {
    playing_ = false;
    // To the next moment at least: between two nothing changes.
    const Tick by =
        s->ticks == 0 ? 0 : (s->ticks > 0 ? std::max(s->ticks, film_.sample) : std::min(s->ticks, -film_.sample));
    seek(static_cast<Tick>(position_) + by);
  } else if (const auto* v = std::get_if<Speed>(&*asked.request)) {
    speed_ = v->times;
  } else {
    return answer(viewer, asked, false, "this is a recording: nobody is there to do it");
  }
  answer(viewer, asked, true, "");
  tell_timeline();
}

void Projector::seek(Tick tick) {
  const Tick to = std::clamp(tick, film_.first(), film_.last());
  position_ = to;
  screen_.go_to(to);
  tell_table();
}

void Projector::halt() {
  playing_ = false;
  tell_series();
}

void Projector::tell_table() {
  const Film::Table* t = screen_.table();
  if (t == nullptr) return;
  const bool fresh = t != told_;
  told_ = t;
  if (fresh) tell_all(t->peers, true);
  if (fresh || !playing_) tell_series();
}

/// Where it stands, this is the last word on the moment.
void Projector::tell_series() {
  if (const std::string series = screen_.series(); !series.empty()) tell_all(series, playing_);
}

std::string Projector::timeline() const {
  return timeline_text({film_.first(), film_.last(), static_cast<Tick>(position_), playing_, speed_, film_.sample});
}

void Projector::tell_timeline() {
  tell_all(timeline());
}

std::string Projector::session_json() {
  const Film::Table* t = screen_.table();
  return session_text(greeting({}), film_.scene, t == nullptr ? "" : t->peers, screen_.series());
}

std::string Projector::metrics() {
  return metrics_text(nullptr, {}, web_stats(), now());
}

}  // namespace padr::monitor
