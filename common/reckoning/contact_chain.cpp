#include "common/reckoning/contact_chain.h"

#include <algorithm>

namespace padr::sync {

ContactChain::ContactChain(int bodies, EntityId avatar, Tick patience)
    : avatar_(avatar),
      patience_(patience),
      direct_(static_cast<std::size_t>(bodies), kNever),
      chain_(static_cast<std::size_t>(bodies), kNever) {}

void reach(const std::vector<Contact>& contacts, int bodies, std::vector<char>& marked, std::vector<EntityId>& found) {
  for (bool grew = true; grew;) {
    grew = false;
    for (const Contact& c : contacts) {
      if (marked[c.first] == marked[c.second]) continue;
      const EntityId next = marked[c.first] != 0 ? c.second : c.first;
      if (next >= bodies) continue;
      marked[next] = 1;
      found.push_back(next);
      grew = true;
    }
  }
}

const ChainChanges& ContactChain::update(const std::vector<Contact>& contacts, Tick now) {
  for (std::vector<EntityId>* ids : {&changes_.begun, &changes_.ended, &changes_.joined, &changes_.left}) ids->clear();
  reached_.assign(direct_.size() + kMaxPeers, 0);
  reached_[avatar_] = 1;
  looked_at_ = linked_;
  reach(contacts, static_cast<int>(direct_.size()), reached_, looked_at_);
  std::sort(looked_at_.begin(), looked_at_.end());
  looked_at_.erase(std::unique(looked_at_.begin(), looked_at_.end()), looked_at_.end());
  linked_.clear();
  const auto touches = [&](EntityId b) {
    return std::binary_search(contacts.begin(), contacts.end(), Contact{b, avatar_});
  };
  for (const EntityId b : looked_at_) {
    Tick& direct = direct_[b];
    if (reached_[b] != 0 && touches(b)) {
      if (direct == kNever) changes_.begun.push_back(b);
      direct = now;
    } else if (direct != kNever && now - direct > patience_) {
      direct = kNever;
      changes_.ended.push_back(b);
    }
    Tick& link = chain_[b];
    if (reached_[b] != 0) {
      if (link == kNever && direct == kNever) changes_.joined.push_back(b);
      link = now;
    } else if (link != kNever && now - link > patience_) {
      link = kNever;
      changes_.left.push_back(b);
    }
    if (direct != kNever || link != kNever) linked_.push_back(b);
  }
  return changes_;
}

}  // namespace padr::sync
