#include "tools/lab/alternatives/mailbox.h"

#include <algorithm>

namespace padr::lab::alternatives {

std::optional<Mailbox::Letter> Mailbox::open(std::span<const std::byte> datagram) const {
  wire::SealError error{};
  const auto opened = wire::open(datagram, error);
  const bool ours = opened && opened->header.kind == wire::Kind::kState && opened->header.session == config_.session &&
                    opened->header.sender < config_.peers && opened->header.sender != config_.self;
  if (!ours) return std::nullopt;
  return Letter{opened->header.sender, opened->payload};
}

void Mailbox::post(PeerId to, const BitWriter& payload, std::uint64_t states) {
  node::Outgoing o{to, wire::seal({wire::Kind::kState, config_.self, config_.session}, payload.bytes())};
  ++stats_.datagrams_sent;
  stats_.wire_bytes_sent += o.bytes.size() + node::kIpUdpBytes;
  stats_.states_sent += states;
  stats_.largest = std::max<std::uint64_t>(stats_.largest, o.bytes.size());
  outgoing_.push_back(std::move(o));
}

Tick whole_tick(std::uint32_t bits, Tick now) {
  const auto apart = static_cast<std::int16_t>(static_cast<std::uint16_t>(bits - static_cast<std::uint32_t>(now)));
  return now + apart;
}

}  // namespace padr::lab::alternatives
