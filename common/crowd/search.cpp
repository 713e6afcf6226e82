#include "common/crowd/search.h"

#include <algorithm>
#include <utility>

namespace padr::crowd {

Micros Search::settle(Micros local) {
  if (settled_ == 0) settled_ = local;
  return settled_;
}

void Search::note_told(const Endpoint& by, Micros sent, Micros local) {
  noted_.try_emplace(by, local);
  told_[by] = sent;
}

// As long as the search finds nearer peers, a peer may be in the region.
void Search::note_nearest(const std::vector<Acquaintance*>& nearest, Micros local) {
  std::set<Endpoint> now;
  for (const Acquaintance* a : nearest) now.insert(a->at);
  const bool more = !std::includes(nearest_.begin(), nearest_.end(), now.begin(), now.end());
  if (more && local - began_ < kChanging) changed_ = local;
  nearest_ = std::move(now);
}

// It may have come in meanwhile, and who was there may have left.
bool Search::has_said(const Acquaintance& a, Micros since, Micros local) const {
  const auto told = told_.find(a.at);
  if (told == told_.end() || local - told->second > kJustNow) return false;
  const auto it = rumours_.find(a.at);
  const Rumour rumour = it == rumours_.end() ? Rumour{} : it->second;
  return told->second >= std::max({since, noted_.at(a.at), rumour.there, rumour.looks});
}

std::vector<Acquaintance*> Search::rumoured(AddressBook& book, Micros local) const {
  std::vector<Acquaintance*> some;
  for (const auto& [at, rumour] : rumours_) {
    Acquaintance* a = book.find(at);
    if (a != nullptr && !AddressBook::ended(*a) && !has_said(*a, began_, local)) some.push_back(a);
  }
  return some;
}

void Search::forget_unknown(AddressBook& book) {
  const auto unknown = [&book](const auto& entry) { return book.find(entry.first) == nullptr; };
  std::erase_if(noted_, unknown);
  std::erase_if(told_, unknown);
  std::erase_if(rumours_, unknown);
}

}  // namespace padr::crowd
