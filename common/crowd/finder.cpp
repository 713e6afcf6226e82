#include "common/crowd/finder.h"

#include <algorithm>
#include <utility>

#include "common/model/observed_address.h"
#include "common/replica/replica.h"

namespace padr::crowd {
namespace {

/// Asks that may be answered at once, and in a second.
constexpr double kAnswers = 500;
/// An answer that takes longer is none.
constexpr Micros kQuestion = 3 * kMicrosPerSecond;
constexpr Micros kJustNow = Search::kJustNow;
constexpr Micros kDistrust = 6 * kMicrosPerSecond;
/// Between two questions to one of those to stay acquainted with, and between any two of such.
constexpr Micros kCall = 8 * kMicrosPerSecond;
constexpr Micros kUpkeep = kMicrosPerSecond;
/// Hints that look better than what is known, asked at once.
constexpr int kHintsAtOnce = 3;
/// Even if nobody has to be asked, somebody is: that is how better acquaintances are heard of.
constexpr Micros kCurious = 4 * kMicrosPerSecond;
/// Between two questions to the contact once others are known.
constexpr Micros kHail = 15 * kMicrosPerSecond;
/// Regions far from home that acquaintances are kept for.
constexpr std::size_t kMostPosts = 6;
constexpr std::size_t kTold = 8;

std::vector<Region> regions_of(const std::vector<std::uint32_t>& ids) {
  std::vector<Region> regions;
  regions.reserve(ids.size());
  for (const std::uint32_t id : ids) regions.push_back(region_of(id));
  return regions;
}

std::vector<std::uint32_t> nearest_ids(std::vector<Region> regions, Region about) {
  std::sort(regions.begin(), regions.end(), [about](Region a, Region b) {
    return std::pair(squared_distance(a, about), a) < std::pair(squared_distance(b, about), b);
  });
  regions.resize(std::min(regions.size(), wire::kMostRegions));
  std::vector<std::uint32_t> ids;
  ids.reserve(regions.size());
  for (const Region r : regions) ids.push_back(id_of(r));
  return ids;
}

bool far_apart(Region a, Region b) {
  return squared_distance(a, b) > kNextTo;
}

}  // namespace

Finder::Finder(const Config& config)
    : config_(config),
      rng_(derive_seed(config.seed, 0xF1D)),
      rank_(rng_.next_u32()),
      crowd_(plane_hash(config.plane)),
      met_(!config.contact),
      answers_(kAnswers) {}

// ---- in and out

void Finder::receive(const Endpoint& from, std::span<const std::byte> datagram, Micros local) {
  wire::SealError error{};
  const auto opened = wire::open(datagram, error);
  if (!opened || opened->header.kind != wire::Kind::kSession) {
    ++stats_.malformed;
    return;
  }
  const auto message = wire::decode_session(opened->payload);
  if (const auto* ask = message ? std::get_if<wire::Ask>(&*message) : nullptr) {
    take(from.place(), *ask, datagram.size(), local);
  } else if (const auto* tell = message ? std::get_if<wire::Tell>(&*message) : nullptr) {
    take(from.place(), *tell, local);
  } else {
    ++stats_.malformed;
  }
}

void Finder::send(const Endpoint& to, std::span<const std::byte> payload) {
  outgoing_.push_back({to, kNoPeer, wire::seal({wire::Kind::kSession, kNoPeer, 0}, payload)});
  stats_.bytes += outgoing_.back().bytes.size() + node::kIpUdpBytes;
}

bool Finder::may_answer(Micros local) {
  answers_ = std::min(kAnswers, answers_ + static_cast<double>(local - answered_) * kAnswers / kMicrosPerSecond);
  answered_ = local;
  if (answers_ < 1) return false;
  answers_ -= 1;
  return true;
}

wire::Whereabouts Finder::whereabouts(Region about) const {
  std::vector<Region> sought;
  for (const auto& [r, search] : searches_) sought.push_back(r);
  return {nearest_ids(standing_.in, about), nearest_ids(std::move(sought), about)};
}

void Finder::ask(const Endpoint& to, Region about, Micros local) {
  std::uint64_t nonce = rng_.next_u64();
  if (nonce == 0) nonce = 1;
  questions_[nonce] = {to, about, local};
  if (Acquaintance* a = book_.find(to)) {
    a->asked = local;
    if (a->unanswered++ == 0) a->asked_first = local;
  }
  send(to, wire::encode_session(wire::Ask{nonce, crowd_, id_of(about), whereabouts(about), rank_}));
  ++stats_.asks;
}

void Finder::take(const Endpoint& from, const wire::Ask& ask, std::size_t size, Micros local) {
  // Only whoever was asked knows the nonce.
  if (questions_.contains(ask.nonce)) {
    if (!met_) failure_ = "the peer to join, " + to_string(from) + ", is this peer itself";
    return;
  }
  if (!may_answer(local)) {
    ++stats_.unanswered;
    return;
  }
  const Region about = region_of(ask.about);
  wire::Tell tell{ask.nonce, crowd_, ask.about, {}, rank_};
  if (ask.crowd != crowd_) {
    ++stats_.strange;
    return answer(from, tell, size);
  }
  if (Acquaintance* a = book_.note(from)) {
    a->in = regions_of(ask.sender.in);
    a->seeks = regions_of(ask.sender.seeks);
    a->rank = ask.rank;
    a->hinted = local;
    a->unanswered = 0;  // it is alive, whatever became of its answers
    tell.noted = AddressBook::fresh(*a, local);
    if (!tell.noted && local - a->asked > kAskAgain) this->ask(from, about, local);
  }
  tell.sender = whereabouts(about);
  tell.clock = standing_.clock;
  for (const Acquaintance* a : book_.to_tell_of(about, kTold + 1, rng_))
    if (a->at != from && AddressBook::fresh(*a, local) && tell.known.size() < kTold)
      tell.known.push_back({a->at, {nearest_ids(a->in, about), nearest_ids(a->seeks, about)}});
  answer(from, tell, size);
}

// Whoever asks has proven nothing: no answer is larger than what provoked it.
void Finder::answer(const Endpoint& to, const wire::Tell& tell, std::size_t size) {
  const auto payload = wire::encode_tell_within(tell, size - wire::kHeaderBytes - wire::kTagBytes);
  if (!payload) return;
  send(to, *payload);
  ++stats_.tells;
}

void Finder::take(const Endpoint& from, const wire::Tell& tell, Micros local) {
  const auto question = questions_.find(tell.nonce);
  if (question == questions_.end() || question->second.to != from || id_of(question->second.about) != tell.about) {
    ++stats_.strange;
    return;
  }
  const Question q = question->second;
  questions_.erase(question);
  if (tell.crowd != crowd_) {
    ++stats_.strange;
    book_.forget(from);
    if (!met_) failure_ = "peer at " + to_string(from) + " is in another crowd: its plane or its seed differs";
    return;
  }
  met_ = true;
  contact_met_ = contact_met_ || (config_.contact && same_place(from, *config_.contact));
  if (Acquaintance* a = book_.note(from)) {
    a->in = regions_of(tell.sender.in);
    a->seeks = regions_of(tell.sender.seeks);
    a->rank = tell.rank;
    a->heard = local;
    a->unanswered = 0;
  }
  take_clock(tell, q.sent, local);
  for (const wire::Acquaintance& k : tell.known) hear_say(k, as_seen_from(k.at, from), q.about, local);
  const auto search = searches_.find(q.about);
  if (search == searches_.end() || q.sent < search->second.began() || !tell.noted) return;
  search->second.note_told(from, q.sent, local);
}

void Finder::hear_say(const wire::Acquaintance& of, const Endpoint& at, Region about, Micros local) {
  Acquaintance* a = book_.note(at);
  if (a == nullptr) return;
  a->hinted = local;
  const auto search = searches_.find(about);
  std::vector<Region> in = regions_of(of.where.in);
  std::vector<Region> seeks = regions_of(of.where.seeks);
  if (search != searches_.end()) {
    if (contains(in, about) && !a->is_in(about)) search->second.note_there(at, local);
    if (contains(seeks, about) && !a->looks_for(about)) search->second.note_looks(at, local);
  }
  if (AddressBook::fresh(*a, local)) return;  // it has said better itself
  a->in = std::move(in);
  a->seeks = std::move(seeks);
}

// The shorter the trip, the nearer to the truth.
void Finder::take_clock(const wire::Tell& tell, Micros sent, Micros local) {
  const Micros trip = local - sent;
  if (tell.clock == 0 || (trip_ >= 0 && trip > trip_)) return;
  trip_ = trip;
  offset_ = tell.clock + trip / 2 - local;
}

std::optional<Micros> Finder::clock(Micros local) const {
  if (trip_ < 0) return std::nullopt;
  return local + offset_;
}

// ---- looking for regions

void Finder::advance(Standing standing, const std::vector<Region>& sought, Micros local) {
  if (local < next_) return;
  next_ = local + kPace;
  const bool about = looks_about(sought, local);
  if (!about) standing.fellows = std::move(standing_.fellows);
  standing_ = std::move(standing);
  if (about) {
    looked_about_ = local;
    book_.set_fellows(standing_.fellows);
    book_.expire(local);
  }
  std::erase_if(questions_, [local](const auto& q) { return local - q.second.sent > kQuestion; });
  std::erase_if(distrust_, [local](const auto& d) { return d.second <= local; });
  std::erase_if(searches_,
                [&](const auto& s) { return std::find(sought.begin(), sought.end(), s.first) == sought.end(); });
  for (const Region r : sought) searches_.try_emplace(r, local);
  for (auto& [r, search] : searches_) {
    search.forget_unknown(book_);
    look(r, search, local);
  }
  for (const Finding& f : findings_) searches_.erase(f.region);
  if (about) note_strangers(local);
  keep_acquainted(local);
}

std::size_t Finder::sayings() const {
  std::size_t n = 0;
  for (const auto& [r, search] : searches_) n += search.sayings();
  return n;
}

std::optional<Endpoint> Finder::member_of(Region r, Micros local) {
  std::vector<Endpoint> members;
  for (const Acquaintance* a : book_.all())
    if (a->is_in(r) && local - a->heard < kJustNow && !distrust_.contains({r, a->at})) members.push_back(a->at);
  if (members.empty()) return std::nullopt;
  return members[rng_.below(static_cast<std::uint32_t>(members.size()))];
}

void Finder::look(Region r, Search& search, Micros local) {
  if (const auto member = member_of(r, local)) {
    findings_.push_back({r, member});
    return;
  }
  const std::vector<Acquaintance*> all = book_.all();
  const bool somebody = std::any_of(all.begin(), all.end(), [&](const Acquaintance* a) {
    return a->is_in(r) && local - a->heard < kJustNow;  // by whom it could not come in lately
  });
  if (!all_said(r, search, local) || somebody) return;
  const Micros settled = search.settle(local);
  if (gives_way(r, local) && local - settled < kGiveWay) return;
  findings_.push_back({r, std::nullopt});
  standing_.in.push_back(r);  // nobody who asks in this moment shall found it, too
}

// Asks those nearest, and whether they all have said by now that they know nobody there. Each has to have said so after
// it has noted that this peer looks for the region: of two who look for it at the same time, and both ask the same one,
// it will then tell at least the one whom it noted later of the other. And of two who look for it, of whom only one has
// been told of the other, that one does not found it before the other knows.
bool Finder::all_said(Region r, Search& search, Micros local) {
  const std::vector<Acquaintance*> nearest = book_.nearest(r, kNearest);
  search.note_nearest(nearest, local);
  bool all = true;
  for (const Acquaintance* a : nearest) {
    const bool enough = search.has_said(*a, search.changed(), local);
    all = all && enough;
    if (!enough && local - a->asked >= kAskAgain) ask(a->at, r, local);
  }
  const std::vector<Acquaintance*> rivals = book_.rivals(r, kRivals);
  for (const Acquaintance* a : rivals) {
    const bool enough = search.has_said(*a, search.began(), local);
    all = all && enough;
    if ((!enough || a->rank < rank_) && local - a->asked >= kAskAgain) ask(a->at, r, local);
  }
  const bool nobody = nearest.empty() && rivals.empty();
  const bool settled = local - search.changed() >= kSettle;
  if (!config_.contact) return all && (settled || nobody) && all_rumoured_said(r, search, local);
  // Others who have just come may be known already: the contact knows the crowd, or comes before them.
  if ((nobody || !contact_met_) && local - hailed_ >= kAskAgain) {
    hailed_ = local;
    ask(*config_.contact, r, local);
  }
  const bool alone = nobody && local - search.began() > 2 * kSettle;
  const bool clear = contact_met_ && (trip_ >= 0 || standing_.clock > 0) && settled && all && (!nobody || alone);
  return clear && all_rumoured_said(r, search, local);
}

// They may be neither near, nor rivals, by what they have said themselves, which others know better by now. The last to
// be asked: hardly any search comes so far.
bool Finder::all_rumoured_said(Region r, Search& search, Micros local) {
  const std::vector<Acquaintance*> rumoured = search.rumoured(book_, local);
  for (const Acquaintance* a : rumoured)
    if (local - a->asked >= kAskAgain) ask(a->at, r, local);
  return rumoured.empty();
}

bool Finder::gives_way(Region r, Micros local) {
  const std::vector<Acquaintance*> all = book_.all();
  return std::any_of(all.begin(), all.end(), [&](const Acquaintance* a) {
    return a->looks_for(r) && a->rank < rank_ && AddressBook::fresh(*a, local);
  });
}

void Finder::distrust(Region r, const Endpoint& member, Micros local) {
  distrust_[{r, member.place()}] = local + kDistrust;
}

bool Finder::is_fellow_in(const Endpoint& at, Region r) const {
  return std::binary_search(standing_.fellows.begin(), standing_.fellows.end(), std::pair(at, r));
}

// Who has only just come in may not have been heard of here: it takes a while to be a stranger.
void Finder::note_strangers(Micros local) {
  std::map<std::pair<Region, Endpoint>, Micros> now;
  for (const Acquaintance* a : book_.all()) {
    for (const Region r : a->in) {
      if (!contains(standing_.in, r) || (a->fellow && is_fellow_in(a->at, r))) continue;
      if (local - a->heard > kJustNow / 2 && local - a->asked > kAskAgain) ask(a->at, r, local);
      if (local - a->heard > kJustNow) continue;
      const auto since = strangers_.find({r, a->at});
      now[{r, a->at}] = since == strangers_.end() ? local : since->second;
    }
  }
  strangers_ = std::move(now);
}

std::vector<std::pair<Region, Endpoint>> Finder::strangers(Micros local) const {
  std::vector<std::pair<Region, Endpoint>> all;
  for (const auto& [who, since] : strangers_)
    if (local - since > kStranger) all.push_back(who);
  return all;
}

std::vector<Finder::Finding> Finder::take_findings() {
  return std::exchange(findings_, {});
}

std::vector<node::Parcel> Finder::take_outgoing() {
  return std::exchange(outgoing_, {});
}

// ---- staying acquainted

// From where others must find the way to this peer's regions: home, and what it keeps far from there.
std::vector<Region> Finder::posts() const {
  std::vector<Region> posts{standing_.home};
  for (const Region r : standing_.in)
    if (far_apart(r, standing_.home) && posts.size() < kMostPosts) posts.push_back(r);
  return posts;
}

void Finder::keep_acquainted(Micros local) {
  if (local < upkeep_) return;
  upkeep_ = local + kUpkeep;
  const std::vector<Region> posts = this->posts();
  Acquaintance* longest = nullptr;
  Region about;
  int hints = 0;
  for (const Region post : posts)
    for (Acquaintance* a : book_.all_around(post)) {
      // Who is with us elsewhere may not know that we are here.
      if ((a->fellow && (post == standing_.home || a->is_in(post))) || local - a->asked < kAskAgain) continue;
      if (a->heard == Acquaintance::kNever) {
        if (hints++ < kHintsAtOnce) ask(a->at, post, local);
      } else if (local - a->heard > kCall && (longest == nullptr || a->heard < longest->heard)) {
        longest = a;
        about = post;
      }
    }
  const bool curious = longest == nullptr && hints == 0 && local - called_ > kCurious;
  if (curious) {
    about = posts[rng_.below(static_cast<std::uint32_t>(posts.size()))];
    const std::vector<Acquaintance*> near = book_.to_tell_of(about, 2 * kNearest, rng_);
    if (!near.empty()) longest = near[rng_.below(static_cast<std::uint32_t>(near.size()))];
  }
  if (longest != nullptr) ask(longest->at, about, local);
  if (longest != nullptr || hints > 0) called_ = local;
  if (config_.contact && local - hailed_ > kHail && book_.find(*config_.contact) == nullptr) {
    hailed_ = local;
    ask(*config_.contact, standing_.home, local);
  }
}

}  // namespace padr::crowd
