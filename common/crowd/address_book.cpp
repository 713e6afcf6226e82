#include "common/crowd/address_book.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <tuple>
#include <utility>

#include "common/model/portable_math.h"

namespace padr::crowd {
namespace {

constexpr std::size_t kDirections = 8;

/// Eighths of a turn, from the x axis on.
std::size_t direction(Region from, Region to) {
  const double angle = arc_tangent(static_cast<double>(to.y - from.y), static_cast<double>(to.x - from.x));
  const auto eighth = static_cast<int>(std::floor((angle + 3.14159265358979) * kDirections / 6.28318530717959));
  return static_cast<std::size_t>(std::clamp(eighth, 0, static_cast<int>(kDirections) - 1));
}

}  // namespace

bool Acquaintance::is_in(Region r) const {
  return contains(in, r);
}

bool Acquaintance::looks_for(Region r) const {
  return contains(seeks, r);
}

std::int64_t squared_distance(Region a, Region b) {
  const std::int64_t x = a.x - b.x;
  const std::int64_t y = a.y - b.y;
  return x * x + y * y;
}

std::int64_t squared_distance(const Acquaintance& a, Region r) {
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (const Region near : a.in) least = std::min(least, squared_distance(near, r));
  return least;
}

Acquaintance* AddressBook::find(const Endpoint& at) {
  const auto it = all_.find(at);
  return it == all_.end() ? nullptr : &it->second;
}

Acquaintance* AddressBook::note(const Endpoint& at) {
  if (Acquaintance* known = find(at)) return known;
  if (all_.size() >= kMost) {
    const auto hint = std::find_if(all_.begin(), all_.end(), [](const auto& a) {
      return !a.second.fellow && a.second.heard == Acquaintance::kNever;
    });
    if (hint == all_.end()) return nullptr;
    all_.erase(hint);
  }
  Acquaintance& a = all_[at];
  a.at = at;
  return &a;
}

// Who has ended stays for as long as a hint does, or the next one who has not noticed yet would bring it back.
void AddressBook::expire(Micros local) {
  std::erase_if(all_, [local](const auto& entry) {
    const Acquaintance& a = entry.second;
    if (ended(a)) return local - a.asked > kFresh + kHint;
    return !fresh(a, local) && local - a.hinted > kHint;
  });
}

void AddressBook::set_fellows(const Fellows& fellows) {
  auto next = fellows.begin();
  for (auto& [at, a] : all_) {
    while (next != fellows.end() && next->first < at) ++next;
    if (next == fellows.end() || next->first != at) a.fellow = false;
  }
  Acquaintance* a = nullptr;
  for (auto f = fellows.begin(); f != fellows.end(); ++f) {
    if (f == fellows.begin() || f->first != std::prev(f)->first) a = note(f->first);
    if (a == nullptr) continue;
    a->fellow = true;
    if (!a->is_in(f->second)) a->in.push_back(f->second);
  }
}

std::vector<Acquaintance*> AddressBook::all() {
  std::vector<Acquaintance*> some;
  some.reserve(all_.size());
  for (auto& [at, a] : all_)
    if (!ended(a)) some.push_back(&a);
  return some;
}

std::vector<Acquaintance*> AddressBook::nearest(Region r, std::size_t n) {
  std::vector<std::pair<std::int64_t, Acquaintance*>> by_distance;
  by_distance.reserve(all_.size());
  for (auto& [at, a] : all_)
    if (!ended(a) && !a.looks_for(r)) by_distance.emplace_back(squared_distance(a, r), &a);
  std::stable_sort(by_distance.begin(), by_distance.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  const auto far =
      std::find_if(by_distance.begin(), by_distance.end(), [](const auto& a) { return a.first > kNextTo; });
  const auto around = std::min(static_cast<std::size_t>(far - by_distance.begin()), kMostAround);
  by_distance.resize(std::min(std::max(n, around), by_distance.size()));
  std::vector<Acquaintance*> near;
  near.reserve(by_distance.size());
  for (const auto& [distance, a] : by_distance) near.push_back(a);
  return near;
}

std::vector<Acquaintance*> AddressBook::rivals(Region r, std::size_t n) {
  std::vector<Acquaintance*> rivals = all();
  std::erase_if(rivals, [r](const Acquaintance* a) { return !a->looks_for(r); });
  std::stable_sort(rivals.begin(), rivals.end(),
                   [](const Acquaintance* a, const Acquaintance* b) { return a->rank < b->rank; });
  rivals.resize(std::min(n, rivals.size()));
  return rivals;
}

std::vector<Acquaintance*> AddressBook::to_tell_of(Region r, std::size_t n, Rng& rng) {
  std::vector<std::pair<std::tuple<std::int64_t, int, std::uint32_t>, Acquaintance*>> some;
  some.reserve(all_.size());
  for (auto& [at, a] : all_) {
    if (ended(a)) continue;
    const bool rival = a.looks_for(r);
    some.push_back({{rival ? 0 : squared_distance(a, r), rival, rival ? a.rank : rng.next_u32()}, &a});
  }
  const auto end = some.begin() + static_cast<std::ptrdiff_t>(std::min(n, some.size()));
  std::partial_sort(some.begin(), end, some.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  some.erase(end, some.end());
  std::vector<Acquaintance*> nearest;
  nearest.reserve(some.size());
  for (const auto& [by, a] : some) nearest.push_back(a);
  return nearest;
}

std::vector<Acquaintance*> AddressBook::all_around(Region r) {
  std::array<std::pair<std::int64_t, Acquaintance*>, kDirections> best{};
  for (Acquaintance* a : all())
    for (const Region near : a->in) {
      if (near == r) continue;
      auto& [least, who] = best[direction(r, near)];
      const std::int64_t d = squared_distance(near, r);
      if (who == nullptr || d < least) std::tie(least, who) = std::pair(d, a);
    }
  std::vector<Acquaintance*> some;
  for (const auto& [d, a] : best)
    if (a != nullptr && std::find(some.begin(), some.end(), a) == some.end()) some.push_back(a);
  return some;
}

}  // namespace padr::crowd
