#pragma once

#include <cstdint>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/wire/sealed.h"

namespace padr::capture {

/// The keys of padr-peer --keylog, and what can be read with them, or without any.
class Keyring {
 public:
  /// Throws UserError if a file cannot be read or has a line that is none of a keylog. Keys that are added to the files
  /// later are found when they are needed.
  explicit Keyring(const std::vector<std::string>& files);

  enum class Reading : std::uint8_t {
    kChecked,    ///< its seal is right
    kUnchecked,  ///< readable, and there is no key of its sender
    kHidden,     ///< encrypted, and there is no key of its sender
    kWrong,      ///< there are keys of its sender, and none fits: damaged, forged, or of another link
  };
  struct Result {
    Reading reading = Reading::kWrong;
    std::optional<wire::Bytes> unsealed;  ///< of kChecked and kUnchecked
  };
  /// Of a datagram that wire::read_sealed takes.
  Result read(const wire::SealedHeader& header, std::span<const std::byte> datagram);

 private:
  /// What one sender seals with.
  struct Ring {
    std::list<wire::Key> keys;  ///< those that were of use last are in front
    std::uint64_t upper = 0;    ///< half of the last number, which all keys share
  };
  /// One more key file, from `at` on: what has been read of it.
  struct File {
    std::string path;
    std::size_t at = 0;
    int lines = 0;
  };
  void load(File& file);
  /// Whether a peer has written more keys since.
  bool load_more();
  std::optional<wire::Bytes> opened(const wire::SealedHeader& header, std::span<const std::byte> datagram);
  std::vector<File> files_;
  std::map<std::uint32_t, Ring> rings_;  ///< by the sender's short id
};

}  // namespace padr::capture
