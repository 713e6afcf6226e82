#include "tools/capture/keyring.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "common/model/user_error.h"
#include "shell/files.h"
#include "shell/key_text.h"

namespace padr::capture {

Keyring::Keyring(const std::vector<std::string>& files) {
  for (const std::string& path : files) load(files_.emplace_back(File{path}));
}

// A line that a peer has not written to its end yet is for the next time, except at first, when it has to be a key.
void Keyring::load(File& file) {
  const std::string all = shell::read_file("--keylog", file.path);
  const bool first = file.at == 0;
  while (file.at < all.size()) {
    const std::size_t end = all.find('\n', file.at);
    if (end == std::string::npos && !first) return;
    const std::string_view line = std::string_view(all).substr(file.at, end - file.at);
    file.at = end == std::string::npos ? all.size() : end + 1;
    ++file.lines;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const auto entry = shell::parse_keylog_line(line);
    if (!entry)
      throw UserError("--keylog: line " + std::to_string(file.lines) + " of '" + file.path +
                      "' is none that padr-peer --keylog writes");
    rings_[wire::short_id(entry->from)].keys.push_front(wire::Key{entry->key});
  }
}

bool Keyring::load_more() {
  bool more = false;
  for (File& file : files_) {
    std::error_code error;
    const auto size = std::filesystem::file_size(file.path, error);
    if (error || size <= file.at) continue;
    const std::size_t before = file.at;
    load(file);
    more = more || file.at > before;
  }
  return more;
}

std::optional<wire::Bytes> Keyring::opened(const wire::SealedHeader& header, std::span<const std::byte> datagram) {
  const auto ring = rings_.find(header.id);
  if (ring == rings_.end()) return std::nullopt;
  auto& [keys, upper] = ring->second;
  // Late ones aside, the upper half is that of the last one or the next.
  for (const std::uint64_t half : {upper, upper + 1}) {
    for (auto key = keys.begin(); key != keys.end(); ++key) {
      auto unsealed = wire::unseal_with(*key, half << 32U | header.number, datagram);
      if (!unsealed) continue;
      upper = half;
      keys.splice(keys.begin(), keys, key);
      return unsealed;
    }
  }
  return std::nullopt;
}

Keyring::Result Keyring::read(const wire::SealedHeader& header, std::span<const std::byte> datagram) {
  auto found = opened(header, datagram);
  if (!found && load_more()) found = opened(header, datagram);
  if (found) return {Reading::kChecked, std::move(found)};
  if (rings_.contains(header.id)) return {Reading::kWrong, std::nullopt};
  auto unsealed = wire::unseal_unchecked(datagram);
  const Reading reading = unsealed ? Reading::kUnchecked : Reading::kHidden;
  return {reading, std::move(unsealed)};
}

}  // namespace padr::capture
