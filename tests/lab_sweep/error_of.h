#pragma once

#include <string>

#include "common/model/user_error.h"

namespace padr::test {

/// The message of the UserError that `action` throws; "no error" if it throws none.
template <typename Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const UserError& e) {
    return e.what();
  }
  return "no error";
}

}  // namespace padr::test
