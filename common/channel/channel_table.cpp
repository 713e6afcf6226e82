// Whom SecureChannels remembers, and who is forgotten for somebody else.
#include <algorithm>
#include <tuple>

#include "common/channel/secure_channels.h"

namespace padr::node {
namespace {

/// Whoever has been quiet for so long may be forgotten for somebody else.
constexpr Micros kForgettable = 60'000'000;

}  // namespace

std::optional<SecureChannels::Channel> SecureChannels::channel_to(const PublicKey& key, const Endpoint& at,
                                                                  Micros local) const {
  const auto keys = wire::pair_keys(config_.session, secret_, public_, key);
  if (!keys) return std::nullopt;
  Channel c(key, ChannelKeys(*keys, public_ < key, local));
  c.at = at.place();
  c.home = c.at;
  c.name = c.at;
  c.name.key = key;
  c.heard = local;
  if (const auto before = forgotten_.find(key); before != forgotten_.end()) c.window.start_after(before->second);
  return c;
}

// Whoever may be forgotten goes before all others. Once, as long as all had been met, of two that had just been told of
// the first gave way to the second and the second to the first, and neither was ever heard.
std::list<SecureChannels::Channel>::iterator SecureChannels::quietest(Micros local) {
  const auto order = [local](const Channel& c) { return std::tuple(local - c.heard < kForgettable, c.met, c.heard); };
  return std::min_element(channels_.begin(), channels_.end(),
                          [&](const Channel& a, const Channel& b) { return order(a) < order(b); });
}

bool SecureChannels::has_room(Micros local) {
  return channels_.size() < kMostChannels || local - quietest(local)->heard >= kForgettable;
}

// What the network has kept of a forgotten peer must not pass when the peer is back.
void SecureChannels::make_room(Micros local) {
  const auto out = quietest(local);
  const std::uint64_t newest = out->window.newest();
  if (newest > 0 && forgotten_.insert_or_assign(out->key, newest).second) {
    forgotten_order_.push_back(out->key);
    if (forgotten_order_.size() > kMostForgotten) {
      forgotten_.erase(forgotten_order_.front());
      forgotten_order_.pop_front();
    }
  }
  channels_.erase(out);
}

SecureChannels::Channel& SecureChannels::keep(const Channel& c) {
  if (channels_.size() >= kMostChannels) make_room(c.heard);
  tell_keys(c.key, c.keys.first());
  channels_.push_back(c);
  return channels_.back();
}

void SecureChannels::tell_keys(const PublicKey& whose, const wire::PairKeys& keys) {
  if (!config_.on_key || keys_told_ == config_.most_keys) return;
  ++keys_told_;
  config_.on_key(public_, whose, keys.out);
  config_.on_key(whose, public_, keys.in);
}

// Those whom we were told of come in by force: their number is that of the session's slots and of who has been there.
SecureChannels::Channel* SecureChannels::make(const PublicKey& key, const Endpoint& at, Micros local) {
  auto c = channel_to(key, at, local);
  return c ? &keep(*c) : nullptr;
}

}  // namespace padr::node
