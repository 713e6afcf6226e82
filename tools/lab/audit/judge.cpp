#include "tools/lab/audit/judge.h"

#include <algorithm>

#include "tools/lab/audit/margins.h"

namespace padr::lab::audit {
namespace {

// A push is recorded at the tick before the step that tells of it; where there was no room, it is told later.
constexpr Tick kToldLater = kTicksPerSecond;
constexpr float kAvatarOff = 1.5F;  // m, of an avatar from its model

bool mentions(const std::vector<sync::Bundle>& said, PeerId but, EntityId body) {
  return std::any_of(said.begin(), said.end(), [&](const sync::Bundle& b) {
    return b.peer != but &&
           std::any_of(b.bodies.begin(), b.bodies.end(), [body](const sync::BodyUpdate& u) { return u.body == body; });
  });
}

}  // namespace

Judge::Judge(const Evidence& evidence, std::size_t trace, const Limits& limits, bool pushes)
    : evidence_(evidence),
      facts_(evidence.traces[trace]),
      trace_(trace),
      limits_(limits),
      authority_(facts_.header.technique.authority),
      may_push_(pushes),
      around_(limits, facts_.header.bodies, facts_.header.slots),
      sitters_(static_cast<std::size_t>(facts_.header.slots)) {}

void Judge::take(const sync::FoldState& confirmed, const sync::UpdateLog* log) {
  if (!around_.empty() && log != nullptr) {
    const std::vector<sync::Bundle>& said = log->at(around_.tick());
    for (const sync::Bundle& b : said)
      if (sitters_[b.peer].present) judge_update(b, said);
    around_.hear(said);
  }
  seat(confirmed);
  around_.take(confirmed);
}

// Whoever comes in stands where it comes in, from the tick of its admission on: that is the one before the first
// confirmed world that has it. Of those who were there before the trace begins the first word counts.
void Judge::seat(const sync::FoldState& s) {
  for (PeerId p = 0; p < sitters_.size(); ++p) {
    const sync::Member& m = s.members[p];
    Sitter& there = sitters_[p];
    const bool another = m.present && (!there.present || there.incarnation != m.incarnation);
    if (another) {
      there = {};
      there.incarnation = m.incarnation;
      there.member = evidence_.members.sitter(trace_, p, m.incarnation);
      const EntityId avatar = around_.avatar(p);
      const bool comes_now = s.tick == 0 || !around_.empty();
      const Tick since = std::max(s.tick - 1, 0);
      if (comes_now) there.last = AvatarWord{since, s.world.entities[avatar].position, {}};
    }
    there.present = m.present;
    if (there.last && !s.playing()) there.last->tick = s.tick;
  }
}

bool Judge::differs(const Sitter& s, Tick tick) const {
  const PeerId slot = evidence_.members[*s.member].slot;
  return facts_.hashes.before({slot, s.incarnation}, tick) == HashRecord::Verdict::kDiffers;
}

void Judge::judge_update(const sync::Bundle& update, const std::vector<sync::Bundle>& said) {
  Sitter& s = sitters_[update.peer];
  if (!s.member || !around_.now().playing()) return;
  ++judged_;
  if (update.bodies.size() >= sync::kMaxBodiesPerSigned) s.full = update.tick;
  if (update.avatar) judge_avatar(s, update);
  if (!authority_) return;
  judge_claims(s, update);
  for (const sync::BodyUpdate& u : update.bodies)
    if (u.has_state) judge_body(s, update, u, mentions(said, update.peer, u.body));
}

AvatarCase Judge::avatar_case(const Sitter& s, const sync::Bundle& update) const {
  AvatarCase c;
  c.before = *s.last;
  c.now = {update.tick, update.avatar->position, update.avatar->velocity};
  c.avatars = std::max(around_.fastest_avatar(update.peer),
                       evidence_.ledger.fastest_said(update.tick - kLately, update.tick, *s.member));
  c.bodies = std::max(around_.fastest_body(), c.avatars);
  const float fastest = limits_.avatar_speed_touching(c.avatars, c.bodies);
  const Way way{c.before.position, c.now.position, fastest * c.seconds()};
  const bool holds = std::any_of(around_.now().holds.begin(), around_.now().holds.end(),
                                 [&](PeerSet h) { return (h & only(update.peer)) != 0; });
  const bool too_long = c.now.tick - c.before.tick >= kLately;
  c.body = too_long || !authority_ || holds || !update.bodies.empty() || around_.may_touch_body(way);
  c.avatar = too_long || around_.may_touch_avatar(way, update.peer);
  c.obstacle = too_long || around_.may_touch_obstacle(way);
  return c;
}

void Judge::judge_avatar(Sitter& s, const sync::Bundle& update) {
  const AvatarWord now{update.tick, update.avatar->position, update.avatar->velocity};
  if (s.last && s.last->tick < update.tick) {
    const AvatarCase c = avatar_case(s, update);
    for (const Measure& m : judge(limits_, c)) {
      const bool rests_on_world = m.kind == Kind::kAvatarAcceleration;
      if (!rests_on_world || !differs(s, update.tick)) weigh(s, update, kNoEntity, m);
    }
    judge_way(s, update, c);
  }
  s.last = now;
}

void Judge::judge_way(Sitter& s, const sync::Bundle& update, const AvatarCase& c) {
  if (s.way.empty()) s.way.push_back(c.before);
  s.way.push_back(c.now);
  while (s.way.size() > 2 && s.way.front().tick < update.tick - kWayTicks) s.way.pop_front();
  float way = 0;
  for (std::size_t i = 1; i < s.way.size(); ++i) way += distance(s.way[i - 1].position, s.way[i].position);
  const float seconds = static_cast<float>(update.tick - s.way.front().tick) * kTickSeconds;
  const Measure m = audit::judge_way(limits_, way, seconds, c.avatars, c.bodies);
  weigh(s, update, kNoEntity, m);
  if (m.exceeds()) s.way = {c.now};
}

// The first word of a claim: one that has been lost since is still told of, until its member hears of that.
bool Judge::is_claim(const Sitter& s, const sync::Bundle& update, const sync::BodyUpdate& u) const {
  const sync::Authority& a = around_.now().authority[u.body];
  if (!u.has_state || (a.owner == update.peer && a.epoch == u.epoch)) return false;
  const auto before = s.bodies.find(u.body);
  return before == s.bodies.end() || before->second.epoch != u.epoch || before->second.claimed != u.claimed;
}

// A member may push any body without being near. Where its own trace is there, that has it.
bool Judge::is_push(const Sitter& s, const sync::Bundle& update, const sync::BodyUpdate& u) const {
  if (!may_push_ || u.cause != sync::Cause::kContactBegin || u.held || !u.has_state) return false;
  const TraceFacts* own = evidence_.own_trace(*s.member, update.tick);
  if (own == nullptr) return true;
  const auto pushes = own->pushes.find(u.body);
  return pushes != own->pushes.end() && std::any_of(pushes->second.begin(), pushes->second.end(), [&](Tick t) {
           return t <= update.tick && t >= update.tick - kToldLater;
         });
}

std::vector<Place> Judge::own_places(const Sitter& s, const sync::Bundle& update) const {
  const EntityId avatar = around_.avatar(update.peer);
  std::vector<Place> own;
  if (update.avatar)
    own.push_back({avatar, update.avatar->position, kCalmBodyUnsure});
  else
    own.push_back({avatar, around_.position(avatar), kAvatarOff});
  if (s.last && !update.avatar) own.push_back({avatar, s.last->position, kCalmBodyUnsure});
  for (EntityId b = 0; b < around_.bodies(); ++b)
    if (around_.now().authority[b].owner == update.peer && around_.is_stirred(b))
      own.push_back({b, around_.position(b), around_.moves_within(b)});
  return own;
}

void Judge::judge_claims(const Sitter& s, const sync::Bundle& update) {
  if (update.tick - s.full < kLately || differs(s, update.tick)) return;
  std::vector<Place> claims;
  for (const sync::BodyUpdate& u : update.bodies) {
    if (!is_claim(s, update, u)) continue;
    if (is_push(s, update, u))
      pushes_.push_back({*s.member,
                         update.index,
                         update.tick,
                         u.body,
                         length(u.state.velocity),
                         evidence_.own_trace(*s.member, update.tick) != nullptr,
                         {trace_}});
    else
      claims.push_back({u.body, u.state.position, kCalmBodyUnsure});
  }
  if (claims.empty()) return;
  const std::vector<Measure> measures = audit::judge_claims(limits_, around_, own_places(s, update), claims);
  for (std::size_t i = 0; i < claims.size(); ++i) weigh(s, update, claims[i].entity, measures[i]);
}

float Judge::jump_of(const Sitter& s) const {
  const TraceFacts* own = evidence_.own_trace(*s.member, 0);
  return own != nullptr && !own->plays_alone ? kJump : kJumpAlone;
}

// Only where the member is known to have confirmed the body there, and nobody can have told it otherwise since: either
// it agrees with the trace afterwards, too, or its claim follows the agreed one, with none between.
std::optional<Vec2> Judge::where_it_lay(const Sitter& s, const sync::Bundle& update, const sync::BodyUpdate& u) const {
  const HashRecord::Sitter who{update.peer, s.incarnation};
  const Tick known = std::min(facts_.hashes.confirmed_by(who, update.tick), update.tick - kLately);
  if (around_.calm_since(u.body) > known || !around_.is_alone(u.body, update.peer, kAlone)) return std::nullopt;
  const bool follows = u.epoch == around_.now().authority[u.body].epoch + 1;
  const bool agrees = facts_.hashes.after(who, update.tick) == HashRecord::Verdict::kSame;
  if (differs(s, update.tick) || (!follows && !agrees)) return std::nullopt;
  return around_.position(u.body);
}

void Judge::judge_body(Sitter& s, const sync::Bundle& update, const sync::BodyUpdate& u, bool others_tell) {
  BodyCase c;
  c.body = u.body;
  c.state = u.state;
  const float said = evidence_.ledger.fastest_said(update.tick - kLately, update.tick, *s.member);
  c.fastest = std::max({around_.fastest_body(), around_.fastest_avatar(kNoPeer), said});
  c.pushed = is_push(s, update, u);
  const auto before = s.bodies.find(u.body);
  if (before != s.bodies.end() && before->second.epoch == u.epoch && before->second.claimed == u.claimed)
    c.before = {before->second.position, static_cast<float>(update.tick - before->second.tick) * kTickSeconds};
  if (!others_tell && is_claim(s, update, u)) c.lay_at = where_it_lay(s, update, u);
  c.jump = jump_of(s);
  for (const Measure& m : judge(limits_, c)) weigh(s, update, u.body, m);
  s.bodies[u.body] = {u.epoch, u.claimed, update.tick, u.state.position};
}

void Judge::weigh(const Sitter& s, const sync::Bundle& update, EntityId body, const Measure& e) {
  Measure& closest = closest_[static_cast<std::size_t>(e.kind)];
  closest = nearer(closest, e);
  if (!e.exceeds()) return;
  Finding f;
  f.kind = e.kind;
  f.who = *s.member;
  f.index = update.index;
  f.tick = update.tick;
  f.body = body;
  f.measured = e.measured;
  f.allowed = e.allowed;
  f.is_signed = evidence_.is_signed(*s.member, update);
  f.traces = {trace_};
  findings_.push_back(std::move(f));
}

}  // namespace padr::lab::audit
