#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/model/rng.h"
#include "common/participant/participant.h"
#include "tools/lab/testbed/liar.h"

namespace padr::lab {

/// A liar in a session: what its lies are made with.
class Deceiver {
 public:
  /// The first two must outlive it.
  Deceiver(Liar& with, const node::Participant& peer, std::uint64_t seed, std::uint32_t which)
      : liar(with), self(peer), rng(seed), variant(which) {}

  Liar& liar;
  const node::Participant& self;  ///< its own, honest inside
  Rng rng;
  std::uint32_t variant;  ///< of its behaviour: read modulo what there is
  bool active = false;    ///< lies now; otherwise it only stays with the lies that it has told

  const node::Replica& replica() const { return self.replica(); }
  /// A member that is there, always the same one while it is; kNoPeer if there is none.
  PeerId victim();
  /// Whether this member belongs to those who are told the second of two stories.
  static bool is_other_half(PeerId p) { return p % 2 == 1; }
  /// An unsealed datagram of the liar's that says this.
  wire::Bytes said(const wire::MembershipMessage& message) const;

 private:
  PeerId victim_ = kNoPeer;
};

using Plot = std::shared_ptr<Deceiver>;

/// One of the ways in which a member lies.
struct Behaviour {
  std::string_view name;
  std::string_view what;            ///< one line
  void (*begin)(const Plot& plot);  ///< sets the liar's hooks; they ask `active`
};

/// All twenty, in the order in which --help lists them.
std::span<const Behaviour> behaviours();
/// A line for each, and for `none`.
std::string help_on_behaviours();
/// Null if there is none of that name. `none` is honest.
const Behaviour* behaviour(std::string_view name);

/// Gives updates of the liar's other contents: an update is the same whenever it is told again, so that a lie that is
/// meant for all is the same for all. What was told before stays as it was.
class Rewriting {
 public:
  /// What an update that has not been told yet becomes; nothing: it stays as it is.
  using Choice = std::function<std::optional<sync::Bundle>(const sync::Bundle&)>;

  Rewriting(Plot plot, Choice choice) : plot_(std::move(plot)), choice_(std::move(choice)) {}
  void operator()(sync::StatePacket& packet);

 private:
  const std::optional<sync::Bundle>& fate_of(const sync::Bundle& b);

  Plot plot_;
  Choice choice_;
  std::uint32_t incarnation_ = 0;
  std::uint32_t first_ = 0;  ///< number of the first update that may be changed
  bool begun_ = false;
  std::map<std::uint32_t, std::optional<sync::Bundle>> said_;  ///< by number
};

/// An update with the number and tick of this one, and nothing in it.
sync::Bundle emptied(const sync::Bundle& b);
/// A random place in the scene.
Vec2 some_place(Rng& rng, const Scene& scene);

// Each begins one behaviour; lies.cpp says what they are.
void lie_with_values(const Plot& plot);
void lie_with_signatures(const Plot& plot);
void lie_far_ahead(const Plot& plot);
void lie_by_withholding(const Plot& plot);
void lie_with_acks(const Plot& plot);
void lie_with_two_logs(const Plot& plot);
void lie_by_equivocation(const Plot& plot);
void lie_with_hashes(const Plot& plot);
void lie_with_epochs(const Plot& plot);
void lie_with_teleports(const Plot& plot);
void lie_about_time(const Plot& plot);
void lie_with_farewells(const Plot& plot);
void lie_with_removals(const Plot& plot);
void lie_with_orders_to_some(const Plot& plot);
void lie_with_admissions(const Plot& plot);
void lie_with_relays(const Plot& plot);
void lie_with_probes(const Plot& plot);
void lie_with_answers(const Plot& plot);
void lie_with_polls(const Plot& plot);
void lie_to_joiners(const Plot& plot);

}  // namespace padr::lab
