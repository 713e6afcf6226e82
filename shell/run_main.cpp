#include "shell/run_main.h"

#include <cerrno>
#include <cstdio>
#include <exception>
#include <string>
#include <system_error>

#include "common/model/user_error.h"

namespace padr::shell {
namespace {

void say(std::string_view program, const char* what) {
  std::fprintf(stderr, "%s: %s\n", std::string(program).c_str(), what);
}

/// What is printed may be buffered until the end, and nobody may have asked what became of it.
void complete_output() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  cannot_write_to_standard_output();
}

}  // namespace

void cannot_write_to_standard_output() {
  const int why = errno != 0 ? errno : EIO;
  std::clearerr(stdout);
  throw std::system_error(why, std::generic_category(), "cannot write to standard output");
}

int run_main(std::string_view program, const std::function<int()>& body) {
  try {
    const int code = body();
    complete_output();
    return code;
  } catch (const UserError& e) {
    say(program, e.what());
    return kExitUsage;
  } catch (const std::exception& e) {
    say(program, e.what());
    return kExitFailure;
  }
}

}  // namespace padr::shell
