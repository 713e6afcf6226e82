#include "tools/monitor/prometheus.h"

#include <array>
#include <charconv>
#include <cmath>

#include "shell/revision.h"
#include "shell/text.h"

namespace padr::monitor {
namespace {

class Writer {
 public:
  /// The next values are of this metric.
  Writer& metric(std::string_view name, std::string_view type, std::string_view help) {
    name_ = name;
    text_ += "# HELP ";
    text_ += name;
    text_ += ' ';
    text_ += help;
    text_ += "\n# TYPE ";
    text_ += name;
    text_ += ' ';
    text_ += type;
    text_ += '\n';
    return *this;
  }
  void value(std::string_view labels, double v) {
    text_ += name_;
    if (!labels.empty()) text_ += '{' + std::string(labels) + '}';
    text_ += ' ' + number(v) + '\n';
  }
  std::string text() const { return text_; }

 private:
  static std::string number(double v) {
    std::array<char, 40> text{};
    v = std::round(v * 1e9) / 1e9;  // what was a float has no more digits than that
    return {text.data(), std::to_chars(text.data(), text.data() + text.size(), v).ptr};
  }
  std::string name_;
  std::string text_;
};

std::string label(std::string_view name, std::string_view value) {
  std::string s = std::string(name) + "=\"";
  for (const char c : shell::valid_utf8(value)) {
    if (c == '\n') {
      s += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') s += '\\';
    s += c;
  }
  return s + '"';
}

std::string of(const PeerRecord& p) {
  return label("peer", std::to_string(p.origin.slot));
}

using Value = std::optional<double> (*)(const PeerRecord&);
struct PeerMetric {
  const char* name;
  const char* type;
  const char* help;
  Value value;
};

std::optional<double> from_status(const PeerRecord& p, double (*value)(const Status&)) {
  return p.status ? std::optional(value(*p.status)) : std::nullopt;
}

constexpr std::array<PeerMetric, 15> kPeerMetrics{{
    {"padr_peer_tick", "gauge", "Newest session tick told of",
     [](const PeerRecord& p) { return p.newest ? std::optional(double{1.0} * p.newest->tick) : std::nullopt; }},
    {"padr_peer_datagrams_sent_total", "counter", "Datagrams sent to other peers",
     [](const PeerRecord& p) {
       return from_status(p, [](const Status& s) { return static_cast<double>(s.datagrams_sent); });
     }},
    {"padr_peer_wire_bytes_sent_total", "counter", "Bytes sent to other peers, IP and UDP headers included",
     [](const PeerRecord& p) {
       return from_status(p, [](const Status& s) { return static_cast<double>(s.bytes_sent); });
     }},
    {"padr_peer_datagrams_received_total", "counter", "Datagrams received from other peers",
     [](const PeerRecord& p) {
       return from_status(p, [](const Status& s) { return static_cast<double>(s.datagrams_received); });
     }},
    {"padr_peer_datagrams_dropped_total", "counter", "Of those, the ones that were not taken",
     [](const PeerRecord& p) {
       return from_status(p, [](const Status& s) { return static_cast<double>(s.dropped); });
     }},
    {"padr_peer_hash_checks_total", "counter", "Confirmed worlds that were compared with others'",
     [](const PeerRecord& p) {
       return from_status(p, [](const Status& s) { return static_cast<double>(s.hash_checks); });
     }},
    {"padr_peer_hash_mismatches_total", "counter", "Of those, the ones that differed",
     [](const PeerRecord& p) {
       return from_status(p, [](const Status& s) { return static_cast<double>(s.hash_mismatches); });
     }},
    {"padr_peer_steps_total", "counter", "Ticks played",
     [](const PeerRecord& p) { return from_status(p, [](const Status& s) { return static_cast<double>(s.steps); }); }},
    {"padr_peer_replayed_steps_total", "counter", "Ticks stepped again because an update came late",
     [](const PeerRecord& p) {
       return from_status(p, [](const Status& s) { return static_cast<double>(s.replayed_steps); });
     }},
    {"padr_peer_late_ticks_total", "counter", "Ticks begun more than a tick after their time",
     [](const PeerRecord& p) {
       return from_status(p, [](const Status& s) { return static_cast<double>(s.late_ticks); });
     }},
    {"padr_peer_own_error_metres", "gauge", "What others are believed to have wrong of what this peer owns",
     [](const PeerRecord& p) {
       return from_status(p, [](const Status& s) { return static_cast<double>(s.own_error_m); });
     }},
    {"padr_peer_price", "gauge", "Factor by which links and budget have all thresholds multiplied",
     [](const PeerRecord& p) { return from_status(p, [](const Status& s) { return double{s.price}; }); }},
    {"padr_peer_confirmed_tick", "gauge", "Newest confirmed tick",
     [](const PeerRecord& p) {
       return from_status(p, [](const Status& s) { return static_cast<double>(s.confirmed); });
     }},
    {"padr_peer_confirmed_lag_seconds", "gauge", "By how much the confirmed world trails",
     [](const PeerRecord& p) {
       const auto lag = p.lag_ms();
       return lag ? std::optional(*lag * 1e-3) : std::nullopt;
     }},
    {"padr_peer_threshold_metres", "gauge", "Threshold in force for the avatar",
     [](const PeerRecord& p) { return p.newest ? std::optional(double{p.newest->threshold}) : std::nullopt; }},
}};

struct LinkMetric {
  const char* name;
  const char* type;
  const char* help;
  std::optional<double> (*value)(const LinkStatus&);
  const char* other = "from";  ///< label of the other end: what comes from there, or goes `to` there
};

std::optional<double> if_measured(const LinkStatus& l, float ms) {
  return l.measured ? std::optional(double{ms} * 1e-3) : std::nullopt;
}

constexpr std::array<LinkMetric, 12> kLinkMetrics{{
    {"padr_link_delay_seconds", "gauge",
     "One-way delay from `from` to `peer`, by the two session clocks: median of recent datagrams",
     [](const LinkStatus& l) { return if_measured(l, l.delay_p50_ms); }},
    {"padr_link_delay_p95_seconds", "gauge", "Its 95th percentile",
     [](const LinkStatus& l) { return if_measured(l, l.delay_p95_ms); }},
    {"padr_link_delay_least_seconds", "gauge", "The least of it",
     [](const LinkStatus& l) { return if_measured(l, l.delay_least_ms); }},
    {"padr_link_round_trip_seconds", "gauge",
     "Smoothed round trip, to a tick, no less than the least recent delays there and back",
     [](const LinkStatus& l) { return std::optional(double{l.round_trip_ms} * 1e-3); }},
    {"padr_link_loss_ratio", "gauge",
     "Share of the latest datagrams from `from` to `peer`, 192 at most, that did not come",
     [](const LinkStatus& l) { return l.loss_of > 0 ? std::optional(double{l.loss_in}) : std::nullopt; }},
    {"padr_link_loss_ratio_of", "gauge", "Of how many datagrams that is the share",
     [](const LinkStatus& l) { return std::optional(double{1.0} * l.loss_of); }},
    {"padr_link_lost_total", "counter", "Datagrams from `from` to `peer` that did not come, since the link began",
     [](const LinkStatus& l) { return std::optional(static_cast<double>(l.lost_in)); }},
    {"padr_link_judged_total", "counter", "Of how many datagrams these are: all that were sent but for the newest 8",
     [](const LinkStatus& l) { return std::optional(static_cast<double>(l.judged_in)); }},
    {"padr_link_carries_bits_per_second", "gauge",
     "What the link from `peer` to `to` was found to carry; none: no limit was found",
     [](const LinkStatus& l) {
       return l.carries_kbit_s > 0 ? std::optional(double{l.carries_kbit_s} * 1000) : std::nullopt;
     },
     "to"},
    {"padr_link_queue_seconds", "gauge", "How long datagrams wait in that link's queue",
     [](const LinkStatus& l) { return std::optional(double{l.queue_ms} * 1e-3); }, "to"},
    {"padr_link_carried", "gauge", "1 if another member carries from `peer` to `to`, as the link does not work",
     [](const LinkStatus& l) { return std::optional(l.carrier == kNoPeer ? 0.0 : 1.0); }, "to"},
    {"padr_link_cut", "gauge", "1 if the link is cut by an order",
     [](const LinkStatus& l) { return std::optional(l.cut_in || l.cut_out ? 1.0 : 0.0); }},
}};

void inconsistency(Writer& w, const ObservedSession& s) {
  w.metric("padr_peer_inconsistency_metres", "gauge",
           "Distance to where the authority has entities, summed over them, at the newest confirmed tick measured");
  for (const PeerRecord* p : s.peers()) {
    const auto i = s.inconsistency(p->origin.slot);
    if (!i) continue;
    w.value(of(*p) + "," + label("part", "avatars"), double{i->avatars_m});
    w.value(of(*p) + "," + label("part", "bodies"), double{i->bodies_m});
  }
  w.metric("padr_peer_shown_inconsistency_metres", "gauge", "The same of shown positions, avatars and bodies together");
  for (const PeerRecord* p : s.peers())
    if (const auto i = s.inconsistency(p->origin.slot)) w.value(of(*p), double{i->shown_m});
}

/// Of those who have left, too: what they sent is no less dropped.
void drops(Writer& w, const ObservedSession& s) {
  w.metric("padr_peer_dropped_total", "counter", "Datagrams from the member in slot `from` that `peer` did not take");
  for (const PeerRecord* p : s.peers())
    for (const auto& [from, link] : p->links)
      for (std::size_t d = 1; d < sync::kDropReasons; ++d)
        if (link.dropped[d] > 0)
          w.value(of(*p) + "," + label("from", std::to_string(from)) + "," + label("reason", sync::kDropNames[d]),
                  static_cast<double>(link.dropped[d]));
  w.metric("padr_peer_cut_offs_total", "counter",
           "How often `peer` has cut off who sits in slot `from`, for good or for a while");
  for (const PeerRecord* p : s.peers())
    for (const auto& [from, link] : p->links)
      if (link.cut_offs > 0)
        w.value(of(*p) + "," + label("from", std::to_string(from)), static_cast<double>(link.cut_offs));
}

void peers(Writer& w, const ObservedSession& s, Micros now) {
  w.metric("padr_peer_up", "gauge", "1 if the peer has told something in the last second");
  for (const PeerRecord* p : s.peers())
    w.value(of(*p) + "," + label("incarnation", std::to_string(p->origin.incarnation)),
            p->presence(now) == PeerRecord::Presence::kHere ? 1 : 0);
  w.metric("padr_peer_agrees", "gauge",
           "1 if its confirmed world is that of the others, 0 if it differs; none while it is apart from them");
  for (const PeerRecord* p : s.peers()) {
    const auto verdict = s.agreement().of(p->origin.slot);
    if (verdict == Agreement::Verdict::kIdentical || verdict == Agreement::Verdict::kDiffers)
      w.value(of(*p), verdict == Agreement::Verdict::kIdentical ? 1 : 0);
  }
  inconsistency(w, s);
  w.metric("padr_peer_updates_total", "counter", "Entity updates told, each once however often sent");
  for (const PeerRecord* p : s.peers()) {
    if (!p->status) continue;
    for (std::size_t c = 0; c < sync::kCauses; ++c)
      w.value(of(*p) + "," + label("cause", sync::kCauseNames[c]), static_cast<double>(p->status->updates_by_cause[c]));
  }
  for (const PeerMetric& m : kPeerMetrics) {
    w.metric(m.name, m.type, m.help);
    for (const PeerRecord* p : s.peers())
      if (const auto v = m.value(*p)) w.value(of(*p), *v);
  }
  drops(w, s);
  for (const LinkMetric& m : kLinkMetrics) {
    w.metric(m.name, m.type, m.help);
    for (const PeerRecord* p : s.peers())
      for (const auto& [to, link] : p->links)
        if (const auto v = m.value(link); v && link.there)
          w.value(label(m.other, std::to_string(to)) + "," + of(*p), *v);
  }
}

void own(Writer& w, const HeardStats& heard, const WebStats& web) {
  const auto one = [&w](const char* name, const char* type, const char* help, double v) {
    w.metric(name, type, help).value("", v);
  };
  one("padr_monitor_datagrams_total", "counter", "Datagrams from peers", static_cast<double>(heard.datagrams));
  one("padr_monitor_datagram_bytes_total", "counter", "Their bytes", static_cast<double>(heard.bytes));
  one("padr_monitor_malformed_datagrams_total", "counter", "Those that were not understood",
      static_cast<double>(heard.malformed));
  one("padr_monitor_viewers", "gauge", "Pages that are connected", static_cast<double>(web.viewers));
  one("padr_monitor_connections", "gauge", "TCP connections, pages included", static_cast<double>(web.connections));
  one("padr_monitor_requests_total", "counter", "HTTP requests", static_cast<double>(web.requests));
  one("padr_monitor_refused_requests_total", "counter", "Those answered with an error",
      static_cast<double>(web.refused));
  one("padr_monitor_malformed_requests_total", "counter", "No HTTP, or too much of it",
      static_cast<double>(web.malformed));
  one("padr_monitor_timeouts_total", "counter", "Connections that were too slow", static_cast<double>(web.timeouts));
  one("padr_monitor_turned_away_total", "counter", "Connections beyond the limit",
      static_cast<double>(web.turned_away));
  one("padr_monitor_dismissed_viewers_total", "counter", "Pages that were too slow or sent what they may not",
      static_cast<double>(web.dismissed));
  one("padr_monitor_sent_bytes_total", "counter", "Sent to pages", static_cast<double>(web.sent_bytes));
  one("padr_monitor_skipped_messages_total", "counter", "Messages that a page was too slow for",
      static_cast<double>(web.skipped));
}

}  // namespace

std::string metrics_text(const ObservedSession* session, const HeardStats& heard, const WebStats* web, Micros now) {
  Writer w;
  w.metric("padr_monitor_build_info", "gauge", "Of this program");
  w.value(label("version", shell::version()) + "," + label("revision", shell::revision()), 1);
  own(w, heard, web == nullptr ? WebStats{} : *web);
  if (session == nullptr) return w.text();
  w.metric("padr_session_info", "gauge", "The session that is shown");
  w.value(label("session", std::to_string(session->key().number)) + "," + label("scenario", session->scenario()), 1);
  w.metric("padr_session_tick", "gauge", "Newest session tick that any peer told of").value("", session->tick());
  w.metric("padr_session_worlds_compared_total", "counter", "Confirmed worlds that were compared here")
      .value("", static_cast<double>(session->agreement().compared()));
  peers(w, *session, now);
  return w.text();
}

}  // namespace padr::monitor
