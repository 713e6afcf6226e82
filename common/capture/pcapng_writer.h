#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/capture/frame.h"

namespace padr::capture {

/// Writes a pcapng file of one section with one interface, in little endian: raw IP packets with nanoseconds.
class PcapngWriter {
 public:
  using ByteSink = std::function<void(std::span<const std::byte>)>;

  struct About {
    std::string comment;      ///< of the section
    std::string application;  ///< that wrote it
    std::string interface;    ///< its name
    std::string filter;       ///< what the interface lets through, for people
  };

  /// Writes the section header and the interface. Texts are cut at 65,535 bytes. `sink` gets whole blocks.
  PcapngWriter(const About& about, ByteSink sink);

  /// `time_ns`: since 1970, UTC, not negative. `ip`: 262,144 bytes at most.
  void packet(std::int64_t time_ns, Direction direction, std::span<const std::byte> ip);
  /// Says how many packets are missing because they could not be written (an interface statistics block).
  void dropped(std::int64_t time_ns, std::uint64_t packets);

 private:
  void begin(std::uint32_t type);
  void put16(std::uint32_t v);
  void put32(std::uint32_t v);
  void put_time(std::int64_t ns);
  void put_bytes(std::span<const std::byte> bytes);
  void option(std::uint32_t code, std::span<const std::byte> value);
  void option(std::uint32_t code, const std::string& text);
  void end();

  ByteSink sink_;
  std::vector<std::byte> block_;
};

}  // namespace padr::capture
