#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/wire/sealed.h"

namespace padr::capture {

/// The keys of padr-peer --keylog, and what can be read with them, or without any.
class Keyring {
 public:
  /// Throws UserError if a file cannot be read or has a line that is none of a keylog.
  explicit Keyring(const std::vector<std::string>& files);

  enum class Reading : std::uint8_t {
    kChecked,    ///< its seal is right
    kUnchecked,  ///< readable, and there is no key of its sender
    kHidden,     ///< encrypted, and there is no key of its sender
    kWrong,      ///< there are keys of its sender, and none fits: damaged or forged
  };
  struct Result {
    Reading reading = Reading::kWrong;
    std::optional<wire::Bytes> unsealed;  ///< of kChecked and kUnchecked
  };
  /// Of a datagram that wire::read_sealed takes.
  Result read(const wire::SealedHeader& header, std::span<const std::byte> datagram);

 private:
  struct Entry {
    std::uint32_t sender = 0;
    wire::Key key{};
    std::uint64_t upper = 0;  ///< half of the last number
  };
  std::vector<Entry> entries_;  ///< those that were of use last are in front
};

}  // namespace padr::capture
