#include "common/participant/session.h"

#include <cassert>
#include <utility>

#include "common/model/rng.h"
#include "common/participant/session_joiner.h"

namespace padr::node {
namespace {

/// Time for which others send datagrams of another session before that is told, and interval between two such events.
constexpr Micros kOthersStay = 5 * kMicrosPerSecond;
constexpr Micros kTellOthersAgain = 60 * kMicrosPerSecond;

}  // namespace

Session::Session(const SessionConfig& config, Micros local) {
  assert(config.join || (config.wanted >= 1 && config.wanted <= config.slots && config.slots <= kMaxPeers));
  session_.config = config;
  session_.born = local;
  session_.number = config.number;
  session_.id = config.id;
  if (config.join) {
    joiner_ = std::make_unique<Joiner>(session_, local);
  } else {
    found(local);
  }
}

Session::~Session() = default;

void Session::found(Micros local) {
  const SessionConfig& c = session_.config;
  std::uint64_t seed = c.seed;
  while (session_.number == 0) session_.number = static_cast<std::uint16_t>(splitmix64(seed));
  session_.self = 0;
  session_.wanted = c.wanted;
  session_.slots = c.slots;
  session_.present = 1;
  if (c.begins_at) session_.incarnation = 1 + Rng(c.seed).below(sync::kMostFounding);
  session_.clock.set(c.begins_at.value_or(0) - local);
  session_.phase = SessionPhase::kMember;
}

void Session::on_refused(const Endpoint& from, std::size_t bytes, wire::SealError why, std::uint8_t version,
                         Micros local) {
  ++stats_.datagrams;
  ++(why == wire::SealError::kVersion ? stats_.version : stats_.seal);
  if (why == wire::SealError::kVersion) other_version(from, bytes, version, local);
}

bool Session::receive(const Endpoint& from, const wire::Opened& opened, Micros local) {
  ++stats_.datagrams;
  const wire::Header& h = opened.header;
  if (h.kind == wire::Kind::kState) {
    const bool ours = h.session == session_.number && session_.number != 0;
    if (!ours || membership_ == nullptr || !membership_->is_at(h.sender, from)) {
      ++stats_.foreign;
      if (!ours) note_other_session(from, local);
      if (ours && membership_ != nullptr) membership_->on_stranger(from, opened.datagram.size(), local);
      return false;
    }
    ++stats_.state;
    return true;
  }
  if (h.kind == wire::Kind::kMembership) {
    take_membership(from, opened, local);
    return false;
  }
  const auto message = wire::decode_session(opened.payload);
  // A joiner's address is not proven yet: a Join that may be smaller than its answer gets none.
  const bool small_join =
      message && std::holds_alternative<wire::Join>(*message) && opened.datagram.size() < wire::kMaxDatagram;
  if (!message || small_join) {
    ++stats_.malformed;
    return false;
  }
  // A joiner does not know the session's number, nor does an answer from outside the session have it.
  const bool any_number = std::holds_alternative<wire::Join>(*message) || session_.phase == SessionPhase::kJoining;
  if (!any_number && h.session != session_.number) {
    ++stats_.foreign;
    return false;
  }
  ++stats_.session;
  dispatch(from, h, *message, local);
  return false;
}

void Session::unreachable(const Endpoint& at, Micros local) {
  if (membership_ != nullptr) membership_->on_unreachable(at);
  if (session_.phase == SessionPhase::kEntering) pull_->on_unreachable(at);
  if (joiner_) joiner_->on_unreachable(at, local);
}

// A founder that is started anew while the others play founds another session, and waits for them in vain. Those that
// wait, too, come by themselves.
void Session::note_other_session(const Endpoint& from, Micros local) {
  if (session_.config.join || settled_ || session_.phase != SessionPhase::kMember) return;
  if (!others_since_) others_since_ = local;
  if (local - *others_since_ < kOthersStay) return;
  others_since_ = local + kTellOthersAgain;
  session_.tell({.kind = SessionEvent::Kind::kOtherSession, .at = from});
}

void Session::take_membership(const Endpoint& from, const wire::Opened& opened, Micros local) {
  const wire::Header& header = opened.header;
  const auto message = wire::decode_membership(opened.payload);
  if (!message) {
    ++stats_.malformed;
    return;
  }
  if (header.session != session_.number || session_.number == 0) {
    ++stats_.foreign;
    note_other_session(from, local);
    return;
  }
  ++stats_.session;
  if (const auto* piece = std::get_if<wire::Piece>(&*message)) {
    if (session_.phase == SessionPhase::kEntering) pull_->on_piece(from, *piece, local);
  } else if (membership_ != nullptr) {
    membership_->receive(from, header, *message, opened.datagram.size(), local);
  }
}

void Session::dispatch(const Endpoint& from, const wire::Header& header, const wire::SessionMessage& message,
                       Micros local) {
  if (session_.phase == SessionPhase::kFailed) return;
  const auto* join = std::get_if<wire::Join>(&message);
  const auto* ping = std::get_if<wire::Ping>(&message);
  if (membership_ != nullptr && join != nullptr) return membership_->on_join(from, *join, local);
  if (membership_ != nullptr && ping != nullptr) return membership_->on_ping(from, *ping, local);
  if (!joiner_) return;
  if (join != nullptr) joiner_->on_join(from, *join, local);
  if (const auto* welcome = std::get_if<wire::Welcome>(&message)) {
    joiner_->on_welcome(from, header, *welcome);
    if (session_.phase == SessionPhase::kEntering && !pull_) {
      introducer_ = header.sender;
      pull_ = std::make_unique<TransferPull>(session_, from, *welcome, local);
    }
  }
  if (const auto* redirect = std::get_if<wire::Redirect>(&message)) {
    if (pull_) pull_->on_redirect(from, *redirect);
    joiner_->on_redirect(from, *redirect, local);
  }
  if (const auto* refuse = std::get_if<wire::Refuse>(&message)) joiner_->on_refuse(from, *refuse, local);
  const auto* pong = std::get_if<wire::Pong>(&message);
  if (pong != nullptr && pull_ && !settled_) pull_->on_pong(from, *pong, local);
}

// Magic, version, kind and tag are at the same place in every version of the protocol, and a Join always fills a
// datagram of the largest size. So a joiner of another version gets an answer that it cannot read, but whose version it
// can see. Nothing smaller is answered: two versions would answer each other's answers.
void Session::other_version(const Endpoint& from, std::size_t bytes, std::uint8_t version, Micros local) {
  if (session_.phase == SessionPhase::kFailed) return;
  if (bytes < wire::kMaxDatagram) {
    if (joiner_) joiner_->on_other_version(from, version);
    return;
  }
  if (!session_.may_answer(local)) return;
  const std::string reason = "protocol version differs: " + std::to_string(wire::kProtocolVersion) +
                             " in the session, " + std::to_string(version) + " in the newcomer";
  session_.send(from, wire::Refuse{0, reason});
  session_.tell({.kind = SessionEvent::Kind::kRefused, .at = from, .text = reason});
}

void Session::advance(Micros local) {
  if (session_.phase == SessionPhase::kEntering) pull_->advance(local);
  if (session_.phase == SessionPhase::kMember && pull_ && !settled_) pull_->measure(local);
  if (session_.phase == SessionPhase::kJoining) joiner_->advance(local);
  next_due_ = local + SessionPace::kTick;
}

std::vector<SessionDatagram> Session::take_outgoing() {
  return std::exchange(session_.outgoing, {});
}

std::vector<SessionEvent> Session::take_events() {
  return std::exchange(session_.events, {});
}

}  // namespace padr::node
