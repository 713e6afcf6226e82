#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "tools/lab/audit/members.h"

namespace padr::lab::audit {

/// What a member said with one number, and which traces have it.
struct Version {
  sync::Bundle update;
  std::vector<std::size_t> traces;  ///< ascending
  bool direct = false;              ///< some trace has it from the member itself
  PeerId passed_on_by = kNoPeer;    ///< else from this one
};

/// Speed that somebody said something has, m/s.
struct SaidSpeed {
  MemberId by = 0;
  float speed = 0;
};

/// All updates in all traces, each content once.
class Ledger {
 public:
  /// `passed_on_by`: kNoPeer if the trace has it from the member itself.
  void add(std::size_t trace, MemberId author, const sync::Bundle& update, PeerId passed_on_by);

  using Key = std::pair<MemberId, std::uint32_t>;  ///< author, number
  const std::map<Key, std::vector<Version>>& all() const { return all_; }
  /// The highest speed that anybody but `author` said in these ticks, m/s; 0: nobody said any.
  float fastest_said(Tick from, Tick to, MemberId but) const;

 private:
  std::map<Key, std::vector<Version>> all_;
  std::map<Tick, std::vector<SaidSpeed>> speeds_;
};

/// Two contents are the same, whoever has signed them.
bool same_content(const sync::Bundle& a, const sync::Bundle& b);

}  // namespace padr::lab::audit
