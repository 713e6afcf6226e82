#pragma once

#include <cstdint>
#include <map>

#include "tools/lab/chaos/lies.h"
#include "tools/lab/chaos/script.h"
#include "tools/lab/testbed/judge.h"

namespace padr::lab {

/// The liar of a script: one of those who begin, and when it has ended, often a peer that starts later.
class LiarPart {
 public:
  /// All must outlive it. Before anybody starts.
  LiarPart(VirtualNetwork& network, Judge& judge, const ChaosScript& script);

  /// Begins and ends lies as the script says; call it often.
  void advance();
  /// Datagrams changed, added or withheld so far.
  std::uint64_t told() const;
  /// Whether it has lied while it took itself for the coordinator.
  bool led() const { return led_; }

 private:
  struct Part {
    Liar liar;
    Plot plot;  ///< once it plays
  };
  bool is_to_lie(int person);
  bool lies_now() const;

  VirtualNetwork& network_;
  Judge& judge_;
  const ChaosScript& script_;
  Rng rng_;
  bool led_ = false;
  std::map<int, Part> parts_;  ///< by person
};

}  // namespace padr::lab
