#pragma once

#include <cstdint>
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
  ConfirmedCheck compare() const;

 private:
  struct Entry {
    std::size_t incarnation;
    std::uint64_t hash;
  };
  std::string sides(const std::vector<Entry>& entries) const;
  void judge_given_up(const std::vector<Entry>& given_up, const std::vector<Entry>& others,
                      ConfirmedCheck& check) const;

  const std::vector<Survey>& incarnations_;
  std::vector<std::vector<Entry>> ticks_;
};

}  // namespace padr::report
