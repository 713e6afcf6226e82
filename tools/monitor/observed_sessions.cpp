#include "tools/monitor/observed_sessions.h"

#include <algorithm>

#include "common/model/user_error.h"
#include "common/scenarios/scenarios.h"
#include "shell/text.h"

namespace padr::monitor {
namespace {

constexpr std::size_t kProcesses = 1024;  // whose session is remembered
constexpr Micros kDraftAge = 30 * kMicrosPerSecond;

}  // namespace

void ObservedSessions::take(std::span<const std::byte> datagram, const Endpoint& from, Micros now) {
  ++stats_.datagrams;
  stats_.bytes += datagram.size();
  const auto told = decode_told(datagram);
  if (!told) {
    ++stats_.malformed;
    return;
  }
  if (const auto* part = std::get_if<ScenarioPart>(&told->message)) return take_part(*part, now);
  if (std::holds_alternative<Hello>(told->message)) found(*told, now);
  const auto key = key_of_.find(told->from.process);
  const auto session = key == key_of_.end() ? sessions_.end() : sessions_.find(key->second);
  if (session == sessions_.end() || session->first.number != told->from.session) {
    ++stats_.early;
    return;
  }
  session->second->take(*told, from, now);
}

void ObservedSessions::take_part(const ScenarioPart& part, Micros now) {
  auto draft = drafts_.find(part.scene_hash);
  if (draft == drafts_.end()) {
    if (drafts_.size() >= kScenes) {
      ++stats_.crowded;
      return;
    }
    draft = drafts_.emplace(part.scene_hash, SceneDraft{}).first;
  }
  SceneDraft& d = draft->second;
  if (d.text.size() != part.total) {
    d = {};
    d.text.assign(part.total, '\0');
    d.has.assign(part.total, 0);
    d.missing = part.total;
  }
  d.heard = now;
  if (d.missing == 0 || std::size_t{part.offset} + part.text.size() > d.text.size()) return;
  for (std::size_t i = 0; i < part.text.size(); ++i) {
    if (d.has[part.offset + i] == 0) --d.missing;
    d.has[part.offset + i] = 1;
    d.text[part.offset + i] = part.text[i];
  }
}

void ObservedSessions::found(const Told& told, Micros now) {
  const auto& hello = std::get<Hello>(told.message);
  const SessionKey key{told.from.session, hello.scene_hash};  // of one that does not play yet, of no session
  if (sessions_.contains(key)) {
    if (key_of_.size() >= kProcesses) key_of_.clear();  // they say Hello again
    key_of_[told.from.process] = key;
    return;
  }
  const auto draft = drafts_.find(key.scene_hash);
  if (draft == drafts_.end() || draft->second.missing > 0 || told.from.slot == kNoPeer ||
      now - draft->second.tried < kTryAgain)
    return;
  if (sessions_.size() >= kSessions) {
    ++stats_.crowded;
    return;
  }
  try {
    Scene scene = scenarios::load(draft->second.text, "scenario", hello.scenario_seed);
    if (scene_hash(scene) != key.scene_hash) throw UserError("its scenario makes another scene here");
    if (hello.slots < 1 || hello.slots > kMaxPeers) throw UserError("it has no avatar slots");
    auto session = std::make_unique<ObservedSession>(key, std::move(scene), shell::valid_utf8(hello.scenario),
                                                     hello.scenario_seed, hello.slots, now);
    key_of_[told.from.process] = key;
    sessions_.emplace(key, std::move(session));
    choose(now);
  } catch (const UserError& e) {
    draft->second.tried = now;
    notes_.push_back("a peer of session " + std::to_string(key.number) +
                     " cannot be shown: " + shell::valid_utf8(e.what()));
  }
}

void ObservedSessions::advance(Micros now) {
  for (auto& [key, session] : sessions_) session->advance(now);
  for (auto it = sessions_.begin(); it != sessions_.end();) {
    const bool over = !it->second->alive(now) && it->second.get() != shown_;
    it = over ? sessions_.erase(it) : std::next(it);
  }
  for (auto it = drafts_.begin(); it != drafts_.end();)
    it = now - it->second.heard > kDraftAge ? drafts_.erase(it) : std::next(it);
  choose(now);
}

void ObservedSessions::choose(Micros now) {
  for (auto& [key, session] : sessions_) {
    if (!session->alive(now) && session->began() != now) continue;
    if (shown_ == nullptr || session->began() > shown_->began() || (!shown_->alive(now) && shown_->began() != now))
      shown_ = session.get();
  }
}

int ObservedSessions::others(Micros now) const {
  return static_cast<int>(std::count_if(sessions_.begin(), sessions_.end(), [&](const auto& s) {
    return s.second.get() != shown_ && s.second->alive(now);
  }));
}

}  // namespace padr::monitor
