#pragma once

#include <vector>

#include "common/model/scene.h"
#include "common/scenarios/document.h"

namespace padr::scenarios {

/// What two things that are meant to touch may overlap at the start, m: Box2D's own linear slop.
inline constexpr double kTouchTolerance = 0.005;

/// A scene in the making, with where in the file each of its things was written.
struct SceneDraft {
  Scene scene;
  std::vector<Origin> bodies;   ///< one per scene.bodies
  std::vector<Origin> statics;  ///< one per scene.statics
};

/// All of the file except `scatter`, in plain structs. Throws UserError (through Document::fail).
SceneDraft draft_of(const Document& document);

/// Throws UserError unless the play area has a size, and everything in the draft starts inside it, apart from
/// everything else. Fixed things may overlap one another and stand outside.
void check_placement(const SceneDraft& draft, const Document& document);

/// Adds the bodies of every `scatter` block. The same seed gives the same bodies; the streams of the blocks are
/// independent, so that a change to one leaves the others' choices alone. Throws UserError if they do not fit.
void scatter(SceneDraft& draft, const Document& document, std::uint64_t seed);

/// Adds the avatar's `more_spawns` to those that it lists, as far as there is room for avatars. The same seed gives the
/// same places. Throws UserError if there would be more than kMaxPeers in all.
void add_spawns(SceneDraft& draft, const Document& document, std::uint64_t seed);

/// The material of a body: what it says itself, else what the scenario says, else the defaults of scenario.proto.
padr::scenario::Material material_of(const Document& document, const padr::scenario::Material& own);
void set_material(BodyDef& body, const padr::scenario::Material& material);

/// Sets the mass, `kg` times the area in m^2 if that is a density. Throws UserError outside the range that
/// scenario.proto gives masses.
void set_mass(BodyDef& body, double kg, bool is_density, const Origin& origin, const Document& document);

}  // namespace padr::scenarios
