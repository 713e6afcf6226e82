#include "tools/lab/testbed/liar.h"

#include <utility>

#include "common/wire/codec.h"

namespace padr::lab {

std::vector<node::Parcel> Liar::tamper(node::Parcel parcel) {
  std::vector<node::Parcel> out;
  wire::SealError error{};
  const auto opened = says_nothing() ? std::nullopt : wire::open(parcel.bytes, error);
  if (!opened) {
    out.push_back(std::move(parcel));
    return out;
  }
  const wire::Header header = opened->header;
  if (header.kind == wire::Kind::kState && extra_)
    for (wire::Bytes& bytes : extra_(header, parcel.state_to)) {
      out.push_back({parcel.to, parcel.state_to, std::move(bytes)});
      ++told;
    }
  if (silence_ && silence_(header.kind, parcel.to, parcel.state_to)) {
    ++told;
    return out;
  }
  if (header.kind == wire::Kind::kState && lie_) change_state(parcel, *opened);
  if (header.kind == wire::Kind::kMembership && gossip_) change_membership(parcel, *opened);
  if (header.kind == wire::Kind::kSession && hosting_) change_session(parcel, *opened);
  out.push_back(std::move(parcel));
  return out;
}

// A lie that no longer fits a datagram is not told.
void Liar::change_state(node::Parcel& parcel, const wire::Opened& opened) {
  auto packet = wire::decode_state(opened.payload, opened.header.sender);
  if (!packet) return;
  lie_(*packet, parcel.state_to);
  for (sync::Bundle& b : packet->updates) sign(b, packet->incarnation);
  const wire::Bytes payload = wire::encode(*packet);
  if (payload.size() > wire::kMaxPayload) return;
  parcel.bytes = wire::seal(opened.header, payload);
  ++told;
}

void Liar::change_membership(node::Parcel& parcel, const wire::Opened& opened) {
  auto message = wire::decode_membership(opened.payload);
  if (!message) return;
  gossip_(*message);
  parcel.bytes = wire::seal(opened.header, wire::encode_membership(*message));
  ++told;
}

void Liar::change_session(node::Parcel& parcel, const wire::Opened& opened) {
  auto message = wire::decode_session(opened.payload);
  if (!message) return;
  hosting_(*message);
  parcel.bytes = wire::seal(opened.header, wire::encode_session(*message));
  ++told;
}

}  // namespace padr::lab
