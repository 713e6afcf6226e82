#include "shell/secrets.h"

#include <fcntl.h>
#include <strings.h>
#include <sys/resource.h>
#include <unistd.h>

#ifdef __linux__
#include <sys/prctl.h>
#endif

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>

#include "common/model/user_error.h"

namespace padr::shell {

void protect_memory() {
  const rlimit none{0, 0};
  if (::setrlimit(RLIMIT_CORE, &none) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot switch core dumps off");
#ifdef __linux__
  // What pipes core dumps to a program does not heed the limit.
  if (::prctl(PR_SET_DUMPABLE, 0, 0, 0, 0) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot protect the memory of this process");
#endif
}

SecretText::SecretText(std::string_view flag, const std::string& path) {
  const auto bad = [&](const std::string& why) {
    return UserError(std::string(flag) + ": cannot read '" + path + "': " + why);
  };
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) throw bad(std::generic_category().message(errno));
  ssize_t count = 1;
  while (count > 0 && size_ < bytes_.size()) {
    do {
      count = ::read(file, bytes_.data() + size_, bytes_.size() - size_);
    } while (count < 0 && errno == EINTR);
    size_ += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  }
  const int why = errno;
  ::close(file);
  if (count >= 0 && size_ <= kMost) return;
  ::explicit_bzero(bytes_.data(), bytes_.size());  // a constructor that throws has no destructor
  throw bad(count < 0 ? std::generic_category().message(why) : "it is larger than " + std::to_string(kMost) + " bytes");
}

SecretText::SecretText(const char* variable) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): before any thread is there, and nobody else sets variables
  char* value = std::getenv(variable);
  if (value == nullptr) return;
  const std::size_t whole = std::strlen(value);
  size_ = std::min(whole, bytes_.size());
  std::copy_n(value, size_, bytes_.begin());
  ::explicit_bzero(value, whole);
  ::unsetenv(variable);  // NOLINT(concurrency-mt-unsafe): as above
}

SecretText::~SecretText() {
  ::explicit_bzero(bytes_.data(), bytes_.size());
}

}  // namespace padr::shell
