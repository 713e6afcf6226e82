#include "shell/run_main.h"

#include <cstdio>
#include <exception>
#include <string>

#include "common/model/user_error.h"

namespace padr::shell {
namespace {

void say(std::string_view program, const char* what) {
  std::fprintf(stderr, "%s: %s\n", std::string(program).c_str(), what);
}

}  // namespace

int run_main(std::string_view program, const std::function<int()>& body) {
  try {
    return body();
  } catch (const UserError& e) {
    say(program, e.what());
    return kExitUsage;
  } catch (const std::exception& e) {
    say(program, e.what());
    return kExitFailure;
  }
}

}  // namespace padr::shell
