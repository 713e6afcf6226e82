#include "tools/monitor/order_desk.h"

#include <algorithm>
#include <utility>

#include "shell/text.h"

namespace padr::monitor {

OrderDesk::Addressee OrderDesk::addressee(const PeerRecord& peer) {
  return {peer.origin.process, peer.origin.slot, peer.from, peer.hello ? peer.hello->token : 0};
}

OrderDesk::Lane& OrderDesk::lane_of(const Addressee& a) {
  Lane& lane = lanes_[a.process];
  lane.whose = a;
  return lane;
}

bool OrderDesk::give(const std::vector<const PeerRecord*>& peers, const What& what, const Ticket& ticket, Whom whom) {
  for (const PeerRecord* p : peers)
    if (lane_of(addressee(*p)).waiting.size() >= kWaiting) return false;
  const std::uint64_t id = ++errands_ever_;
  Errand& errand = errands_[id];
  errand.ticket = ticket;
  errand.whom = whom;
  for (const PeerRecord* p : peers) {
    if (whom == Whom::kOne && !errand.open.empty()) {
      errand.instead.push_back(addressee(*p));
    } else {
      lane_of(addressee(*p)).waiting.push_back({what, id});
      errand.open.insert(p->origin.process);
    }
  }
  return true;
}

void OrderDesk::release_all() {
  for (auto& [process, lane] : lanes_) {
    if (!std::exchange(lane.drive, std::nullopt) || lane.waiting.size() >= kWaiting) continue;
    lane.waiting.push_back({Drive{}, 0});
  }
}

void OrderDesk::drive(const PeerRecord& peer, const Drive& drive) {
  // Another process may have come to its place.
  for (auto& [process, other] : lanes_)
    if (process != peer.origin.process && other.whose.slot == peer.origin.slot) other.drive.reset();
  Lane& lane = lane_of(addressee(peer));
  if (drive.kind == Drive::Kind::kRelease) {
    lane.drive.reset();
    if (lane.waiting.size() < kWaiting) lane.waiting.push_back({drive, 0});
    return;
  }
  lane.drive_new = lane.drive_new || lane.drive != drive;
  lane.drive = drive;
}

void OrderDesk::heard(std::uint64_t process, const Event& event) {
  if (event.order == 0) return;
  const auto lane = lanes_.find(process);
  if (lane == lanes_.end() || lane->second.number != event.order) return;
  done(lane->second, event.kind == EventKind::kRefused ? Answer::kRefused : Answer::kFollowed, event.text);
}

void OrderDesk::advance(Micros now) {
  for (auto it = lanes_.begin(); it != lanes_.end();) {
    Lane& lane = it->second;
    if (!lane.waiting.empty()) {
      const bool first = lane.number == 0;
      if (first) lane.number = ++numbers_;
      if (first || now - lane.sent_at >= kAgain) {
        if (lane.tries >= kTries) {
          done(lane, Answer::kNone, "does not answer");
          continue;  // with the next one
        }
        ++lane.tries;
        lane.sent_at = now;
        send(lane, lane.number, lane.waiting.front().what);
      }
    } else if (lane.drive && (lane.drive_new || now - lane.driven_at >= kDriveAgain)) {
      lane.drive_new = false;
      lane.driven_at = now;
      send(lane, ++numbers_, *lane.drive);
    }
    it = lane.waiting.empty() && !lane.drive ? lanes_.erase(it) : std::next(it);
  }
}

void OrderDesk::send(const Lane& lane, std::uint32_t number, const What& what) {
  send_(lane.whose.to, encode(Order{lane.whose.process, lane.whose.token, issuer_, number, what}));
}

void OrderDesk::done(Lane& lane, Answer answer, const std::string& text) {
  const Item item = std::move(lane.waiting.front());
  lane.waiting.pop_front();
  lane.number = 0;
  lane.tries = 0;
  const auto found = errands_.find(item.errand);
  if (found == errands_.end()) return;
  Errand& errand = found->second;
  errand.open.erase(lane.whose.process);
  if (answer != Answer::kFollowed) {
    errand.text += (errand.ok ? "peer " : "; peer ") + std::to_string(lane.whose.slot) + ": " + shell::valid_utf8(text);
    errand.ok = false;
  } else if (errand.whom == Whom::kOne) {
    errand.text.clear();
    errand.ok = true;
  }
  // Who does not answer may have followed it all the same.
  if (answer == Answer::kRefused && !errand.instead.empty()) {
    const Addressee next = errand.instead.front();
    errand.instead.pop_front();
    lane_of(next).waiting.push_back(item);
    errand.open.insert(next.process);
  }
  if (!errand.open.empty()) return;
  outcomes_.push_back({errand.ticket, errand.ok, errand.ok ? errand.ticket.doubt : errand.text});
  errands_.erase(found);
}

}  // namespace padr::monitor
