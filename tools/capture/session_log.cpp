#include "tools/capture/session_log.h"

#include <algorithm>

#include "common/model/user_error.h"
#include "common/wire/codec.h"
#include "shell/text.h"
#include "tools/capture/keyring.h"

namespace padr::capture {
namespace {

constexpr std::size_t kMostJoins = 4096;
constexpr std::size_t kMostNamed = 8;  ///< sessions in a message

/// Of who was there at tick 0: how many of its updates are known from the first on without a gap.
std::uint32_t known_from_start(const SessionLog::Voice& v) {
  std::uint32_t have = 0;
  while (v.updates.contains(have)) ++have;
  return have;
}

/// For messages: its number and what tells it from others.
std::string named(const SessionLog& l) {
  std::string text = std::to_string(l.session) + " (";
  if (l.join) text += l.join->scenario + ", ";
  return text + "ticks " + std::to_string(l.oldest) + " to " + std::to_string(l.newest) + ", " +
         shell::counted(l.voices.size(), "peer") + ", " + std::to_string(l.states) + " state datagrams)";
}

/// An update passed on is one of its own slot's log, and may pass on another one.
void retell(const sync::Bundle& b, SessionLog& l) {
  for (const sync::Bundle& lost : b.passed_on) {
    l.retold.try_emplace({lost.peer, lost.index}, lost);
    retell(lost, l);
  }
}

}  // namespace

void Names::add(const Incarnation& who) {
  std::uint32_t& first = first_.try_emplace(who.slot, who.incarnation).first->second;
  first = std::min(first, who.incarnation);
}

std::string Names::operator()(const Incarnation& who) const {
  const auto first = first_.find(who.slot);
  const bool alone = first != first_.end() && first->second == who.incarnation;
  return std::to_string(who.slot) + (alone ? "" : "." + std::to_string(who.incarnation));
}

Names SessionLog::names() const {
  Names all;
  for (const auto& [who, voice] : voices) all.add(who);
  return all;
}

bool SessionLog::Pieces::complete() const {
  return !parts.empty() && std::none_of(parts.begin(), parts.end(), [](const wire::Bytes& b) { return b.empty(); });
}

wire::Bytes SessionLog::Pieces::joined() const {
  wire::Bytes all;
  for (const wire::Bytes& b : parts) all.insert(all.end(), b.begin(), b.end());
  return all;
}

void Bookkeeper::take(const Datagram& d) {
  wire::SealError error = wire::SealError::kNone;
  const auto o = d.cut ? std::nullopt : wire::open(d.payload, error);
  if (!o) {
    ++unreadable_;
    return;
  }
  SessionLog& l = ledgers_[o->header.session];
  l.session = o->header.session;
  if (l.first_ns == 0) l.first_ns = d.time_ns;
  bool good = false;
  if (o->header.kind == wire::Kind::kState) {
    const auto p = wire::decode_state(o->payload, o->header.sender);
    good = p && o->header.sender < kMaxPeers;
    if (good) state(d, *p, o->header.sender, l);
  } else if (o->header.kind == wire::Kind::kSession) {
    const auto m = wire::decode_session(o->payload);
    good = m.has_value();
    if (good) session(*m, l);
  } else {
    const auto m = wire::decode_membership(o->payload);
    good = m.has_value();
    if (good) membership(d, *m, l);
  }
  if (!good) ++unreadable_;
}

void Bookkeeper::state(const Datagram& d, const sync::StatePacket& p, PeerId sender, SessionLog& l) {
  ++l.states;
  const Incarnation who{sender, p.incarnation};
  SessionLog::Voice& v = l.voices[who];
  v.at = d.from;
  v.last_ns = d.time_ns;
  v.last_tick = std::max(v.last_tick, p.mark_tick);
  l.oldest = l.oldest < 0 ? p.mark_tick : std::min(l.oldest, p.mark_tick);
  l.newest = std::max(l.newest, p.mark_tick);
  for (const sync::Bundle& b : p.updates) {
    v.updates.try_emplace(b.index, b);
    retell(b, l);
  }
  Tick& mark = v.marks[p.mark_count];
  mark = std::max(mark, p.mark_tick);
  if (p.check_tick >= 0 && checked_.emplace(l.session, p.check_tick, who).second)
    l.checks.push_back({p.check_tick, p.check_hash, who, d.packet});
}

void Bookkeeper::session(const wire::SessionMessage& m, SessionLog& l) {
  if (const auto* join = std::get_if<wire::Join>(&m)) {
    if (joins_.size() < kMostJoins) joins_[join->nonce] = *join;
  } else if (const auto* welcome = std::get_if<wire::Welcome>(&m)) {
    l.slots = welcome->slots;
    l.wanted = welcome->wanted;
    const auto asked = joins_.find(welcome->nonce);
    if (asked != joins_.end() && !l.join) l.join = asked->second;
  }
}

void Bookkeeper::membership(const Datagram& d, const wire::MembershipMessage& m, SessionLog& l) {
  if (const auto* piece = std::get_if<wire::Piece>(&m)) {
    SessionLog::Pieces& p = l.transfers[{d.to, piece->nonce}];
    if (p.parts.empty()) p.parts.resize(piece->count);
    if (piece->count == p.parts.size()) p.parts[piece->index] = piece->bytes;
  } else if (const auto* fetched = std::get_if<wire::Fetched>(&m)) {
    for (sync::Bundle b : fetched->updates) {
      b.peer = fetched->slot;
      l.retold.try_emplace({b.peer, b.index}, b);
      retell(b, l);
    }
  }
}

std::string Bookkeeper::sessions() const {
  std::vector<const SessionLog*> all;
  for (const auto& [number, l] : ledgers_)
    if (l.states > 0) all.push_back(&l);
  std::stable_sort(all.begin(), all.end(),
                   [](const SessionLog* a, const SessionLog* b) { return a->states > b->states; });
  std::string text;
  for (std::size_t i = 0; i < std::min(all.size(), kMostNamed); ++i) text += (i == 0 ? "" : "; ") + named(*all[i]);
  if (all.size() > kMostNamed) text += "; and " + std::to_string(all.size() - kMostNamed) + " with fewer datagrams";
  return text;
}

const SessionLog& Bookkeeper::choose(std::optional<int> session) const {
  const SessionLog* chosen = nullptr;
  std::size_t candidates = 0;
  for (const auto& [number, l] : ledgers_) {
    if (l.states == 0 || (session && *session != number)) continue;
    chosen = &l;
    ++candidates;
  }
  if (candidates == 1) return *chosen;
  if (candidates > 1)
    throw UserError("--session: the capture has " + std::to_string(candidates) +
                    " sessions, say which one: " + sessions());
  if (const std::string all = sessions(); session && !all.empty())
    throw UserError("--session: " + std::to_string(*session) + " is not in the capture; it has " + all);
  throw UserError("CAPTURE: there are no state datagrams of PADR in it" +
                  std::string(unreadable_ > 0 ? " that are whole and undamaged" : ""));
}

std::string nothing_to_begin_with(const SessionLog& session_log, const Contents& contents) {
  const auto whole = [](const auto& t) { return t.second.complete(); };
  if (std::any_of(session_log.transfers.begin(), session_log.transfers.end(), whole)) return "";
  std::string lacks;
  bool anybody = false;
  for (const auto& [who, voice] : session_log.voices) {
    if (who.incarnation > 0) continue;
    anybody = true;
    const std::uint32_t have = known_from_start(voice);
    if (!lacks.empty() || voice.marks.begin()->first <= have) continue;
    lacks = "update " + std::to_string(have) + " of peer " + session_log.names()(who) + " is not in it";
  }
  if (!anybody) lacks = "it has nothing of those who were there at tick 0";
  if (lacks.empty()) return "";
  // A few may be of others, or damaged.
  const auto many = [&session_log](std::uint64_t n) { return 10 * n > session_log.states; };
  const std::string cannot = ", and without the beginning the confirmed world cannot be rebuilt";
  if (const auto hidden = contents.sealed[static_cast<std::size_t>(Keyring::Reading::kHidden)]; many(hidden))
    return shell::counted(hidden, "datagram") + " of the capture are encrypted, and no --keylog has a key for them" +
           cannot;
  if (const auto cut = contents.of[static_cast<std::size_t>(Content::kCutUdp)]; many(cut))
    return "the capture has cut off " + shell::counted(cut, "datagram") + " (snaplen; capture with -s 0)" + cannot;
  return "session " + std::to_string(session_log.session) + " had begun when the capture did, at tick " +
         std::to_string(session_log.oldest) + ": " + lacks +
         ", and no whole transfer to a newcomer is. Without one of the two the confirmed world cannot be rebuilt; "
         "capture from before the first peer starts, or let a peer join while you capture. summary, timeline, export "
         "and follow do without";
}

}  // namespace padr::capture
