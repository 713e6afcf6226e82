#include "common/node/removals.h"

#include <algorithm>
#include <utility>

#include "common/node/guard.h"

namespace padr::node {

PeerId Removals::coordinator(const Node& node) const {
  for (PeerId p = 0; p < node.config().slots; ++p) {
    if (p == node.self()) {
      if (node.member() && !node.leaving()) return p;
    } else if (node.other(p).there() && !suspected(node, p) && !lost_.contains(p)) {
      return p;
    }
  }
  return kNoPeer;
}

// A peer that stood still itself gives the others the time that it missed, so it would take them for alive for longer
// than the heir does. It must not answer later than the rest: if the lost peer comes back meanwhile, half of the peers
// have frozen it and half have not, and neither half can go on without the other.
bool Removals::follows(PeerId from, const wire::Poll& poll, const Node& node) const {
  if (coordinator(node) == from) return true;
  for (PeerId p = 0; p < from; ++p) {
    if (p == node.self()) {
      if (node.member() && !node.leaving()) return false;
      continue;
    }
    const Neighbour& n = node.other(p);
    if (!n.there() || suspected(node, p) || lost_.contains(p)) continue;
    const bool asked_about = std::any_of(poll.lost.begin(), poll.lost.end(), [&](const wire::Seat& s) {
      return s.slot == p && s.incarnation == n.incarnation;
    });
    const bool excused = node.now() - n.excused < kSilence;  // or else this peer has listened, and knows better
    if (!asked_about || !excused || n.answer_mark > node.now() - kHeardLately) return false;
  }
  return node.other(from).there() && !suspected(node, from) && !lost_.contains(from);
}

void Removals::on_poll(PeerId from, const wire::Poll& poll, RecordedNode& node) {
  if (poll.freeze && !follows(from, poll, node.node())) return;  // not ours to follow, or not yet
  wire::Answer answer;
  answer.frozen = poll.freeze;
  answer.tick = node.node().now();
  for (const wire::Seat& s : poll.lost) {
    if (s.slot >= desk_.slots || s.slot == desk_.self || s.slot == from) continue;
    const Neighbour& n = node.node().other(s.slot);
    const bool same = n.incarnation == s.incarnation;
    if (poll.freeze) {
      if (n.reachable() && same && !n.frozen) node.freeze(s.slot, true);
      if (n.frozen) frozen_for_[s.slot] = from;
      answered_[{from, s.slot}] = s.incarnation;
    }
    answer.lost.push_back({s.slot, s.incarnation, node.node().agreed().log().have(s.slot)});
    if (!same || n.frozen || n.answer_mark < 0) continue;
    const auto ago = static_cast<std::uint32_t>(std::max(0, answer.tick - n.answer_mark));
    answer.lost.back().heard = std::min(ago + 1, wire::kMostHeard);
  }
  if (!answer.lost.empty()) desk_.send(desk_.roster[from], answer);
}

void Removals::on_answer(PeerId from, const wire::Answer& answer, const Node& node) {
  for (const wire::Seat& s : answer.lost) {
    const auto doubted = doubted_.find(s.slot);
    if (doubted != doubted_.end() && doubted->second.incarnation == s.incarnation)
      doubted->second.heard[from] =
          s.heard > 0 ? std::min(answer.tick, node.now()) + 1 - static_cast<Tick>(s.heard) : -1;
    if (!answer.frozen) continue;
    const auto it = lost_.find(s.slot);
    if (it == lost_.end() || it->second.incarnation != s.incarnation) continue;
    // No log has more beyond what another lacks.
    const std::uint32_t most = node.agreed().log().have(s.slot) + sync::UpdateLog::kMostBeyond;
    if (it->second.have.insert_or_assign(from, std::min(s.have, most)).second) moved_ = node.now();
  }
}

void Removals::on_fetch(PeerId from, const wire::Fetch& fetch, const Node& node) {
  if (fetch.slot >= desk_.slots || !node.other(fetch.slot).frozen) return;
  wire::Fetched f{fetch.slot, fetch.incarnation, node.agreed().log().of(fetch.slot, fetch.from)};
  if (!f.updates.empty()) desk_.send(desk_.roster[from], f);
}

void Removals::on_fetched(const wire::Fetched& fetched, const Node& node, const Guard& guard) {
  const auto it = lost_.find(fetched.slot);
  if (it == lost_.end() || it->second.incarnation != fetched.incarnation) return;
  for (const sync::Bundle& b : fetched.updates)
    if (b.index >= it->second.least && b.index < it->second.most && !it->second.fetched.contains(b.index) &&
        guard.said(b, node) && sync::admit(b, node.live().world().scene(), desk_.slots) == sync::DropReason::kNone) {
      it->second.fetched.emplace(b.index, b);
      moved_ = node.now();
    }
}

void Removals::thaw(RecordedNode& node) {
  for (auto it = frozen_for_.begin(); it != frozen_for_.end();) {
    const Node& n = node.node();
    if (!n.other(it->first).frozen) {  // it is out, or somebody else sits there
      it = frozen_for_.erase(it);
    } else if (!n.other(it->second).reachable()) {  // who asked is gone, and so is the question
      node.freeze(it->first, false);
      it = frozen_for_.erase(it);
    } else {
      ++it;
    }
  }
}

// The lowest of those who answer will have to decide.
bool Removals::is_first_well(const Node& node) const {
  if (!node.member() || node.leaving()) return false;
  for (PeerId p = 0; p < desk_.self; ++p)
    if (node.other(p).there() && node.unanswered(p) < kDoubt && !lost_.contains(p)) return false;
  return true;
}

void Removals::doubt(const Node& node) {
  const bool first = is_first_well(node);
  wire::Poll question;
  for (PeerId p = 0; p < node.config().slots; ++p) {
    const Neighbour& n = node.other(p);
    if (!first || p == desk_.self || !n.there() || node.unanswered(p) < kDoubt || lost_.contains(p)) {
      doubted_.erase(p);
      continue;
    }
    Doubted& d = doubted_[p];
    if (d.incarnation != n.incarnation) d = {n.incarnation, {}, false};
    if (question.lost.size() < wire::kMostLost) question.lost.push_back({p, n.incarnation});
  }
  if (question.lost.empty() || node.now() - doubts_asked_ < kAskAgain) return;
  doubts_asked_ = node.now();
  poll(question, node);
}

Hearsay Removals::hearsay(PeerId p, const Node& node) const {
  const Neighbour& n = node.other(p);
  const bool deaf = n.given_up < 0 && node.silence(p) < kTicksPerSecond;
  Hearsay h{node.now(), node.unanswered(p), {}, n.given_up_for_good, deaf, {}};
  if (n.given_up >= 0) h.refused = n.given_up;
  const Doubted& d = doubted_.at(p);
  for (PeerId q = 0; q < node.config().slots; ++q) {
    // Those of another side, who have frozen us, hear one another, but do not answer.
    if (q == p || !counts(q, node) || node.unanswered(q) >= kDoubt) continue;
    const auto said = d.heard.find(q);
    h.heard.push_back(said == d.heard.end() ? std::nullopt : std::optional(said->second));
  }
  return h;
}

void Removals::notice(RecordedNode& node) {
  const Node& n = node.node();
  for (PeerId p = 0; p < n.config().slots; ++p) {
    if (p == desk_.self || !n.other(p).there() || !suspected(n, p) || lost_.contains(p)) continue;
    if (coordinator(n) != desk_.self) return;
    const auto doubted = doubted_.find(p);
    if (doubted == doubted_.end()) continue;
    if (const Hearsay h = hearsay(p, n); !may_evict(h)) {
      if (is_heard(h) && !h.deaf && !std::exchange(doubted->second.told, true))
        desk_.note("peer " + std::to_string(p) + " does not answer, but others hear it: it stays", true);
      continue;
    }
    doubted_.erase(doubted);
    node.freeze(p, true);
    lost_[p].incarnation = n.other(p).incarnation;
    asked_ = n.now() - kAskAgain;
    moved_ = n.now();
    desk_.note("peer " + std::to_string(p) + " has been silent for " + std::to_string(kSilence / kTicksPerSecond) +
                   " s: asking the others for its updates",
               true);
  }
}

/// Whether it is waited for, and believed. What only somebody had who is lost by now, nobody will ever send.
bool Removals::counts(PeerId p, const Node& node) const {
  return p != desk_.self && node.other(p).reachable() && !node.departed(p) && !lost_.contains(p);
}

std::vector<PeerId> Removals::withholding(const Node& node) const {
  std::vector<PeerId> who;
  if (lost_.empty() || ordered()) return who;
  for (PeerId p = 0; p < node.config().slots; ++p) {
    // Who has been held up itself could not have heard the answers.
    if (!counts(p, node) || node.now() - std::max(moved_, node.other(p).excused) < kWithheld) continue;
    const bool silent =
        std::any_of(lost_.begin(), lost_.end(), [p](const auto& entry) { return !entry.second.have.contains(p); });
    const auto of = missing_ ? lost_.find(missing_->of) : lost_.end();
    if (silent || (of != lost_.end() && of->second.have.at(p) > missing_->index)) who.push_back(p);
  }
  return who;
}

bool Removals::all_answered(const Node& node) const {
  for (PeerId p = 0; p < node.config().slots; ++p) {
    if (!counts(p, node)) continue;
    for (const auto& [slot, lost] : lost_)
      if (!lost.have.contains(p)) return false;
  }
  return true;
}

void Removals::ask(const Node& node) {
  if (node.now() - asked_ < kAskAgain) return;
  asked_ = node.now();
  wire::Poll question{{}, true};
  for (const auto& [slot, lost] : lost_)
    if (question.lost.size() < wire::kMostLost) question.lost.push_back({slot, lost.incarnation});
  poll(question, node);
}

void Removals::poll(const wire::Poll& poll, const Node& node) {
  for (PeerId p = 0; p < node.config().slots; ++p)
    if (p != desk_.self && node.other(p).reachable() && !lost_.contains(p)) desk_.send(desk_.roster[p], poll);
}

void Removals::advance(RecordedNode& node) {
  thaw(node);
  doubt(node.node());
  notice(node);
  std::erase_if(lost_, [&](const auto& entry) { return !node.node().other(entry.first).frozen; });
  missing_.reset();
  if (lost_.empty() || ordered()) return;
  if (!all_answered(node.node())) return ask(node.node());
  for (auto& [p, lost] : lost_)
    if (!gather(p, lost, node.node())) return;
  bury(node);
}

bool Removals::ordered() const {
  return std::any_of(lost_.begin(), lost_.end(), [](const auto& entry) { return entry.second.ordered; });
}

// Whether all is here that anybody has of it and somebody may lack.
bool Removals::gather(PeerId p, Lost& lost, const Node& node) {
  const sync::UpdateLog& log = node.agreed().log();
  lost.least = lost.most = log.have(p);
  for (const auto& [q, have] : lost.have) {
    if (!counts(q, node)) continue;
    lost.least = std::min(lost.least, have);
    lost.most = std::max(lost.most, have);
  }
  for (const sync::Bundle& b : log.of(p, lost.least)) lost.fetched.emplace(b.index, b);
  for (std::uint32_t i = lost.least; i < lost.most; ++i) {
    const auto found = lost.fetched.find(i);
    if (found != lost.fetched.end()) {
      if (found->second.tick >= node.now()) return false;  // its clock was ahead
      continue;
    }
    missing_ = {p, i};
    fetch(p, lost, i, node);
    return false;
  }
  return true;
}

// Not everybody who has had an update still keeps it, not even we: who came later may have it in the state it began
// with. One is asked after the other.
void Removals::fetch(PeerId p, Lost& lost, std::uint32_t index, const Node& node) {
  if (node.now() - asked_ < kAskAgain) return;
  std::vector<PeerId> had;
  for (const auto& [q, have] : lost.have)
    if (have > index && counts(q, node)) had.push_back(q);
  if (had.empty()) return;
  asked_ = node.now();
  desk_.send(desk_.roster[had[lost.fetches++ % had.size()]], wire::Fetch{p, lost.incarnation, index});
}

void Removals::bury(RecordedNode& node) {
  sync::Bundle last;
  for (auto& [p, lost] : lost_) {
    for (std::uint32_t i = lost.least; i < lost.most; ++i) {
      sync::Bundle order;
      order.passed_on.push_back(lost.fetched.at(i));
      node.order(order);
    }
    last.removals.push_back({p, lost.incarnation, lost.most});
    lost.ordered = true;
  }
  node.order(last);
}

}  // namespace padr::node
