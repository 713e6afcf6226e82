#include "tools/capture/comparison.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <string_view>

#include "common/model/user_error.h"
#include "common/trace/trace_reader.h"
#include "common/wire/state_scan.h"
#include "shell/files.h"

namespace padr::capture {
namespace {

// Hours of a busy session.
constexpr std::size_t kMostBytes = std::size_t{4} << 30U;

std::uint64_t content_of(std::span<const std::byte> b) {
  return std::hash<std::string_view>()({reinterpret_cast<const char*>(b.data()), b.size()});
}

/// The network turns the order of datagrams round by no more than this, ticks. So near to where it begins or ends a
/// capture may lack a datagram, or one of its copies, and have those told before and after it.
constexpr Tick kEdge = kTicksPerSecond;

/// From when on a trace may lack what its peer did; no trace lacks what nobody has a trace of.
Tick end_of(const TraceStory* t) {
  return t == nullptr || t->clean ? std::numeric_limits<Tick>::max() : t->last_tick;
}

void judge(const Passage& p, Tick first, Tick last, Tick sender_end, Tick receiver_end, LinkStory& l) {
  l.sent += p.sent;
  l.captured += p.captured;
  l.received += p.received;
  const bool within = p.tick >= first && p.tick <= last;
  const bool at_edge = p.tick - kEdge <= first || p.tick + kEdge >= last;
  if (p.captured > std::max(p.sent, 1U)) l.duplicates += p.captured - std::max(p.sent, 1U);
  if (l.sender_told && p.sent == 0) {
    if (p.tick >= sender_end) {
      l.after_trace.push_back(p);
    } else {
      l.contradictions.push_back(p);
    }
  } else if (p.captured == 0 && (!within || (at_edge && p.received > 0))) {
    ++l.outside;
  } else if (p.received > p.captured && !at_edge) {
    l.contradictions.push_back(p);
  } else if (p.captured == 0) {
    l.lost_before.push_back(p);
  } else if (l.receiver_told && p.received == 0) {
    // What was on its way when the trace broke off is older.
    (p.tick >= receiver_end - kEdge ? l.after_trace : l.lost_after).push_back(p);
  }
}

}  // namespace

void Comparison::from_trace(std::span<const std::byte> datagram, const TraceStory& story, PeerId to) {
  wire::SealError error = wire::SealError::kNone;
  wire::StateScan scan;
  const auto o = wire::open(datagram, error);
  const bool sent = to != kNoPeer;
  if (!o || !wire::scan_state(o->payload, scan)) {
    if (!sent) ++damaged_received_;
    return;
  }
  // While a peer begins another incarnation, the old one hears what is for the new one, too, and drops it.
  if (!sent && scan.to_incarnation != story.header.incarnation) return;
  Key key;
  key.from = {o->header.sender, scan.incarnation};
  key.to = sent ? Incarnation{to, scan.to_incarnation} : story.who();
  key.content = content_of(datagram);
  Passage& p = told_[key];
  p.seq = scan.seq;
  p.tick = static_cast<Tick>(scan.mark_tick);
  ++(sent ? p.sent : p.received);
}

void Comparison::add_trace(const std::string& file) {
  const std::string text = shell::read_file("TRACE", file, kMostBytes);
  trace::TraceReader reader(std::as_bytes(std::span(text)), file);
  TraceStory story;
  story.label = file;
  story.header = reader.header();
  while (const auto event = reader.next()) {
    if (const auto* step = std::get_if<trace::Step>(&*event)) {
      story.last_tick = step->tick;
    } else if (const auto* s = std::get_if<trace::Sent>(&*event)) {
      from_trace(s->datagram, story, s->to);
    } else if (const auto* r = std::get_if<trace::Received>(&*event)) {
      from_trace(r->datagram, story, kNoPeer);
    } else if (const auto* c = std::get_if<trace::Confirmed>(&*event)) {
      story.confirmed[c->tick] = c->hash;
    } else if (const auto* f = std::get_if<trace::Footer>(&*event)) {
      story.superseded = f->superseded;
    }
  }
  story.clean = reader.clean();
  if (!traces_.empty() && traces_.front().header.session != story.header.session)
    throw UserError(file + ": is of session " + std::to_string(story.header.session) + ", " + traces_.front().label +
                    " of session " + std::to_string(traces_.front().header.session));
  for (const TraceStory& t : traces_)
    if (trace::same_incarnation(t.header, story.header))
      throw UserError(file + ": is a trace of peer " + std::to_string(story.header.peer) + ", and so is " + t.label);
  traces_.push_back(std::move(story));
}

void Comparison::add(const Datagram& d) {
  if (d.cut) {
    if (d.second_hop) return;
    ++cut_;
    ++cut_on_[{d.from, d.to}];
    return;
  }
  wire::SealError error = wire::SealError::kNone;
  wire::StateScan scan;
  const auto o = wire::open(d.payload, error);
  if (!o) {
    if (!d.second_hop) ++damaged_;
    return;
  }
  if (o->header.kind != wire::Kind::kState || traces_.empty() || o->header.session != traces_[0].header.session) return;
  if (!wire::scan_state(o->payload, scan)) return;
  who_[{d.from, scan.incarnation}] = o->header.sender;
  captured_.push_back({{o->header.sender, scan.incarnation},
                       d.from,
                       d.to,
                       scan.to_incarnation,
                       content_of(d.payload),
                       scan.seq,
                       static_cast<Tick>(scan.mark_tick),
                       d.carried_to.has_value(),
                       d.second_hop});
}

Incarnation Comparison::receiver_of(const Captured& c) const {
  if (const auto found = who_.find({c.to, c.to_incarnation}); found != who_.end())
    return {found->second, c.to_incarnation};
  for (PeerId slot = 0; slot < kMaxPeers; ++slot)
    if (told_.contains({c.from, {slot, c.to_incarnation}, c.content})) return {slot, c.to_incarnation};
  return {kNoPeer, c.to_incarnation};
}

std::vector<LinkStory> Comparison::links() const {
  std::map<Key, Passage> all = told_;
  struct Range {
    Tick first = std::numeric_limits<Tick>::max();
    Tick last = -1;
    std::uint64_t cut = 0;
    bool direct = false;
    bool passed_on = false;
    void add(Tick t) {
      first = std::min(first, t);
      last = std::max(last, t);
    }
  };
  std::map<std::pair<Incarnation, Incarnation>, Range> ranges;
  for (const Captured& c : captured_) {
    Range& r = ranges[{c.from, receiver_of(c)}];
    r.direct = r.direct || !c.carried;
    r.passed_on = r.passed_on || c.second_hop;
  }
  for (const Captured& c : captured_) {
    if (c.second_hop) continue;
    const Incarnation to = receiver_of(c);
    Passage& p = all[{c.from, to, c.content}];
    p.seq = c.seq;
    p.tick = c.tick;
    ++p.captured;
    Range& r = ranges[{c.from, to}];
    // A carrier sees what it passes on, and not what goes directly.
    if (!c.carried || !(r.direct || r.passed_on)) r.add(c.tick);
    if (const auto cut = cut_on_.find({c.at, c.to}); cut != cut_on_.end()) r.cut = cut->second;
  }
  const auto trace_of = [this](const Incarnation& who) {
    const auto found = std::find_if(traces_.begin(), traces_.end(), [&](const auto& t) { return t.who() == who; });
    return found == traces_.end() ? nullptr : &*found;
  };
  std::map<std::pair<Incarnation, Incarnation>, LinkStory> links;
  for (const auto& [key, p] : all) {
    LinkStory& l = links[{key.from, key.to}];
    l.from = key.from;
    l.to = key.to;
    const TraceStory* sender = trace_of(key.from);
    const TraceStory* receiver = trace_of(key.to);
    l.sender_told = sender != nullptr;
    l.receiver_told = receiver != nullptr;
    const auto range = ranges.find({key.from, key.to});
    if (range == ranges.end() || range->second.cut > 0) {
      l.sent += p.sent;
      l.captured += p.captured;
      l.received += p.received;
      l.cut = range == ranges.end() ? 0 : range->second.cut;
      continue;
    }
    judge(p, range->second.first, range->second.last, end_of(sender), end_of(receiver), l);
  }
  std::vector<LinkStory> out;
  for (auto& [key, l] : links) {
    for (auto* list : {&l.lost_before, &l.lost_after, &l.after_trace, &l.contradictions})
      std::sort(list->begin(), list->end(), [](const Passage& a, const Passage& b) { return a.seq < b.seq; });
    out.push_back(std::move(l));
  }
  return out;
}

}  // namespace padr::capture
