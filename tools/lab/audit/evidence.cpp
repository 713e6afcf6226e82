#include "tools/lab/audit/evidence.h"

#include <algorithm>
#include <type_traits>
#include <variant>

#include "common/model/user_error.h"
#include "common/sync/validation.h"
#include "common/trace/trace_reader.h"
#include "common/wire/codec.h"
#include "common/wire/membership_codec.h"
#include "common/wire/signature.h"
#include "common/wire/transfer_codec.h"

namespace padr::lab::audit {
namespace {

/// Hands over what is told in a trace, packet by packet. A visitor has begin(), packet(), relayed() and event().
template <typename Visitor>
void visit(const TraceText& text, const Scene& scene, Visitor& v) {
  trace::TraceReader reader(text.bytes, text.label);
  const trace::Header& h = reader.header();
  const auto packet = [&](std::span<const std::byte> datagram) {
    wire::SealError refused{};
    const auto opened = wire::open(datagram, refused);
    if (!opened || opened->header.kind != wire::Kind::kState || opened->header.session != h.session) return;
    if (opened->header.sender >= h.slots) return;
    if (const auto p = wire::decode_state(opened->payload, opened->header.sender)) v.packet(opened->header.sender, *p);
  };
  while (const auto event = reader.next()) {
    if (const auto* b = std::get_if<trace::Begin>(&*event))
      if (const auto start = wire::decode_transfer(b->transfer, scene, h.slots)) v.begin(*start);
    if (const auto* r = std::get_if<trace::Received>(&*event)) packet(r->datagram);
    if (const auto* s = std::get_if<trace::Sent>(&*event)) packet(s->datagram);
    if (const auto* r = std::get_if<trace::Relayed>(&*event)) {
      const auto message = wire::decode_membership(r->fetched);
      if (const auto* fetched = message ? std::get_if<wire::Fetched>(&*message) : nullptr) v.relayed(*fetched);
    }
    v.event(*event);
  }
}

/// Who came when: before anything else, as datagrams overtake one another.
class SeatReader {
 public:
  SeatReader(Evidence& evidence, std::size_t trace) : evidence_(evidence), trace_(trace) {}

  void begin(const sync::Transfer& start) {
    evidence_.members.note_transfer(trace_, start);
    for (const sync::Bundle& b : start.tail) admissions(b);
  }
  void packet(PeerId /*sender*/, const sync::StatePacket& p) {
    for (const sync::Bundle& b : p.updates) admissions(b);
  }
  void relayed(const wire::Fetched& f) {
    for (const sync::Bundle& b : f.updates) admissions(b);
  }
  void event(const trace::Event& /*event*/) {}

 private:
  void admissions(const sync::Bundle& b) {
    const int slots = evidence_.traces[trace_].header.slots;
    for (const sync::Bundle& lost : b.passed_on) admissions(lost);
    if (b.admission && b.admission->slot < slots) evidence_.members.note_admission(trace_, *b.admission, b.tick);
  }

  Evidence& evidence_;
  std::size_t trace_;
};

class StatementReader {
 public:
  StatementReader(Evidence& evidence, std::size_t trace, const Scene& scene)
      : evidence_(evidence), facts_(evidence.traces[trace]), trace_(trace), scene_(scene) {
    note_technique(facts_.header.technique);
  }

  void begin(const sync::Transfer& start) {
    for (const sync::Bundle& b : start.tail) by_number(b, kNoPeer);
  }
  void packet(PeerId sender, const sync::StatePacket& p) {
    const auto who = evidence_.members.sitter(trace_, sender, p.incarnation);
    if (!who) return;
    for (const sync::Bundle& b : p.updates) {
      file(*who, b, kNoPeer);
      for (const sync::Bundle& lost : b.passed_on) by_number(lost, sender);
    }
    facts_.hashes.told({sender, p.incarnation}, p.mark_tick, p.check_tick, p.check_hash);
  }
  void relayed(const wire::Fetched& f) {
    const auto who = evidence_.members.sitter(trace_, f.slot, f.incarnation);
    if (!who) return;
    for (const sync::Bundle& b : f.updates) file(*who, b, facts_.header.peer);
  }
  void event(const trace::Event& event) {
    if (const auto* c = std::get_if<trace::Confirmed>(&event)) facts_.hashes.confirmed(c->tick, c->hash);
    if (const auto* s = std::get_if<trace::Step>(&event)) facts_.last = s->tick;
    if (const auto* r = std::get_if<trace::Retune>(&event)) note_technique(r->technique);
    if (const auto* p = std::get_if<trace::Push>(&event)) facts_.pushes[p->body].push_back(facts_.last);
  }

 private:
  void note_technique(const Technique& t) { facts_.plays_alone |= t.unowned == Unowned::kLive; }
  /// An update that comes without its author's incarnation.
  void by_number(const sync::Bundle& b, PeerId passed_on_by) {
    if (b.peer >= facts_.header.slots) return;
    if (const auto who = evidence_.members.author(trace_, b.peer, b.index)) file(*who, b, passed_on_by);
    for (const sync::Bundle& lost : b.passed_on) by_number(lost, b.peer);
  }
  void file(MemberId who, const sync::Bundle& b, PeerId passed_on_by) {
    if (sync::admit(b, scene_, facts_.header.slots) != sync::DropReason::kNone) return;
    evidence_.ledger.add(trace_, who, b, passed_on_by);
  }

  Evidence& evidence_;
  TraceFacts& facts_;
  std::size_t trace_;
  const Scene& scene_;
};

template <typename T>
void same(const char* what, const T& a, const T& b, const TraceText& first, const TraceText& second) {
  if (a != b) throw UserError(second.label + ": is of another session than " + first.label + ": " + what + " differs");
}

void check_together(const TraceFacts& a, const TraceFacts& b, const TraceText& first, const TraceText& second) {
  same("the scenario", a.header.scene_hash, b.header.scene_hash, first, second);
  same("the session number", a.header.session, b.header.session, first, second);
  same("the number of avatar slots", a.header.slots, b.header.slots, first, second);
  same("whether there is authority over bodies", a.header.technique.authority, b.header.technique.authority, first,
       second);
  same("the session id", a.header.session_id, b.header.session_id, first, second);
}

/// Those who are there at tick 0 sit in slots from 0 on.
void note_owner(Evidence& all, std::size_t trace) {
  TraceFacts& f = all.traces[trace];
  const bool from_start = f.header.incarnation == 0;
  if (from_start)
    for (PeerId p = 0; p < f.header.peers; ++p) all.members.note(trace, {p, 0, {}, 0}, 0);
  const auto known = all.members.sitter(trace, f.header.peer, f.header.incarnation);
  f.owner = known ? *known : all.members.note(trace, {f.header.peer, f.header.incarnation, {}, -1}, 0);
}

}  // namespace

SessionId Evidence::session() const {
  for (const TraceFacts& t : traces)
    if (t.header.session_id != SessionId{}) return t.header.session_id;
  return {};
}

bool Evidence::is_signed(MemberId author, const sync::Bundle& update) const {
  const Member& m = members[author];
  return session() != SessionId{} && m.has_key() && wire::is_signed(m.key, {session(), m.incarnation}, update);
}

const TraceFacts* Evidence::own_trace(MemberId author, Tick tick) const {
  for (const TraceFacts& t : traces)
    if (t.owner == author && t.last >= tick) return &t;
  return nullptr;
}

Evidence read_evidence(const std::vector<TraceText>& texts, const Scene& scene) {
  Evidence all(texts.size());
  for (std::size_t i = 0; i < texts.size(); ++i) {
    all.traces[i].header = trace::TraceReader(texts[i].bytes, texts[i].label).header();
    check_together(all.traces[0], all.traces[i], texts[0], texts[i]);
    SeatReader seats(all, i);
    visit(texts[i], scene, seats);
  }
  for (std::size_t i = 0; i < texts.size(); ++i) note_owner(all, i);
  for (std::size_t i = 0; i < texts.size(); ++i) {
    StatementReader statements(all, i, scene);
    visit(texts[i], scene, statements);
  }
  return all;
}

}  // namespace padr::lab::audit
