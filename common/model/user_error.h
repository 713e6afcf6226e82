#pragma once

#include <stdexcept>
#include <string>

namespace padr {

/// A mistake in what a person gave us (a flag, a file, a specification): one line that names what, where, and what is
/// allowed. Thrown by parsers of user input, caught once in each program's main, which prints it and exits with 2.
class UserError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace padr
