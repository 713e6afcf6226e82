#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "common/monitor/telemetry.h"

namespace padr::monitor {

/// The columns of places that a piece may have besides its flags.
template <typename T>
struct Columns;
template <>
struct Columns<Frame> {
  static constexpr std::array kAll{&Frame::shown, &Frame::live, &Frame::predicted};
};
template <>
struct Columns<Agreed> {
  static constexpr std::array kAll{&Agreed::at};
};

/// Puts together what comes as ranges of entities, one datagram each: Frame or Agreed. Pieces may be lost, doubled and
/// out of order; a tick whose pieces do not all come is given up when newer ones need its place.
template <typename T>
class Pieces {
 public:
  /// The whole one that this piece completes, null if it does not.
  std::shared_ptr<const T> add(const T& piece) {
    const std::size_t n = piece.flags.size();
    if (n == 0 || piece.first + n > piece.total || is_done(piece.tick)) return nullptr;
    Partial* p = place_for(piece);
    if (p == nullptr) return nullptr;
    for (std::size_t i = 0; i < n; ++i) {
      if (p->has[piece.first + i] == 0) ++p->count;
      p->has[piece.first + i] = 1;
    }
    T& whole = *p->whole;
    std::copy(piece.flags.begin(), piece.flags.end(), whole.flags.begin() + piece.first);
    for (const auto column : Columns<T>::kAll) {
      if ((piece.*column).size() != n) continue;
      (whole.*column).resize(piece.total);
      std::copy((piece.*column).begin(), (piece.*column).end(), (whole.*column).begin() + piece.first);
    }
    if (p->count < piece.total) return nullptr;
    std::shared_ptr<const T> done = std::move(p->whole);
    partial_.erase(partial_.begin() + (p - partial_.data()));
    done_.push_back(done->tick);
    if (done_.size() > kRemembered) done_.pop_front();
    return done;
  }

  void clear() {
    partial_.clear();
    done_.clear();
  }

 private:
  static constexpr std::size_t kAtOnce = 4;
  static constexpr std::size_t kRemembered = 16;
  struct Partial {
    std::shared_ptr<T> whole;
    std::vector<char> has;  ///< by entity
    std::size_t count = 0;
  };

  bool is_done(Tick t) const { return std::find(done_.begin(), done_.end(), t) != done_.end(); }

  Partial* place_for(const T& piece) {
    for (Partial& p : partial_)
      if (p.whole->tick == piece.tick) return p.whole->total == piece.total ? &p : nullptr;
    if (partial_.size() == kAtOnce) {
      const auto oldest = std::min_element(partial_.begin(), partial_.end(), [](const Partial& a, const Partial& b) {
        return a.whole->tick < b.whole->tick;
      });
      if (oldest->whole->tick > piece.tick) return nullptr;
      partial_.erase(oldest);
    }
    Partial p{std::make_shared<T>(piece), std::vector<char>(piece.total, 0), 0};
    p.whole->first = 0;
    p.whole->flags.assign(piece.total, {});
    for (const auto column : Columns<T>::kAll) (*p.whole.*column).clear();
    partial_.push_back(std::move(p));
    return &partial_.back();
  }

  std::vector<Partial> partial_;
  std::deque<Tick> done_;
};

}  // namespace padr::monitor
