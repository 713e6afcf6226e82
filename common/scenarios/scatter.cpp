#include <algorithm>

#include "common/model/rng.h"
#include "common/scenarios/scene_draft.h"
#include "common/scenarios/shapes.h"

namespace padr::scenarios {
namespace {

namespace proto = padr::scenario;

// Names this use of the seed, so that other users of it draw other numbers.
constexpr std::uint64_t kScatterStream = 0x5CA77E2;
// Tries allowed: enough for a loose filling, few enough to give up within seconds on 5,000 bodies that do not fit.
constexpr std::uint64_t kTriesPerBody = 40;
constexpr std::uint64_t kTriesToStart = 4000;

float draw(Rng& rng, const proto::Range& range) {
  return static_cast<float>(rng.uniform(range.min(), range.max()));
}

const proto::Scatter::Kind& draw_kind(Rng& rng, const proto::Scatter& block) {
  double total = 0;
  for (const auto& kind : block.kind()) total += kind.share();
  double left = rng.uniform() * total;
  for (const auto& kind : block.kind()) {
    left -= kind.share();
    if (left < 0) return kind;
  }
  return block.kind(block.kind_size() - 1);  // rounding ate the last sliver
}

/// One `scatter` block being filled.
class Filling {
 public:
  Filling(SceneDraft& draft, const Document& document, int index, std::uint64_t seed)
      : draft_(draft),
        document_(document),
        block_(document.scenario().scatter(index)),
        origin_(document.origin("scatter[" + std::to_string(index) + "]")),
        rng_(derive_seed(seed, kScatterStream, static_cast<std::uint64_t>(index))) {
    lower_ = block_.has_lower() ? Vec2{static_cast<float>(block_.lower().x()), static_cast<float>(block_.lower().y())}
                                : draft.scene.lower;
    upper_ = block_.has_upper() ? Vec2{static_cast<float>(block_.upper().x()), static_cast<float>(block_.upper().y())}
                                : draft.scene.upper;
    // Never outside the play area, whatever the block says.
    lower_ = {std::max(lower_.x, draft.scene.lower.x), std::max(lower_.y, draft.scene.lower.y)};
    upper_ = {std::min(upper_.x, draft.scene.upper.x), std::min(upper_.y, draft.scene.upper.y)};
    for (const BodyDef& body : draft.scene.bodies) keep_clear_of(body, block_.gap());
    for (const BodyDef& fixed : draft.scene.statics) keep_clear_of(fixed, block_.gap());
    BodyDef avatar;
    avatar.radius = draft.scene.avatar.radius;
    for (const Vec2 spawn : draft.scene.avatar.spawns) {
      avatar.position = spawn;
      keep_clear_of(avatar, block_.spawn_clearance());
    }
  }

  void run() {
    std::uint64_t tries = kTriesToStart + kTriesPerBody * block_.count();
    for (std::uint32_t n = 0; n < block_.count(); ++n) {
      BodyDef body = next_body();
      do {
        if (tries-- == 0) give_up(n);
        place(body);
      } while (!clear(body));
      draft_.scene.bodies.push_back(body);
      draft_.bodies.push_back(origin_);
      keep_clear_of(body, block_.gap());
    }
  }

 private:
  /// A thing already there, and how far to stay from it.
  struct Neighbour {
    BodyDef def;
    double reach_and_gap;  ///< m
    double gap;            ///< m
  };

  BodyDef next_body() {
    const proto::Scatter::Kind& kind = draw_kind(rng_, block_);
    BodyDef body;
    if (kind.has_radius()) {
      body.radius = draw(rng_, kind.radius());
    } else {
      body.shape = ShapeKind::kBox;
      body.half.x = draw(rng_, kind.box().half_width());
      body.half.y = draw(rng_, kind.box().half_height());
    }
    if (kind.has_angle()) body.angle = draw(rng_, kind.angle());
    const double kg = static_cast<double>(draw(rng_, kind.has_mass() ? kind.mass() : kind.density()));
    set_mass(body, kg, kind.has_density(), origin_, document_);
    set_material(body, material_of(document_, kind.material()));
    return body;
  }

  void place(BodyDef& body) {
    const Vec2 half = extent(body);
    const double inset = block_.margin();
    const double x_low = static_cast<double>(lower_.x + half.x) + inset;
    const double x_high = static_cast<double>(upper_.x - half.x) - inset;
    const double y_low = static_cast<double>(lower_.y + half.y) + inset;
    const double y_high = static_cast<double>(upper_.y - half.y) - inset;
    if (x_low > x_high || y_low > y_high) {
      document_.fail(origin_, "leaves no room for a body that is " + std::to_string(2 * half.x) + " m x " +
                                  std::to_string(2 * half.y) + " m, allowed: a larger area, a smaller margin or body");
    }
    body.position.x = static_cast<float>(rng_.uniform(x_low, x_high));
    body.position.y = static_cast<float>(rng_.uniform(y_low, y_high));
  }

  void keep_clear_of(const BodyDef& def, double gap) { around_.push_back({def, reach(def) + gap, gap}); }

  bool clear(const BodyDef& body) const {
    const double own = reach(body);
    return std::all_of(around_.begin(), around_.end(), [&](const Neighbour& other) {
      // Centres far apart need no shapes: most pairs.
      const double far = own + other.reach_and_gap;
      const Vec2 d = body.position - other.def.position;
      return static_cast<double>(dot(d, d)) > far * far || separation(body, other.def) >= other.gap;
    });
  }

  [[noreturn]] void give_up(std::uint32_t placed) const {
    document_.fail(origin_, "found room for " + std::to_string(placed) + " of " + std::to_string(block_.count()) +
                                " bodies, allowed: fewer or smaller bodies, a smaller gap or margin, a larger area");
  }

  SceneDraft& draft_;
  const Document& document_;
  const proto::Scatter& block_;
  Origin origin_;
  Rng rng_;
  Vec2 lower_, upper_;
  std::vector<Neighbour> around_;
};

}  // namespace

void scatter(SceneDraft& draft, const Document& document, std::uint64_t seed) {
  for (int i = 0; i < document.scenario().scatter_size(); ++i) Filling(draft, document, i, seed).run();
}

}  // namespace padr::scenarios
