#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/model/endpoint.h"

namespace padr::shell {

/// Keys of 32 bytes, secret or public, as 64 hexadecimal digits.
using KeyBytes = PublicKey;

std::string key_text(const KeyBytes& key);
/// White space around it does not matter; nothing if it is no key.
std::optional<KeyBytes> parse_key(std::string_view text);
/// The same into `key`, so that a secret is nowhere else; false, and `key` is worth nothing, if it is no key.
bool parse_key(std::string_view text, KeyBytes& key);

/// A line of --keylog: what datagrams of one program to another are sealed with.
struct KeylogEntry {
  KeyBytes from{};  ///< public key of the sender
  KeyBytes to{};
  KeyBytes key{};
};
std::string keylog_line(const KeylogEntry& entry);
/// Nothing if it is none.
std::optional<KeylogEntry> parse_keylog_line(std::string_view line);

}  // namespace padr::shell
