#pragma once

#include <string>

namespace padr::scenarios {

/// The shortest decimal text that reads back as exactly `v`, the same on every machine and in every locale.
std::string number_text(double v);
std::string number_text(float v);

/// `v` to three significant digits, for measurements in messages to people.
std::string rough_text(double v);

}  // namespace padr::scenarios
