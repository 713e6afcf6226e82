#include "tools/capture/keyring.h"

#include <algorithm>
#include <sstream>

#include "common/model/user_error.h"
#include "shell/files.h"
#include "shell/key_text.h"

namespace padr::capture {

Keyring::Keyring(const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    std::istringstream lines(shell::read_file("--keylog", file));
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
      ++number;
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      const auto entry = shell::parse_keylog_line(line);
      if (!entry)
        throw UserError("--keylog: line " + std::to_string(number) + " of '" + file +
                        "' is none that padr-peer --keylog writes");
      entries_.push_back({wire::short_id(entry->from), entry->key, 0});
    }
  }
}

Keyring::Result Keyring::read(const wire::SealedHeader& header, std::span<const std::byte> datagram) {
  bool known = false;
  for (auto it = entries_.begin(); it != entries_.end(); ++it) {
    if (it->sender != header.id) continue;
    known = true;
    // Late ones aside, the upper half is that of the last one or the next.
    for (const std::uint64_t upper : {it->upper, it->upper + 1}) {
      auto unsealed = wire::unseal_with(it->key, upper << 32U | header.number, datagram);
      if (!unsealed) continue;
      it->upper = upper;
      std::rotate(entries_.begin(), it, it + 1);
      return {Reading::kChecked, std::move(unsealed)};
    }
  }
  if (known) return {Reading::kWrong, std::nullopt};
  auto unsealed = wire::unseal_unchecked(datagram);
  const Reading reading = unsealed ? Reading::kUnchecked : Reading::kHidden;
  return {reading, std::move(unsealed)};
}

}  // namespace padr::capture
