#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "common/capture/pcapng_writer.h"
#include "common/model/endpoint.h"
#include "peer/background_file.h"
#include "peer/options.h"
#include "shell/udp_socket.h"

namespace padr::peer {

/// --pcap: everything that the socket sends and receives, as a packet capture. The IP and UDP headers are ours, made
/// of the addresses that the system uses. Never waits for the disk: what that cannot take is left out and counted.
class PacketLog {
 public:
  /// Opens the file: throws UserError if that cannot be. `socket` must outlive it.
  PacketLog(const Options& options, const shell::UdpSocket& socket);

  /// Nanoseconds since 1970, for the two below: taken before a datagram is sent, or once it is there.
  static std::int64_t now();
  void sent(const Endpoint& to, std::span<const std::byte> datagram, std::int64_t time);
  void received(const Endpoint& from, std::span<const std::byte> datagram, std::int64_t time);

  /// Datagrams that are missing because the disk could not keep up.
  std::uint64_t dropped() const { return dropped_; }
  /// Why something could not be written; then nothing more is. Empty: all could.
  std::string failure() { return file_.failure(); }
  /// Throws std::system_error if something could not be written.
  void close();

 private:
  const Endpoint& own_address(const Endpoint& towards);
  void write(const Endpoint& from, const Endpoint& to, std::span<const std::byte> datagram, std::int64_t time,
             capture::Direction direction);

  const shell::UdpSocket& socket_;
  Endpoint local_;
  std::map<Endpoint, Endpoint> own_;  ///< the own address by whom it is for, if the socket is bound to all of them
  BackgroundFile file_;
  std::uint64_t dropped_ = 0;
  std::uint16_t id_ = 0;
  std::vector<std::byte> packet_;
  capture::PcapngWriter writer_;
};

}  // namespace padr::peer
