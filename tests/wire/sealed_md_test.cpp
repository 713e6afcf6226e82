// The vectors of section 14 of proto/WIRE.md, which tests/conformance makes without any of our code, against ours.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <string>

#include "common/wire/handshake.h"
#include "common/wire/signature.h"
#include "wire_md.h"

namespace padr::wire {
namespace {

std::map<std::string, Bytes> vectors() {
  const std::string document(reinterpret_cast<const char*>(kText), sizeof kText - 1);
  const std::string begin = "\n```sealed\n";
  const auto at = document.find(begin) + begin.size();
  std::istringstream lines(document.substr(at, document.find("\n```", at) - at));
  std::map<std::string, Bytes> found;
  std::string name;
  for (std::string line; std::getline(lines, line);) {
    if (const auto equals = line.find('='); equals != std::string::npos) {
      name = line.substr(0, line.find(' '));
      line.erase(0, equals + 1);
    }
    std::istringstream words(line);
    for (std::string word; words >> word;) found[name].push_back(static_cast<std::byte>(std::stoi(word, nullptr, 16)));
  }
  return found;
}

Key key_of(const Bytes& bytes) {
  Key k{};
  std::transform(bytes.begin(), bytes.end(), k.begin(), [](std::byte b) { return std::to_integer<std::uint8_t>(b); });
  return k;
}

Tag cookie_of(const Bytes& bytes) {
  Tag t{};
  std::copy_n(bytes.begin() + 44, t.size(), t.begin());
  return t;
}

TEST(SealedMd, EveryVectorIsWhatTheCodeMakes) {
  auto v = vectors();
  ASSERT_EQ(v.size(), 24U);
  const Key session = key_of(v["session_key"]);
  const Key a = key_of(v["secret_a"]);
  const Key b = key_of(v["secret_b"]);
  const PublicKey public_a = public_key(a);
  const PublicKey public_b = public_key(b);
  EXPECT_EQ(public_a, key_of(v["public_a"]));
  EXPECT_EQ(public_b, key_of(v["public_b"]));
  const auto keys = pair_keys(session, a, public_a, public_b);
  ASSERT_TRUE(keys);
  EXPECT_EQ(keys->out, key_of(v["key_a_to_b"]));
  EXPECT_EQ(keys->in, key_of(v["key_b_to_a"]));
  constexpr std::uint64_t kNumber = (std::uint64_t{5} << 32U) + 7;
  EXPECT_EQ(seal_with(keys->out, SealMode::kAuth, short_id(public_a), kNumber, v["unsealed"]), v["auth"]);
  EXPECT_EQ(seal_with(keys->out, SealMode::kEncrypt, short_id(public_a), kNumber, v["unsealed"]), v["encrypt"]);
  EXPECT_EQ(unseal_with(keys->out, kNumber, v["encrypt"]), v["unsealed"]);
  EXPECT_EQ(unseal_unchecked(v["auth"]), v["unsealed"]);
  const Key h = handshake_key(session);
  constexpr std::uint64_t kNonce = 0x1122334455667788;
  const Tag cookie = cookie_of(v["cookie"]);
  EXPECT_EQ(encode_handshake(Hello{public_a, kNonce}, h), v["hello"]);
  EXPECT_EQ(encode_handshake(Cookie{public_b, kNonce, cookie}, h), v["cookie"]);
  EXPECT_EQ(encode_handshake(Introduction{public_a, 1, cookie}, keys->out), v["introduction"]);
  EXPECT_EQ(encode_handshake(Acceptance{public_b, 1}, keys->in), v["acceptance"]);
}

TEST(SealedMd, NewKeysAreWhatTheCodeMakes) {
  auto v = vectors();
  const PairKeys former{key_of(v["key_a_to_b"]), key_of(v["key_b_to_a"])};
  const PublicKey a = exchange_key(key_of(v["exchange_secret_a"]));
  const PublicKey b = exchange_key(key_of(v["exchange_secret_b"]));
  EXPECT_EQ(a, key_of(v["exchange_a"]));
  EXPECT_EQ(b, key_of(v["exchange_b"]));
  const Rekey of_a{a, 2, short_id(key_of(v["public_a"])), 1, 0};
  const Rekey of_b{b, 2, short_id(key_of(v["public_b"])), 1, beginning_of(a)};
  EXPECT_EQ(encode_handshake(of_a, former.out), v["rekey_a"]);
  EXPECT_EQ(encode_handshake(of_b, former.in), v["rekey_b"]);
  const auto back = decode_handshake(v["rekey_b"], Key{});
  ASSERT_TRUE(back);
  EXPECT_EQ(std::get<Rekey>(*back), of_b);
  EXPECT_TRUE(proves(v["rekey_b"], former.in, 2));
  EXPECT_FALSE(proves(v["rekey_b"], former.in, 3));
  const auto keys = next_keys(former, key_of(v["exchange_secret_a"]), a, b);
  ASSERT_TRUE(keys);
  EXPECT_EQ(keys->out, key_of(v["next_a_to_b"]));
  EXPECT_EQ(keys->in, key_of(v["next_b_to_a"]));
  EXPECT_EQ(next_keys({former.in, former.out}, key_of(v["exchange_secret_b"]), b, a)->in, keys->out);
  EXPECT_FALSE(next_keys(former, key_of(v["exchange_secret_a"]), a, PublicKey{})) << "zeros are nobody's";
}

TEST(SealedMd, TheSignatureIsWhatTheCodeMakes) {
  auto v = vectors();
  sync::Bundle b;
  b.peer = 2;
  b.index = 9;
  b.tick = 90;
  b.leave = true;
  Said said{{}, 130};
  for (std::size_t i = 0; i < said.session.size(); ++i) said.session[i] = static_cast<std::uint8_t>(0xB0 + i);
  Said elsewhere = said;
  elsewhere.session[15] ^= 1;
  EXPECT_EQ(signed_text(said, b), v["signed_text"]);
  const sync::Signature s = sign_update(signing_key(key_of(v["secret_a"])), said, b);
  EXPECT_EQ(Bytes(s.begin(), s.end()), v["signature"]);
  b.signature = s;
  EXPECT_TRUE(is_signed(key_of(v["public_a"]), said, b));
  EXPECT_FALSE(is_signed(key_of(v["public_b"]), said, b));
  EXPECT_FALSE(is_signed(key_of(v["public_a"]), elsewhere, b)) << "another session";
  EXPECT_FALSE(is_signed(key_of(v["public_a"]), {said.session, 131}, b)) << "another life";
  for (const auto& change :
       {+[](sync::Bundle& c) { ++c.peer; }, +[](sync::Bundle& c) { ++c.index; }, +[](sync::Bundle& c) { ++c.tick; },
        +[](sync::Bundle& c) { c.leave = false; }, +[](sync::Bundle& c) { c.signature.reset(); }}) {
    sync::Bundle other = b;
    change(other);
    EXPECT_FALSE(is_signed(key_of(v["public_a"]), said, other));
  }
}

TEST(SealedMd, HandshakesComeBackAsTheyWere) {
  auto v = vectors();
  const Key h = handshake_key(key_of(v["session_key"]));
  const auto hello = decode_handshake(v["hello"], h);
  ASSERT_TRUE(hello);
  EXPECT_EQ(std::get<Hello>(*hello), (Hello{key_of(v["public_a"]), 0x1122334455667788}));
  const auto introduction = decode_handshake(v["introduction"], h);
  ASSERT_TRUE(introduction);
  EXPECT_TRUE(proves(v["introduction"], key_of(v["key_a_to_b"]), std::get<Introduction>(*introduction).number));
  EXPECT_FALSE(proves(v["introduction"], key_of(v["key_b_to_a"]), 1));
  v["hello"][70] ^= std::byte{1};
  EXPECT_FALSE(decode_handshake(v["hello"], h));
}

}  // namespace
}  // namespace padr::wire
