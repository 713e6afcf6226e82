#include <algorithm>
#include <map>

#include "shell/json.h"
#include "shell/text.h"
#include "tools/capture/names.h"
#include "tools/capture/timeline.h"
#include "tools/plot/palette.h"
#include "tools/plot/svg.h"

namespace padr::capture {
namespace {

constexpr double kWidth = 1200;
constexpr double kLeft = 90;
constexpr double kRight = 20;
constexpr double kTop = 60;
constexpr double kPeerLane = 44;
constexpr double kBodyLane = 18;
constexpr std::string_view kGrey = "#888888";

double seconds(const Event& e, const std::vector<Event>& all) {
  return static_cast<double>(e.time_ns - all.front().time_ns) / 1e9;
}

Names names_of(const std::vector<Event>& events) {
  Names all;
  for (const Event& e : events)
    if (e.by.slot != kNoPeer && e.tick >= 0) all.add(e.by);
  return all;
}

std::string peer_of(const Event& e, const Names& names) {
  return e.by.slot == kNoPeer ? "" : names(e.by);
}

/// Somebody's authority over a body.
struct Hold {
  double from = 0;
  double to = 0;
  PeerId owner = kNoPeer;
};

std::map<int, std::vector<Hold>> holds_of(const std::vector<Event>& events, double end) {
  std::map<int, std::vector<Hold>> all;
  for (const Event& e : events) {
    if (e.entity < 0 || (e.what != "claim" && e.what != "release")) continue;
    std::vector<Hold>& holds = all[e.entity];
    const double at = seconds(e, events);
    if (!holds.empty()) holds.back().to = std::min(holds.back().to, at);
    if (e.what == "claim") holds.push_back({at, end, e.by.slot});
  }
  return all;
}

class Picture {
 public:
  Picture(std::uint16_t session, const std::vector<Event>& events)
      : events_(events),
        end_(std::max(seconds(events.back(), events), 1e-3)),
        holds_(holds_of(events, end_)),
        names_(names_of(events)) {
    for (const Event& e : events)
      if (e.by.slot != kNoPeer && e.tick >= 0) lanes_.emplace(e.by, 0.0);
    double y = kTop;
    for (auto& [who, at] : lanes_) {
      at = y;
      y += kPeerLane;
    }
    bodies_top_ = y + 24;
    height_ = bodies_top_ + kBodyLane * static_cast<double>(holds_.size()) + 50;
    title_ = "Session " + std::to_string(session) + ": what the packets tell";
  }

  std::string draw() {
    plot::Svg svg(kWidth, height_);
    svg.rect(0, 0, kWidth, height_, {.fill = "#FFFFFF"});
    svg.text(kLeft, 22, title_, {.size = 16, .bold = true});
    svg.text(
        kLeft, 42,
        "above the line: contact begins; below: it ends; on it: resends (grey); I comes, O leaves, X declared gone",
        {.size = 12, .colour = kGrey});
    axis(svg);
    for (const auto& [who, y] : lanes_) {
      svg.text(kLeft - 8, y + 20, "peer " + names_(who), {.size = 12, .anchor = plot::Anchor::kEnd});
      svg.line({{kLeft, y + 16}, {kWidth - kRight, y + 16}}, {.stroke = colour(who.slot), .width = 1});
    }
    for (const Event& e : events_) mark(svg, e);
    bodies(svg);
    return svg.text();
  }

 private:
  static std::string_view colour(PeerId slot) { return plot::colour_by_number(slot); }
  double x(double s) const { return kLeft + (kWidth - kLeft - kRight) * s / end_; }

  void axis(plot::Svg& svg) const {
    double step = 0.1;
    for (int i = 0; end_ / step > 12; ++i) step *= i % 3 == 1 ? 2.5 : 2.0;  // 0.1, 0.2, 0.5, 1, ...
    for (int i = 0; i * step <= end_; ++i) {
      svg.line({{x(i * step), kTop - 6}, {x(i * step), height_ - 34}}, {.stroke = "#E4E4E4"});
      svg.text(x(i * step), height_ - 18, shell::fixed_or_dash(i * step, step < 1 ? 1 : 0),
               {.size = 11, .anchor = plot::Anchor::kMiddle});
    }
    svg.text(kWidth - kRight, height_ - 4, "s since the first event", {.size = 11, .anchor = plot::Anchor::kEnd});
  }

  void mark(plot::Svg& svg, const Event& e) const {
    const auto lane = lanes_.find(e.by);
    if (lane == lanes_.end()) return;
    const double at = x(seconds(e, events_));
    const double y = lane->second + 16;
    const auto stroke = [&](double from, double to, std::string_view c) {
      svg.line({{at, y + from}, {at, y + to}}, {.stroke = c, .width = 1.5});
    };
    const auto letter = [&](const char* what) {
      svg.text(at, y - 5, what,
               {.size = 13, .colour = colour(e.by.slot), .anchor = plot::Anchor::kMiddle, .bold = true});
    };
    if (e.what == "contact_begin") stroke(-12, 0, colour(e.by.slot));
    if (e.what == "contact_end") stroke(0, 12, colour(e.by.slot));
    if (e.what == "resend") stroke(-3, 3, kGrey);
    if (e.what == "heard") letter("I");
    if (e.what == "leave") letter("O");
    if (e.what != "removal") return;
    for (const auto& [who, top] : lanes_)
      if (who.slot == e.other && e.detail.starts_with("incarnation " + std::to_string(who.incarnation) + " "))
        svg.text(at, top + 21, "X", {.size = 13, .colour = "#000000", .anchor = plot::Anchor::kMiddle, .bold = true});
  }

  void bodies(plot::Svg& svg) const {
    if (holds_.empty()) return;
    svg.text(kLeft, bodies_top_ - 6, "who owns which body", {.size = 12, .colour = kGrey});
    double y = bodies_top_;
    for (const auto& [body, holds] : holds_) {
      svg.text(kLeft - 8, y + 12, "body " + std::to_string(body), {.size = 11, .anchor = plot::Anchor::kEnd});
      for (const Hold& h : holds)
        svg.rect(x(h.from), y + 2, std::max(x(h.to) - x(h.from), 1.0), kBodyLane - 5, {.fill = colour(h.owner)});
      y += kBodyLane;
    }
  }

  const std::vector<Event>& events_;
  double end_;
  std::map<int, std::vector<Hold>> holds_;
  Names names_;
  std::map<Incarnation, double> lanes_;  ///< upper edge
  double bodies_top_ = 0;
  double height_ = 0;
  std::string title_;
};

}  // namespace

std::string timeline_csv(const std::vector<Event>& events) {
  std::string out = "time_s,tick,peer,event,entity,other,detail\n";
  const auto number = [](int v) { return v < 0 ? std::string() : std::to_string(v); };
  const Names names = names_of(events);
  for (const Event& e : events) {
    std::string detail = e.detail;
    std::replace(detail.begin(), detail.end(), '"', '\'');
    if (detail.find(',') != std::string::npos) detail = '"' + detail + '"';
    out += shell::fixed_or_dash(seconds(e, events), 6) + "," + number(e.tick) + "," + peer_of(e, names) + "," +
           std::string(e.what) + "," + number(e.entity) + "," + number(e.other) + "," + detail + "\n";
  }
  return out;
}

std::string timeline_json(std::uint16_t session, const std::vector<Event>& events) {
  shell::Json j;
  j.begin_object().field("session", static_cast<int>(session)).key("events").begin_array();
  for (const Event& e : events) {
    j.begin_object().field("time_s", seconds(e, events)).field("event", e.what);
    if (e.tick >= 0) j.field("tick", e.tick);
    if (e.by.slot != kNoPeer) j.field("peer", static_cast<int>(e.by.slot)).field("incarnation", e.by.incarnation);
    if (e.entity >= 0) j.field("entity", e.entity);
    if (e.other >= 0) j.field("other", e.other);
    if (!e.detail.empty()) j.field("detail", e.detail);
    j.end_object();
  }
  j.end_array().end_object();
  return j.text();
}

std::string timeline_svg(std::uint16_t session, const std::vector<Event>& events) {
  return Picture(session, events).draw();
}

}  // namespace padr::capture
