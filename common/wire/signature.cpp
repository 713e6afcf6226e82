#include "common/wire/signature.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "common/wire/update_codec.h"
#include "proto/wire.pb.h"

namespace padr::wire {
namespace {

constexpr std::string_view kDomain = "padr update";

template <typename Number>
void append(Bytes& text, Number v) {
  for (unsigned i = 0; i < sizeof v; ++i) text.push_back(static_cast<std::byte>(v >> (8 * i)));
}

}  // namespace

SessionId session_id(const Key& secret, const PublicKey& founder, std::uint64_t scene_hash) {
  std::string name = "session";
  name.append(founder.begin(), founder.end());
  for (unsigned i = 0; i < 64; i += 8) name.push_back(static_cast<char>(scene_hash >> i));
  const Key derived = derive_key(secret, name);
  SessionId id{};
  std::copy_n(derived.begin(), id.size(), id.begin());
  return id;
}

Bytes signed_text(const Said& said, const sync::Bundle& update) {
  PassedOn content;
  content.set_slot(update.peer);
  content.set_index(update.index);
  content.set_tick(static_cast<std::uint32_t>(update.tick));
  put_update(update, update.tick, update.index + 1, *content.mutable_update());
  content.mutable_update()->clear_signature();
  Bytes text;
  text.reserve(kDomain.size() + said.session.size() + sizeof said.incarnation + content.ByteSizeLong());
  for (const char c : kDomain) text.push_back(static_cast<std::byte>(c));
  for (const std::uint8_t b : said.session) text.push_back(static_cast<std::byte>(b));
  append(text, said.incarnation);
  const std::size_t head = text.size();
  text.resize(head + content.ByteSizeLong());
  content.SerializeToArray(text.data() + head, static_cast<int>(text.size() - head));
  return text;
}

sync::Signature sign_update(const SigningKey& key, const Said& said, const sync::Bundle& update) {
  return sign(key, signed_text(said, update));
}

bool is_signed(const PublicKey& key, const Said& said, const sync::Bundle& update) {
  return update.signature && signed_by(key, signed_text(said, update), *update.signature);
}

bool contradict(const sync::Bundle& one, const sync::Bundle& other) {
  if (one.peer != other.peer) return false;
  if (one.index == other.index) return signed_text({}, one) != signed_text({}, other);
  return one.index < other.index ? one.tick >= other.tick : one.tick <= other.tick;
}

bool is_proven(const SessionId& session, const sync::Transfer::Proof& proof) {
  const Said said{session, proof.incarnation};
  return contradict(proof.one, proof.other) && is_signed(proof.key, said, proof.one) &&
         is_signed(proof.key, said, proof.other);
}

}  // namespace padr::wire
