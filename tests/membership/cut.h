#pragma once

#include <ostream>
#include <string>
#include <vector>

namespace padr::test {

/// Which ways between two persons of four are cut.
struct Cut {
  std::string name;
  int a;
  int b;
  bool there;
  bool back;
};

inline void PrintTo(const Cut& c, std::ostream* out) {
  *out << c.name;
}

inline const std::vector<Cut> kCuts{{"coordinator_and_another", 0, 2, true, true},
                                    {"coordinator_and_its_heir", 0, 1, true, true},
                                    {"from_the_coordinator", 0, 2, true, false},
                                    {"to_the_coordinator", 0, 2, false, true},
                                    {"two_others", 1, 2, true, true},
                                    {"one_way", 3, 1, true, false}};

}  // namespace padr::test
