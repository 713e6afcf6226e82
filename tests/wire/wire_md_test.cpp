// proto/WIRE.md and proto/VECTORS.md against the code. Every vector in it, in both directions: what it lists is what
// our decoder reads, and what our encoder writes for that are its bytes. Some vectors are also built here, so that they
// cannot be lost from the document. Constants and lots likewise.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "common/channel/channel_keys.h"
#include "common/channel/secure_channels.h"
#include "common/membership/admissions.h"
#include "common/membership/partition_merge.h"
#include "common/membership/testimony.h"
#include "common/membership/vouching.h"
#include "common/model/hash.h"
#include "common/participant/transfer_pull.h"
#include "common/paths/introductions.h"
#include "common/paths/paths.h"
#include "common/paths/relay.h"
#include "common/replica/replica.h"
#include "common/session/session_state.h"
#include "common/sync/authority.h"
#include "common/sync/validation.h"
#include "common/wire/codec.h"
#include "common/wire/handshake.h"
#include "common/wire/session_codec.h"
#include "tests/wire/listing.h"
#include "wire_md.h"

namespace padr::wire {
namespace {

using sync::BodyUpdate;
using sync::Bundle;
using sync::Cause;
using sync::StatePacket;

std::string fenced(const char* kind, const std::string& lines) {
  return std::string("```") + kind + "\n" + lines + "```\n";
}

StatePacket mark() {
  StatePacket p;
  p.seq = 300;
  p.mark_tick = 4500;
  p.mark_count = 129;
  p.have = 87;
  p.seen_seq = 290;
  p.seen_age = 9;
  p.transit = 1003;
  p.loss = 10;
  p.check_tick = 4470;
  p.check_hash = 0x9A3BC2D1U;
  return p;
}

StatePacket contact() {
  StatePacket p;
  p.seq = 7;
  p.mark_tick = 1200;
  p.mark_count = 42;
  p.have = 17;
  p.seen_seq = 55;
  p.seen_age = 3;
  Bundle b;
  b.index = 41;
  b.tick = 1200;
  b.avatar = sync::AvatarUpdate{Cause::kContactBegin, {5.5F, 4.25F}, {3, -0.5F}, true, Model::kInput, {9, 3}};
  BodyUpdate u;
  u.body = 12;
  u.cause = Cause::kContactBegin;
  u.held = u.has_state = true;
  u.epoch = 3;
  u.claimed = 1200;
  u.state = {{6.25F, 4.125F}, 0.5F, {2, -0.25F}, 0.125F, true};
  b.bodies.push_back(u);
  p.updates.push_back(b);
  return p;
}

/// Bodies of all kinds, a repeated update beside a new one, and a goodbye.
StatePacket crowded() {
  StatePacket p = contact();
  p.seq = 8;
  p.mark_tick = 1230;
  p.mark_count = 44;
  p.have_beyond = 5;
  Bundle b;
  b.index = 42;
  b.tick = 1218;
  b.avatar = sync::AvatarUpdate{Cause::kAtRest, {7, 4}, {0, 0}, false, Model::kFirst, {}};
  BodyUpdate u;
  u.body = 3;
  u.cause = Cause::kContactEnd;
  b.bodies.push_back(u);  // let go of, nothing else
  u.body = 12;
  u.cause = Cause::kAtRest;
  u.has_state = u.release = true;
  u.epoch = 3;
  u.claimed = 1200;
  u.state = {{6.5F, 4}, 0.75F, {0, 0}, 0, false};
  b.bodies.push_back(u);
  u = BodyUpdate{};
  u.body = 40;
  u.cause = Cause::kAtRest;
  u.release = true;  // where it is predicted to be
  b.bodies.push_back(u);
  p.updates.push_back(b);
  Bundle last;
  last.index = 43;
  last.tick = 1230;
  last.leave = true;
  p.updates.push_back(last);
  return p;
}

Endpoint somewhere() {
  return ipv4({192, 0, 2, 7}, 7001);
}

/// A packet whose last update, its third, is this one.
StatePacket order(const Bundle& b) {
  StatePacket p;
  p.seq = 700;
  p.mark_tick = 9000;
  p.mark_count = 43;
  p.have = 17;
  p.seen_seq = 690;
  p.seen_age = 1;
  p.incarnation = 3;
  p.updates = {b};
  p.updates[0].index = 42;
  p.updates[0].tick = 9000;
  return p;
}

StatePacket admission() {
  Bundle b;
  b.admission = sync::Admission{1, 130, 57, somewhere(), {12, 57, 42, 0}};
  return order(b);
}

StatePacket removals() {
  Bundle b;
  b.removals = {{0, 0, 300}, {3, 77, 12}};
  return order(b);
}

/// What the coordinator that is lost as well had passed on of another one.
StatePacket passed_on() {
  Bundle first;
  first.peer = 3;
  first.index = 11;
  first.tick = 8700;
  first.bodies = contact().updates[0].bodies;
  first.bodies[0].claimed = 8700;
  Bundle second;
  second.peer = 0;
  second.index = 299;
  second.tick = 8900;
  second.passed_on = {first};
  Bundle b;
  b.passed_on = {second};
  return order(b);
}

StatePacket spectates() {
  Bundle b;
  b.spectates = true;
  return order(b);
}

StatePacket admission_of_spectator() {
  StatePacket p = admission();
  p.updates[0].admission->spectator = true;
  return p;
}

const std::string& document() {
  static const std::string kDocument(reinterpret_cast<const char*>(kText), sizeof kText - 1);
  return kDocument;
}

/// Sealed by a peer of session 0x1234, with what the document is to say of it.
void expect_in_document(Kind kind, const Bytes& payload, const std::string& lines, PeerId sender = 2) {
  const Header h{kind, sender, 0x1234};
  const Bytes datagram = seal(h, payload);
  const std::string vector = fenced("hex", test::hex(datagram)) + "\n" + fenced("fields", test::list(h) + lines);
  EXPECT_NE(document().find(vector), std::string::npos) << "proto/VECTORS.md lacks this vector:\n" << vector;
  EXPECT_EQ(test::read(datagram).again, datagram);
}

void expect_in_document(const StatePacket& p) {
  expect_in_document(Kind::kState, encode(p), test::list(p));
}

TEST(WireMd, HasTheVectorsOfStateDatagrams) {
  expect_in_document(mark());
  expect_in_document(contact());
  expect_in_document(crowded());
}

TEST(WireMd, HasTheVectorsOfOrders) {
  expect_in_document(admission());
  expect_in_document(admission_of_spectator());
  expect_in_document(spectates());
  expect_in_document(removals());
  expect_in_document(passed_on());
}

TEST(WireMd, HasTheVectorsOfMembershipDatagrams) {
  constexpr std::uint64_t kNonce = 0x0123456789ABCDEFULL;
  Fetched fetched{3, 77, {}};
  for (const Bundle& b : contact().updates) fetched.updates.push_back(b);
  fetched.updates.push_back(fetched.updates[0]);
  fetched.updates[1].index = 42;
  fetched.updates[1].tick = 1210;
  fetched.updates[1].bodies.clear();
  const std::vector<MembershipMessage> messages{
      Pull{kNonce, 3, 0b1001, 0x1122334455667788},
      Piece{kNonce, 3, 8, {std::byte{0x0A}, std::byte{0xFF}, std::byte{0}}},
      Enter{kNonce},
      Poll{{{0, 0, 0}, {3, 77, 0}}},
      Answer{{{0, 0, 298, 51}, {3, 77, 12}}, false, 4500},
      Poll{{{3, 77, 0}}, true, 2},
      Answer{{{3, 77, 12}}, true, 4572, 2},
      Fetch{3, 77, 11},
      fetched,
      Probe{3, {{1, 0, 0}, {2, 3, 0}}, true, 77},
      Reach{4500, {{0, 3}, {1, 9, true}, {3, 12}}},
      Reach{4500, {}, {ipv4({192, 168, 0, 7}, 4242)}},
      Newcomer{ipv4({203, 0, 113, 7}, 4242)},
  };
  for (const MembershipMessage& m : messages)
    expect_in_document(Kind::kMembership, encode_membership(m), test::list(m));
}

TEST(WireMd, HasTheVectorOfASessionDatagram) {
  const SessionMessage m = Pong{1'000'000, 5'250'000};
  expect_in_document(Kind::kSession, encode_session(m), test::list(m), 0);
}

TEST(WireMd, TellsTheLimitsThatTheCodeHas) {
  for (const std::size_t limit : {kMaxDatagram, kHeaderBytes, kTagBytes, sync::kMaxBodiesPerBundle})
    EXPECT_NE(document().find(std::to_string(limit)), std::string::npos) << limit;
  for (const auto name : sync::kCauseNames) EXPECT_NE(document().find(name), std::string::npos) << name;
}

/// The text of every block that is fenced as ```kind, fences included, by its order in the document.
std::vector<std::string> blocks(const std::string& kind) {
  std::vector<std::string> found;
  const std::string begin = "\n```" + kind + "\n";
  const std::string end = "\n```\n";
  for (std::size_t at = document().find(begin); at != std::string::npos; at = document().find(begin, at)) {
    const std::size_t last = document().find(end, at + begin.size() - 1);
    if (last == std::string::npos) break;
    found.push_back(document().substr(at + 1, last + end.size() - at - 1));
    at = last + end.size() - 1;
  }
  return found;
}

/// Without comments, which begin with '#', and the spaces before them.
std::string bare(const std::string& block) {
  std::string out;
  std::istringstream lines(block);
  for (std::string l; std::getline(lines, l); out += l + "\n") {
    l.erase(std::min(l.find('#'), l.size()));
    l.erase(l.find_last_not_of(' ') + 1);
  }
  return out;
}

/// Bytes of a block: two digits each, `00*9` for nine of them.
Bytes bytes_of(const std::string& block) {
  Bytes bytes;
  std::istringstream words(bare(block));
  for (std::string w; words >> w;) {
    if (w.starts_with("```")) continue;
    const std::size_t times = w.size() > 2 ? std::stoul(w.substr(3)) : 1;
    bytes.insert(bytes.end(), times, static_cast<std::byte>(std::stoul(w.substr(0, 2), nullptr, 16)));
  }
  return bytes;
}

/// Holds each block `hex` or `bytes` against the block `fields` or `reading` after it.
void expect_vectors(const std::string& bytes, const std::string& listing, std::size_t at_least) {
  const std::string fence = "```" + listing + "\n";
  const std::string other = fence + "canonical = 0\n";
  const std::vector<std::string> vectors = blocks(bytes);
  const std::vector<std::string> listings = blocks(listing);
  ASSERT_EQ(vectors.size(), listings.size());
  EXPECT_GE(vectors.size(), at_least);
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    SCOPED_TRACE(vectors[i]);
    const Bytes datagram = bytes_of(vectors[i]);
    const test::Reading ours = test::read(datagram);
    const bool canonical = !listings[i].starts_with(other);
    EXPECT_EQ(fenced("", ours.lines), "```\n" + listings[i].substr(canonical ? fence.size() : other.size()));
    if (ours.again.empty()) continue;  // dropped
    EXPECT_EQ(ours.again == datagram, canonical) << test::hex(ours.again);
  }
}

TEST(WireMd, EveryVectorIsWhatTheCodeReadsAndWrites) {
  expect_vectors("hex", "fields", 18);
  expect_vectors("bytes", "reading", 30);
  std::vector<Bytes> vectors;
  for (const std::string& block : blocks("hex")) vectors.push_back(bytes_of(block));
  ASSERT_EQ(blocks("annotated").size(), 3U);
  for (const std::string& block : blocks("annotated"))
    EXPECT_NE(std::find(vectors.begin(), vectors.end(), bytes_of(block)), vectors.end()) << block;
}

TEST(WireMd, ConstantsAreThoseOfTheCode) {
  using Pace = node::SessionPace;
  const sync::AdmitLimits limits;
  std::string ours = "```constants\n";
  const auto add = [&ours](const char* name, auto v) { ours += std::string(name) + " = " + std::to_string(v) + "\n"; };
  const auto whole = [&add](const char* name, float v) { add(name, static_cast<long>(v)); };
  add("protocol_version", int{kProtocolVersion});
  add("max_datagram", kMaxDatagram);
  add("header", kHeaderBytes);
  add("tag", kTagBytes);
  add("max_payload", kMaxPayload);
  add("sealed_header", kSealedHeaderBytes);
  add("sealed_tag", kSealedTagBytes);
  add("max_sealed", kMaxSealed);
  add("carried_header", kCarriedHeaderBytes);
  add("max_carried", kMaxCarried);
  add("handshake", kHandshakeBytes);
  add("rekey_us", node::ChannelKeys::kEvery);
  add("rekey_patience_us", node::ChannelKeys::kPatience);
  add("rekey_overlap_us", node::ChannelKeys::kOverlap);
  add("rekey_again_us", node::ChannelKeys::kAgain);
  add("rekey_slowest_us", node::ChannelKeys::kSlowest);
  add("max_peers", kMaxPeers);
  add("no_peer", int{kNoPeer});
  add("no_entity", int{kNoEntity});
  add("max_bodies_per_update", sync::kMaxBodiesPerBundle);
  add("max_bodies_per_signed", sync::kMaxBodiesPerSigned);
  add("signature", sizeof(sync::Signature));
  add("max_passing", sync::kMaxPassing);
  add("ticks_per_second", kTicksPerSecond);
  add("max_label", kMaxLabel);
  add("max_reason", kMaxReason);
  add("max_clock_us", kMaxClock);
  add("max_pieces", kMaxPieces);
  add("max_piece", kPieceBytes);
  add("max_gone", sync::Transfer::kMostGone);
  add("max_proofs", sync::Transfer::kMostProofs);
  whole("admit_margin", limits.margin);
  whole("admit_speed", limits.max_speed);
  whole("admit_spin", limits.max_spin);
  whole("admit_angle", limits.max_angle);
  whole("admit_control", limits.max_control);
  add("admit_ahead", limits.max_ahead);
  add("far_ahead_us", node::Replica::kFarAhead);
  add("join_us", Pace::kJoin);
  add("ping_us", node::TransferPull::kPing);
  add("idle_ping_us", node::TransferPull::kIdlePing);
  add("clock_samples", node::TransferPull::kSamples);
  add("clock_samples_kept", node::OffsetEstimator::kKept);
  add("oldest_pong_us", node::TransferPull::kOldestPong);
  add("again_us", node::TransferPull::kAgain);
  add("patience_us", node::TransferPull::kPatience);
  add("unproven_us", node::Admissions::kUnproven);
  add("at_once", node::Admissions::kAtOnce);
  add("turn_us", node::Admissions::kTurn);
  add("directly_us", node::SessionPace::kDirectly);
  add("introduced_us", node::Introductions::kLease);
  add("knock_us", node::SecureChannels::kKnockAgain);
  add("unheard_us", Pace::kUnheard);
  add("start_lead", sync::kStartLead);
  add("doubt", node::kDoubt);
  add("silence", node::kSilence);
  add("answer_patience", node::kAnswerPatience);
  add("heard_lately", node::kHeardLately);
  add("believed", node::kBelieved);
  add("ask_again", node::Evictions::kAskAgain);
  add("returning", node::Evictions::kReturning);
  add("withheld", node::Evictions::kWithheld);
  add("unsent", node::Evictions::kUnsent);
  add("relay_after", node::kRelayAfter);
  add("relay_until", node::kRelayUntil);
  add("relay_pace", node::Relay::kPace);
  add("relay_hurry", node::Relay::kHurry);
  add("relay_patience", node::Relay::kPatience);
  add("relay_served", node::Relay::kServed);
  add("heard_again", node::Evictions::kHeardAgain);
  add("answer_pause", node::Roster::kAnswerPause);
  add("lease", node::Evictions::kLease);
  add("vouch_grace", node::Vouching::kGrace);
  add("vouch_again", node::Vouching::kAskAgain);
  add("prove_pace", node::Vouching::kPace);
  add("testimony_again", node::Testimony::kAgain);
  add("testimony_times", node::Testimony::kTimes);
  add("made_known", node::Testimony::kMadeKnown);
  add("dispute", node::Testimony::kDispute);
  add("contested_check", node::Replica::kTellContested);
  add("heartbeat", node::Replica::kHeartbeat);
  add("probe_pace", node::PartitionMerge::kPace);
  add("answer_pace", node::PartitionMerge::kAnswerPace);
  add("probe_grace", node::PartitionMerge::kGrace);
  add("probe_lately", node::PartitionMerge::kLately);
  add("may_be_unknown", node::PartitionMerge::kMayBeUnknown);
  add("strangers", node::PartitionMerge::kStrangers);
  add("stalled", node::PartitionMerge::kStalled);
  add("tell_pace", node::PartitionMerge::kTell);
  add("most_told", node::PartitionMerge::kMostTold);
  add("in_vain", node::PartitionMerge::kInVain);
  add("stays_alone", node::PartitionMerge::kStaysAlone);
  add("alone", node::PartitionMerge::kAlone);
  add("lonely", node::PartitionMerge::kLonely);
  add("drowsy", node::PartitionMerge::kDrowsy);
  add("probe_remember", node::PartitionMerge::kRemember);
  add("probe_rarely", node::PartitionMerge::kRarely);
  add("unheard", node::Paths::kUnheard);
  add("carried_unanswered", node::Paths::kUnanswered);
  add("reach_fresh", node::Paths::kFresh);
  add("reach_again", node::Paths::kTellAgain);
  add("reach_afterwards", node::Paths::kTellAfterwards);
  add("carrier_failed", node::Paths::kFailed);
  add("try_directly_us", node::SecureChannels::kTryAgain);
  add("try_directly_slowest_us", node::SecureChannels::kTrySlowest);
  ASSERT_EQ(blocks("constants").size(), 1U);
  EXPECT_EQ(bare(blocks("constants")[0]), ours + "```\n");
}

// The document's numbers are those of Hasher, and of two claims of the same tick the one with the smaller number wins.
TEST(WireMd, LotsDecideAsTheCodeDoes) {
  ASSERT_EQ(blocks("lots").size(), 1U);
  std::istringstream lines(blocks("lots")[0]);
  std::vector<std::array<unsigned long long, 4>> lots;
  for (std::string l; std::getline(lines, l);) {
    std::array<unsigned long long, 4> v{};
    if (std::sscanf(l.c_str(), "peer %llu body %llu epoch %llu = %llu", &v[0], &v[1], &v[2], &v[3]) != 4) continue;
    Hasher h;
    for (const std::size_t i : {0U, 1U, 2U}) h.add(std::uint64_t{v[i]});
    EXPECT_EQ(h.value(), v[3]) << l;
    lots.push_back(v);
  }
  ASSERT_GE(lots.size(), 4U);
  for (const auto& a : lots)
    for (const auto& b : lots) {
      if (a[0] == b[0] || a[1] != b[1] || a[2] != b[2]) continue;
      const sync::Authority claim{static_cast<PeerId>(a[0]), false, static_cast<std::uint32_t>(a[2]), 100};
      const sync::Authority present{static_cast<PeerId>(b[0]), false, static_cast<std::uint32_t>(b[2]), 100};
      EXPECT_EQ(sync::wins(claim, present, static_cast<EntityId>(a[1])), a[3] < b[3]) << a[0] << " against " << b[0];
    }
}

}  // namespace
}  // namespace padr::wire
