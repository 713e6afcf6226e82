#include "tools/capture/field_names.h"

#include <algorithm>

#include "tools/capture/record.h"

namespace padr::capture {
namespace {

constexpr FieldName kNames[] = {
    {"frame.number", false},
    {"frame.time_epoch", false},
    {"ip.src", false},
    {"ipv6.src", false},
    {"ip.dst", false},
    {"ipv6.dst", false},
    {"udp.srcport", false},
    {"udp.dstport", false},
    {"padr.version", false},
    {"padr.kind", false},
    {"padr.peer", false},
    {"padr.to", false},
    {"padr.session", false},
    {"padr.tag", false},
    {"padr.tag_good", false},
    {"padr.drop", false},
    {"padr.message", false},
    {"padr.nonce", false},
    {"padr.seq", false},
    {"padr.tick", false},
    {"padr.mark_count", false},
    {"padr.have", false},
    {"padr.have_beyond", false},
    {"padr.seen_seq", false},
    {"padr.seen_age", false},
    {"padr.transit", false},
    {"padr.loss", false},
    {"padr.check_age", false},
    {"padr.check_tick", false},
    {"padr.check_hash", false},
    {"padr.incarnation", false},
    {"padr.to_incarnation", false},
    {"padr.mark", false},
    {"padr.updates", false},
    {"padr.bodies", false},
    {"padr.avatar.flags", true},
    {"padr.cause", true},
    {"padr.avatar.model", true},
    {"padr.avatar.awake", true},
    {"padr.avatar.x", true},
    {"padr.avatar.y", true},
    {"padr.avatar.vx", true},
    {"padr.avatar.vy", true},
    {"padr.avatar.control_x", true},
    {"padr.avatar.control_y", true},
    {"padr.entity", true},
    {"padr.body.flags", true},
    {"padr.hold", true},
    {"padr.release", true},
    {"padr.body.state", true},
    {"padr.owner", true},
    {"padr.epoch", true},
    {"padr.claim_age", true},
    {"padr.claimed", true},
    {"padr.body.awake", true},
    {"padr.body.x", true},
    {"padr.body.y", true},
    {"padr.body.angle", true},
    {"padr.body.vx", true},
    {"padr.body.vy", true},
    {"padr.body.spin", true},
    {"padr.admission.slot", true},
    {"padr.admission.incarnation", true},
    {"padr.admission.first", true},
    {"padr.admission.address", true},
    {"padr.admission.port", true},
    {"padr.admission.have", true},
    {"padr.removal.slot", true},
    {"padr.removal.incarnation", true},
    {"padr.removal.count", true},
    {"padr.passed_on.slot", true},
    {"padr.passed_on.index", true},
    {"padr.passed_on.tick", true},
    {"padr.update.index_back", true},
    {"padr.update.tick_back", true},
    {"padr.update.peer", true},
    {"padr.update.index", true},
    {"padr.update.tick", true},
    {"padr.update.leave", true},
    {"padr.update.signature", true},
    {"padr.join.scene_hash", false},
    {"padr.join.fingerprint", false},
    {"padr.join.authority", false},
    {"padr.join.scenario", false},
    {"padr.join.padding", false},
    {"padr.welcome.peer", false},
    {"padr.welcome.slots", false},
    {"padr.welcome.wanted", false},
    {"padr.welcome.running", false},
    {"padr.welcome.incarnation", false},
    {"padr.redirect.address", false},
    {"padr.redirect.port", false},
    {"padr.refuse.reason", false},
    {"padr.ping.sent_us", false},
    {"padr.ping.padding", false},
    {"padr.pong.sent_us", false},
    {"padr.pong.founder_us", false},
    {"padr.pong.present", false},
    {"padr.start.tick0_us", false},
    {"padr.start.member.peer", true},
    {"padr.start.member.address", true},
    {"padr.start.member.port", true},
    {"padr.ready.round_trip_us", false},
    {"padr.ready.started", false},
    {"padr.bye.reason", false},
    {"padr.pull.from", false},
    {"padr.pull.wanted", false},
    {"padr.piece.index", false},
    {"padr.piece.count", false},
    {"padr.piece.bytes", false},
    {"padr.poll.lost.slot", true},
    {"padr.poll.lost.incarnation", true},
    {"padr.poll.lost.have", true},
    {"padr.answer.lost.slot", true},
    {"padr.answer.lost.incarnation", true},
    {"padr.answer.lost.have", true},
    {"padr.fetch.slot", false},
    {"padr.fetch.incarnation", false},
    {"padr.fetch.from", false},
    {"padr.fetched.slot", false},
    {"padr.fetched.incarnation", false},
    {"padr.fetched.mark_tick", false},
    {"padr.fetched.mark_count", false},
    {"padr.probe.incarnation", false},
    {"padr.probe.members.slot", true},
    {"padr.probe.members.incarnation", true},
    {"padr.probe.members.have", true},
    {"padr.probe.knows_you", false},
    {"padr.probe.newest", false},
};

}  // namespace

std::span<const FieldName> field_names() {
  return kNames;
}

bool can_repeat(std::string_view name) {
  const auto* const end = std::end(kNames);
  const auto* const found =
      std::find_if(std::begin(kNames), end, [name](const FieldName& f) { return f.name == name; });
  return found != end && found->repeats;
}

const std::vector<std::string_view>& all_fields() {
  static const std::vector<std::string_view> kAll = [] {
    std::vector<std::string_view> all;
    for (const FieldName& f : field_names()) all.push_back(f.name);
    return all;
  }();
  return kAll;
}

}  // namespace padr::capture
