#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "common/sync/update_log.h"
#include "tools/lab/audit/avatar_rule.h"
#include "tools/lab/audit/body_rule.h"
#include "tools/lab/audit/evidence.h"
#include "tools/lab/audit/reach.h"
#include "tools/lab/audit/surroundings.h"

namespace padr::lab::audit {

/// What one trace's agreed world says about the updates that it rests on, tick by tick.
class Judge {
 public:
  /// `pushes`: as in Options.
  Judge(const Evidence& evidence, std::size_t trace, const Limits& limits, bool pushes);

  /// The next confirmed world. `log`: has the updates of the tick before; null before the first.
  void take(const sync::FoldState& confirmed, const sync::UpdateLog* log);

  const std::vector<Finding>& findings() const { return findings_; }
  const std::vector<Push>& pushes() const { return pushes_; }
  std::uint64_t judged() const { return judged_; }  ///< updates
  /// By kind, what came nearest to a limit, or exceeded it by most.
  const std::array<Measure, kKinds>& closest() const { return closest_; }

 private:
  struct BodyWord {
    std::uint32_t epoch = 0;
    Tick claimed = 0;
    Tick tick = 0;
    Vec2 position;
  };
  /// What is remembered of whoever sits in a slot.
  struct Sitter {
    bool present = false;
    std::uint32_t incarnation = 0;
    std::optional<MemberId> member;
    std::optional<AvatarWord> last;
    std::deque<AvatarWord> way;
    std::map<EntityId, BodyWord> bodies;
    Tick full = -1'000'000;  ///< tick of its last update that had no room for another body
  };
  void seat(const sync::FoldState& confirmed);
  void judge_update(const sync::Bundle& update, const std::vector<sync::Bundle>& said);
  void judge_avatar(Sitter& s, const sync::Bundle& update);
  AvatarCase avatar_case(const Sitter& s, const sync::Bundle& update) const;
  void judge_way(Sitter& s, const sync::Bundle& update, const AvatarCase& c);
  void judge_body(Sitter& s, const sync::Bundle& update, const sync::BodyUpdate& u, bool others_tell);
  std::optional<Vec2> where_it_lay(const Sitter& s, const sync::Bundle& update, const sync::BodyUpdate& u) const;
  float jump_of(const Sitter& s) const;
  void judge_claims(const Sitter& s, const sync::Bundle& update);
  std::vector<Place> own_places(const Sitter& s, const sync::Bundle& update) const;
  bool is_claim(const Sitter& s, const sync::Bundle& update, const sync::BodyUpdate& u) const;
  bool is_push(const Sitter& s, const sync::Bundle& update, const sync::BodyUpdate& u) const;
  bool differs(const Sitter& s, Tick tick) const;
  void weigh(const Sitter& s, const sync::Bundle& update, EntityId body, const Measure& measure);

  const Evidence& evidence_;
  const TraceFacts& facts_;
  std::size_t trace_;
  const Limits& limits_;
  bool authority_;
  bool may_push_;
  Surroundings around_;
  std::vector<Sitter> sitters_;  ///< by slot
  std::vector<Finding> findings_;
  std::vector<Push> pushes_;
  std::uint64_t judged_ = 0;
  std::array<Measure, kKinds> closest_{};
};

}  // namespace padr::lab::audit
