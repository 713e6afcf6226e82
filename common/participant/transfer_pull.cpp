#include "common/participant/transfer_pull.h"

#include <algorithm>

namespace padr::node {

TransferPull::TransferPull(SessionState& session, const Endpoint& by, const wire::Welcome& welcome, Micros local)
    : session_(session), by_(by), nonce_(welcome.nonce), cookie_(welcome.cookie), begun_(local), heard_(local) {
  advance(local);
}

void TransferPull::on_pong(const Endpoint& from, const wire::Pong& pong, Micros local) {
  if (from != by_ || pong.sent > local || local - pong.sent > kOldestPong || pong.sent < session_.born) return;
  heard_ = local;
  unanswered_ = 0;
  offset_.add(pong.sent, pong.session, local);
  if (offset_.is_contradictory()) lose("has told times that do not fit each other");
  if (ready_ && !lost()) set_clock();
  finish_if_complete();
}

void TransferPull::on_piece(const Endpoint& from, const wire::Piece& piece, Micros local) {
  if (from != by_ || piece.nonce != nonce_ || ready_) return;
  if (pieces_.empty()) {
    pieces_.resize(piece.count);
    missing_ = piece.count;
  }
  if (piece.count != pieces_.size() || !pieces_[piece.index].empty()) return;
  heard_ = local;
  pieces_[piece.index] = piece.bytes;
  --missing_;
  --wanted_;
  came_ = local;
  finish_if_complete();
}

void TransferPull::finish_if_complete() {
  if (ready_ || pieces_.empty() || missing_ > 0 || offset_.samples() < kSamples) return;
  for (const wire::Bytes& p : pieces_) transfer_.insert(transfer_.end(), p.begin(), p.end());
  set_clock();
  ready_ = true;
}

// An introducer can lie about the time.
void TransferPull::set_clock() {
  const Micros most = session_.config.most_offset.value_or(std::numeric_limits<Micros>::max());
  session_.clock.set(std::max(std::min(offset_.offset(), most), least_offset_));
}

void TransferPull::pull(Micros local) {
  if (pulled_ > came_) {
    want_ = std::max(1, want_ / 2);
    ++fruitless_;
  } else {
    if (wanted_ <= 0) want_ = std::min(kMostWanted, 2 * want_);
    fruitless_ = 0;
  }
  pulled_ = local;
  wire::Pull p{nonce_, 0, 0, cookie_};
  const auto first = std::find_if(pieces_.begin(), pieces_.end(), [](const wire::Bytes& b) { return b.empty(); });
  p.from = static_cast<std::uint32_t>(first - pieces_.begin());
  wanted_ = 0;
  for (std::size_t i = 0; i < kMostWanted && wanted_ < want_; ++i) {
    const bool is_missing = pieces_.empty() || (p.from + i < pieces_.size() && pieces_[p.from + i].empty());
    if (!is_missing) continue;
    p.wanted |= std::uint64_t{1} << i;
    ++wanted_;
  }
  session_.send(by_, p);
}

// What has been asked for may still be on its way.
bool TransferPull::pull_is_due(Micros local) const {
  if (!pieces_.empty() && missing_ == 0) return false;
  if (wanted_ <= 0) return true;
  const Micros again = std::max(kAgain, offset_.round_trip() + offset_.round_trip() / 2);
  return local - std::max(pulled_, came_) >= again << std::min(fruitless_, kPullDoublings);
}

// An introducer that lies may answer for ever, and never send all. Before the first piece, others may have their turn.
bool TransferPull::comes_to_nothing(Micros local) const {
  return missing_ > 0 && fruitless_ >= kMostFruitless && local - came_ > kPatience;
}

void TransferPull::on_redirect(const Endpoint& from, const wire::Redirect& redirect) {
  if (from == by_ && redirect.nonce == nonce_ && entering_) lose("has named another peer to ask");
}

// Fails with the next advance only: a caller that looks between two advances must not take a restart for the end.
void TransferPull::on_unreachable(const Endpoint& at) {
  if (at == by_) lose("has ended");
}

void TransferPull::lose(std::string_view by) {
  if (!lost()) lost_ = by;
}

std::string_view TransferPull::why_late(Micros local) const {
  if (local - heard_ > kPatience) return "is silent";
  if (comes_to_nothing(local)) return "does not send all of the world";
  if (local - begun_ > kLongest) return ready_ ? "lets nobody in" : "does not send the world";
  return {};
}

void TransferPull::advance(Micros local) {
  lose(why_late(local));
  if (lost()) return session_.fail(to_string(by_) + " " + std::string(lost_) + ", before this peer was admitted");
  measure(local);
  if (pull_is_due(local)) pull(local);
  if (entering_ && local - entered_ >= (entries_ < kOften ? kAgain : kRarely)) enter(local);
}

// Once the clock is synchronised, Pings only show whether the introducer is alive; once we ask for admission, none go
// out.
void TransferPull::measure(Micros local) {
  const bool measures = offset_.samples() < OffsetEstimator::kKept;
  if (local - heard_ > kPatience) return;  // it has ended, or has forgotten us
  const Micros often =
      std::min(kPing << std::min(static_cast<std::size_t>(unanswered_) / kSamples, kDoublings), kIdlePing);
  if (local - pinged_ < (measures ? often : kIdlePing) || (!measures && entering_)) return;
  pinged_ = local;
  ++unanswered_;
  session_.send(by_, wire::Ping{local});
}

void TransferPull::clock_is_ahead(Micros at_least) {
  least_offset_ = at_least;
  set_clock();
}

void TransferPull::enter(Micros local) {
  entering_ = true;
  entered_ = local;
  ++entries_;
  session_.send(by_, wire::Enter{nonce_});
}

}  // namespace padr::node
