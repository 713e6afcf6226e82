// What the tests of the partition merge share.
#pragma once

#include <gtest/gtest.h>

#include <array>

#include "common/membership/partition_merge.h"
#include "tests/membership/rules.h"

namespace padr::test {

inline Endpoint keyed(int person) {
  Endpoint at = Situation::at(person);
  at.key[0] = static_cast<std::uint8_t>(1 + person);
  return at;
}

/// Three of us with a key, admitted at `ours`; persons 5, 6, ... were members until they were evicted.
struct Met {
  Met(const std::array<Tick, 3>& ours, int theirs) : s(9, 2), rules(s.session) {
    s.session.config.sealed = true;
    for (PeerId p = 0; p < 9; ++p) s.roster.seats[p].at = keyed(p);
    for (PeerId p = 3; p < 9; ++p) s.empty(p);
    s.roster.seats[0].since = ours[0];
    s.roster.seats[1].since = ours[1];
    s.roster.in_since = ours[2];
    for (int person = 5; person < 5 + theirs; ++person) rules.remember({keyed(person), 10, 100}, 100);
    for (PeerId p = 3; p < 12; ++p) probe.members.push_back({p, 1U + p, 0});
  }
  void probed_by(int first, int last) {
    for (int person = first; person <= last; ++person) {
      probe.incarnation = 1U + static_cast<std::uint32_t>(person);
      rules.on_probe(keyed(person), static_cast<PeerId>(person), probe, wire::kMaxDatagram, s.view(), 0, out);
    }
  }
  bool yields() const { return rules.winner(s.view()).has_value(); }

  Situation s;
  ListedCommands out;
  node::PartitionMerge rules;
  wire::Probe probe;
};

}  // namespace padr::test
