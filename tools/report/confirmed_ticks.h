#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tools/report/report.h"
#include "tools/report/survey.h"

namespace padr::report {

/// Whether all peers confirmed the same worlds.
class ConfirmedTicks {
 public:
  /// `incarnations` must outlive it.
  explicit ConfirmedTicks(const std::vector<Survey>& incarnations) : incarnations_(incarnations) {}
  void add(std::size_t incarnation, Tick tick, std::uint64_t hash);
  /// `by` declared it gone while it went on: without its last updates, which came too late. Of two parts that have
  /// declared each other gone, the larger one is the session; of two as large, the one with the first incarnation.
  void give_up(std::size_t incarnation, std::size_t by) { declared_gone_.insert({incarnation, by}); }
  ConfirmedCheck compare() const;

 private:
  struct Entry {
    std::size_t incarnation;
    std::uint64_t hash;
  };
  std::string sides(const std::vector<Entry>& entries) const;
  void judge_given_up(const std::vector<Entry>& given_up, const std::vector<Entry>& others,
                      ConfirmedCheck& check) const;

  std::set<std::size_t> given_up() const;

  const std::vector<Survey>& incarnations_;
  std::set<std::pair<std::size_t, std::size_t>> declared_gone_;  ///< who, by whom
  std::vector<std::vector<Entry>> ticks_;
};

}  // namespace padr::report
