#include "peer/packet_log.h"

#include <chrono>

#include "common/capture/ip_packet.h"
#include "shell/command_line.h"
#include "shell/revision.h"

namespace padr::peer {
namespace {

using namespace std::chrono_literals;

constexpr auto kFlush = 500ms;
/// Bytes that may wait for a slow disk: some minutes of a busy session.
constexpr std::size_t kMostWaiting = 64U << 20U;
constexpr std::size_t kMostAddresses = 4096;

capture::PcapngWriter::About about(const Options& o, const Endpoint& local) {
  capture::PcapngWriter::About a;
  a.comment = shell::shell_line(o.command) + "\nscenario " + o.scenario.label + " seed " +
              std::to_string(o.scenario.seed) + ", netem seed " + std::to_string(o.netem_seed);
  a.application = "padr-peer " + std::string(shell::version()) + " (revision " + std::string(shell::revision()) + ")";
  a.interface = to_string(local);
  return a;
}

}  // namespace

PacketLog::PacketLog(const Options& options, const shell::UdpSocket& socket)
    : socket_(socket),
      local_(shell::to_endpoint(socket.local())),
      file_("--pcap", options.pcap, kFlush, kMostWaiting),
      writer_(about(options, local_), [this](std::span<const std::byte> block) {
        if (!file_.append(block)) ++dropped_;
      }) {}

std::int64_t PacketLog::now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

const Endpoint& PacketLog::own_address(const Endpoint& towards) {
  if (!socket_.local().address().is_unspecified()) return local_;
  const auto known = own_.find(towards);
  if (known != own_.end()) return known->second;
  if (own_.size() >= kMostAddresses) own_.clear();
  return own_[towards] = socket_.local_towards(towards);
}

void PacketLog::write(const Endpoint& from, const Endpoint& to, std::span<const std::byte> datagram, std::int64_t time,
                      capture::Direction direction) {
  capture::make_udp_packet(from, to, datagram, id_++, packet_);
  writer_.packet(time, direction, packet_);
}

void PacketLog::sent(const Endpoint& to, std::span<const std::byte> datagram, std::int64_t time) {
  write(own_address(to), to, datagram, time, capture::Direction::kOutbound);
}

void PacketLog::received(const Endpoint& from, std::span<const std::byte> datagram, std::int64_t time) {
  write(from, own_address(from), datagram, time, capture::Direction::kInbound);
}

void PacketLog::close() {
  if (dropped_ > 0) writer_.dropped(now(), dropped_);
  file_.close();
}

}  // namespace padr::peer
