#include "tools/monitor/order_desk.h"

#include <algorithm>

#include "shell/text.h"

namespace padr::monitor {

OrderDesk::Lane& OrderDesk::lane_of(const PeerRecord& peer) {
  Lane& lane = lanes_[peer.origin.process];
  lane.slot = peer.origin.slot;
  lane.to = peer.from;
  lane.token = peer.hello ? peer.hello->token : 0;
  return lane;
}

bool OrderDesk::give(const std::vector<const PeerRecord*>& peers, const What& what, const Ticket& ticket) {
  for (const PeerRecord* p : peers)
    if (lane_of(*p).waiting.size() >= kWaiting) return false;
  const std::uint64_t errand = ++errands_ever_;
  for (const PeerRecord* p : peers) {
    lane_of(*p).waiting.push_back({what, errand});
    errands_[errand].open.insert(p->origin.process);
  }
  errands_[errand].ticket = ticket;
  return true;
}

void OrderDesk::drive(const PeerRecord& peer, const Drive& drive) {
  Lane& lane = lane_of(peer);
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
  done(process, lane->second, event.kind != EventKind::kRefused, event.text);
}

void OrderDesk::advance(Micros now) {
  for (auto it = lanes_.begin(); it != lanes_.end();) {
    auto& [process, lane] = *it;
    if (!lane.waiting.empty()) {
      const bool first = lane.number == 0;
      if (first) lane.number = ++numbers_;
      if (first || now - lane.sent_at >= kAgain) {
        if (lane.tries >= kTries) {
          done(process, lane, false, "does not answer");
          continue;  // with the next one
        }
        ++lane.tries;
        lane.sent_at = now;
        send(process, lane, lane.number, lane.waiting.front().what);
      }
    } else if (lane.drive && (lane.drive_new || now - lane.driven_at >= kDriveAgain)) {
      lane.drive_new = false;
      lane.driven_at = now;
      send(process, lane, ++numbers_, *lane.drive);
    }
    it = lane.waiting.empty() && !lane.drive ? lanes_.erase(it) : std::next(it);
  }
}

void OrderDesk::send(std::uint64_t process, const Lane& lane, std::uint32_t number, const What& what) {
  send_(lane.to, encode(Order{process, lane.token, issuer_, number, what}));
}

void OrderDesk::done(std::uint64_t process, Lane& lane, bool ok, const std::string& text) {
  const std::uint64_t id = lane.waiting.front().errand;
  lane.waiting.pop_front();
  lane.number = 0;
  lane.tries = 0;
  const auto found = errands_.find(id);
  if (found == errands_.end()) return;
  Errand& errand = found->second;
  errand.open.erase(process);
  if (!ok) {
    errand.text += (errand.ok ? "peer " : "; peer ") + std::to_string(lane.slot) + ": " + shell::valid_utf8(text);
    errand.ok = false;
  }
  if (!errand.open.empty()) return;
  outcomes_.push_back({errand.ticket, errand.ok, errand.text});
  errands_.erase(found);
}

}  // namespace padr::monitor
