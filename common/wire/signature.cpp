#include "common/wire/signature.h"

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

Bytes signed_text(const Said& said, const sync::Bundle& update) {
  PassedOn content;
  content.set_slot(update.peer);
  content.set_index(update.index);
  content.set_tick(static_cast<std::uint32_t>(update.tick));
  put_update(update, update.tick, update.index + 1, *content.mutable_update());
  content.mutable_update()->clear_signature();
  Bytes text;
  text.reserve(kDomain.size() + sizeof said.session + sizeof said.incarnation + content.ByteSizeLong());
  for (const char c : kDomain) text.push_back(static_cast<std::byte>(c));
  append(text, said.session);
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

}  // namespace padr::wire
