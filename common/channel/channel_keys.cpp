#include "common/channel/channel_keys.h"

#include <algorithm>

namespace padr::node {

ChannelKeys::ChannelKeys(const wire::PairKeys& first, bool begins, Micros local)
    : first_(first), present_(first), begins_(begins), since_(local) {}

void ChannelKeys::restart(Micros local) {
  present_ = first_;
  former_in_.reset();
  offer_.reset();
  next_.reset();
  generation_ = 0;
  confirmed_ = true;
  since_ = local;
}

std::optional<wire::Rekey> ChannelKeys::due(Micros local, const RandomBytes& random) {
  forget(local);
  if (!offer_) {
    const Micros wait = kEvery + (begins_ ? 0 : kPatience);
    if (!confirmed_ || former_in_ || (generation_ > 0 && local - since_ < wait)) return std::nullopt;
    offer(random);
    again_ = local;
  }
  if (local < again_) return std::nullopt;
  again_ = local + pace_;
  pace_ = std::min(2 * pace_, kSlowest);
  return told();
}

const wire::Key* ChannelKeys::key_of(std::uint32_t generation) const {
  if (generation == generation_ + 1) return &present_.in;
  return generation == generation_ && former_in_ ? &*former_in_ : nullptr;
}

ChannelKeys::Answer ChannelKeys::take(const wire::Rekey& theirs, Micros local, const RandomBytes& random) {
  Answer a;
  if (theirs.generation == generation_) {
    a.confirm = theirs.exchange == exchange_;
    if (a.confirm || theirs.number < number_ || generation_ != 1) return a;
    // A new pair for the same generation: the other has gone back to the first keys.
    restart(local);
  }
  confirm(local);
  if (!offer_) {
    if (generation_ > 0 && local - began_ < kSoonest) return a;
    offer(random);
    again_ = local + kAgain;
  }
  // One that comes late is not of the pair that the other has now.
  if (next_ && next_->exchange != theirs.exchange && theirs.number < next_->number) return a;
  if (!next_ || next_->exchange != theirs.exchange) {
    if (!make(theirs)) return a;
    a.made = next_->keys;
  }
  if (theirs.has == wire::beginning_of(offer_->exchange)) {
    advance(local);
    a.confirm = true;
  } else {
    a.rekey = told();
  }
  return a;
}

void ChannelKeys::forget(Micros local) {
  if (confirmed_ && former_in_ && local - since_ >= kOverlap) former_in_.reset();
}

void ChannelKeys::offer(const RandomBytes& random) {
  Offer o;
  random(std::as_writable_bytes(std::span<std::uint8_t>(o.secret)));
  o.exchange = wire::exchange_key(o.secret);
  offer_ = o;
  pace_ = kAgain;
}

bool ChannelKeys::make(const wire::Rekey& theirs) {
  const auto keys = wire::next_keys(present_, offer_->secret, offer_->exchange, theirs.exchange);
  if (!keys) return false;
  former_in_.reset();
  next_ = Next{*keys, theirs.exchange, theirs.number};
  return true;
}

wire::Rekey ChannelKeys::told() const {
  return {offer_->exchange, 0, 0, generation_ + 1, next_ ? wire::beginning_of(next_->exchange) : 0};
}

void ChannelKeys::advance(Micros local) {
  former_in_ = present_.in;
  present_ = next_->keys;
  exchange_ = next_->exchange;
  number_ = next_->number;
  next_.reset();
  offer_.reset();
  ++generation_;
  ++rekeys_;
  confirmed_ = false;
  began_ = local;
}

void ChannelKeys::confirm(Micros local) {
  if (confirmed_) return;
  confirmed_ = true;
  since_ = local;
}

}  // namespace padr::node
