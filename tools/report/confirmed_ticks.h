#pragma once

#include <cstdint>
#include <set>
#include <string>
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
  /// Others declared it gone while it went on: without its last updates, which came too late for them.
  void give_up(std::size_t incarnation) { given_up_.insert(incarnation); }
  ConfirmedCheck compare() const;

 private:
  struct Entry {
    std::size_t incarnation;
    std::uint64_t hash;
  };
  std::string sides(const std::vector<Entry>& entries) const;
  void judge_given_up(const std::vector<Entry>& given_up, const std::vector<Entry>& others,
                      ConfirmedCheck& check) const;

  bool is_given_up(std::size_t incarnation) const;

  const std::vector<Survey>& incarnations_;
  std::set<std::size_t> given_up_;
  std::vector<std::vector<Entry>> ticks_;
};

}  // namespace padr::report
