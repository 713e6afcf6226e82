#pragma once

#include <utility>
#include <vector>

namespace padr::lab {

/// Divides persons, ascending, into groups: who is related to somebody of a group belongs to it. By their least
/// persons.
template <typename Related>
std::vector<std::vector<int>> groups_of(std::vector<int> persons, const Related& related) {
  std::vector<std::vector<int>> groups;
  while (!persons.empty()) {
    std::vector<int> group{persons.front()};
    persons.erase(persons.begin());
    for (std::size_t i = 0; i < group.size(); ++i)
      std::erase_if(persons, [&](int q) {
        const bool belongs = related(group[i], q);
        if (belongs) group.push_back(q);
        return belongs;
      });
    groups.push_back(std::move(group));
  }
  return groups;
}

}  // namespace padr::lab
