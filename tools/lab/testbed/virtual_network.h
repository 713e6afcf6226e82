#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/link/link_mesh.h"
#include "common/model/rng.h"
#include "common/participant/participant.h"
#include "common/scenarios/input.h"

namespace padr::lab {

struct VirtualNetworkConfig {
  Scene scene;
  Technique technique;
  link::NetemSpec netem;  ///< of every directed link, until told otherwise
  std::uint64_t seed = 1;
  int slots = 12;
  int wanted = 2;                                ///< peers the founder waits for
  wire::SealMode seal = wire::SealMode::kNone;   ///< not kNone: the session has a key, drawn with the seed
  bool refusals = false;                         ///< senders are told where nobody listens any more
  double most_ppm = 100;                         ///< how far a peer's clock may be off its rate
  std::function<double(int person)> ppm;         ///< by how much it is; empty: drawn
  std::function<sync::Fault(int person)> fault;  ///< for tests only
  /// The machine a person runs on. Who is on the same one can be reached at its loopback address, too. Empty: everybody
  /// has a machine of their own.
  std::function<int(int person)> host;
  std::function<bool(int person)> spectates;  ///< who has no avatar; empty: nobody
  /// Where a person's incarnation 0, 1, ... is recorded to.
  std::function<std::optional<node::RecordedReplica::Recording>(int person, int incarnation)> recording;
};

/// Whole peers that come and go, on one virtual clock and network. Persons are numbered in the order they start, and
/// each keeps its address, its clock's offset and rate, and its input.
class VirtualNetwork {
 public:
  explicit VirtualNetwork(VirtualNetworkConfig config);
  ~VirtualNetwork();

  /// A process starts; it founds a session, or joins the one of `by`, over the loopback address if it is told so. Its
  /// number.
  int start(std::optional<int> by, bool over_loopback = false);
  void leave(int person);
  void kill(int person);
  void pause(int person, bool paused);
  /// While it was paused, its clock stood still for so long, us, as a suspended machine's does.
  void stand_still(int person, Micros duration);
  /// A person's user pushes a body.
  void push(int person, EntityId body, Vec2 velocity) { persons_[at(person)].peer->push(body, velocity); }
  /// Datagrams between persons of different sides vanish; by person, who are not named are on side 0.
  void divide(std::map<int, int> sides) { sides_ = std::move(sides); }
  bool divided() const { return !sides_.empty(); }
  /// Whether what one person sends comes to another, unless its link loses it.
  bool connected(int from, int to) const;
  /// Whom a person was told of when it started; nothing if it founded.
  std::optional<int> introducer_of(int person) const { return persons_[at(person)].by; }
  /// What one person sends another vanishes, or no longer; the other way goes on as it is.
  void cut(int from, int to, bool off) { off ? (void)cuts_.insert({from, to}) : (void)cuts_.erase({from, to}); }
  void shape(const link::NetemSpec& netem);
  /// Of one directed link, until all are shaped.
  void shape(int from, int to, const link::NetemSpec& netem) { links_.link(at(from), at(to)).set_spec(now_, netem); }
  /// Somebody says so in the name of the machine that is there.
  void tell_unreachable(int person, const Endpoint& where) { persons_[at(person)].refused.push_back(where); }
  const Endpoint& place_of(int person) const { return persons_[at(person)].place; }
  /// All avatars are drawn to this point until told otherwise.
  void attract(std::optional<Vec2> where) { attraction_ = where; }

  void run_to(Micros until);
  /// Ends the traces of all who run; nothing may be run any more.
  void finish();
  Micros now() const { return now_; }

  int persons() const { return static_cast<int>(persons_.size()); }
  /// Runs: has started, and has neither been killed nor come to its end.
  bool runs(int person) const { return persons_[at(person)].runs; }
  bool leaving(int person) const { return persons_[at(person)].peer->leaving(); }
  /// Has got no answer from the only one it was told of, who does not run any more: nobody knows of it, nor it of
  /// anybody.
  bool knocks_in_vain(int person) const;
  /// Whether one of the two knows the other's place: as a member's, or as one where it looks for a former one.
  bool know_of_each_other(int p, int q) const;
  /// It has sent something to no address.
  bool sent_to_nowhere(int person) const { return persons_[at(person)].to_nowhere; }
  bool paused(int person) const { return persons_[at(person)].paused; }
  const node::Participant& peer(int person) const { return *persons_[at(person)].peer; }
  /// When it was first a part of the session, after its start; -1: not yet.
  Micros took(int person) const { return persons_[at(person)].took; }
  /// A person's session clock, us, and the rate of the clock that it runs on.
  Micros session_now(int person) const { return peer(person).session().session_now(local(persons_[at(person)])); }
  double rate(int person) const { return persons_[at(person)].rate; }
  std::vector<std::string> notes(int person) const { return persons_[at(person)].notes; }

  /// A tick has become final in an incarnation of a person's.
  std::function<void(int person, int incarnation, const sync::FoldState&, std::uint64_t hash)> on_confirmed;
  /// Somebody is about to start with this; it may be changed.
  std::function<void(int person, node::ParticipantConfig&)> on_start;
  /// Whatever is on its way to somebody, from a place.
  std::function<void(const Endpoint& from, int to, std::span<const std::byte> datagram)> on_datagram;
  /// Somebody who is at no person's place sends something, which arrives at once.
  void inject(const Endpoint& from, int to, std::span<const std::byte> datagram) {
    persons_[at(to)].buffer.emplace_back(from, std::vector<std::byte>(datagram.begin(), datagram.end()));
  }
  /// From now on a person's datagrams come from, and reach it at, another place.
  void move(int person, const Endpoint& place);
  /// A person has been worked on.
  std::function<void(int person)> on_turn;

  static constexpr Micros kStep = 4'000;

 private:
  struct Person {
    std::unique_ptr<node::Participant> peer;
    std::unique_ptr<scenarios::InputSource> input;
    Endpoint place;
    int host = 0;
    std::optional<int> by;  ///< whom it joined
    Micros offset = 0;
    double rate = 1;
    Micros born = 0;
    Micros took = -1;
    bool runs = true;
    bool paused = false;
    bool to_nowhere = false;
    std::deque<std::pair<Endpoint, std::vector<std::byte>>> buffer;  ///< the socket's
    std::vector<Endpoint> refused;
    std::vector<std::string> notes;
  };
  static std::size_t at(int person) { return static_cast<std::size_t>(person); }
  node::ChannelConfig channels_of(Rng& rng) const;
  Micros local(const Person& p) const;
  void deliver();
  void turn(int person);
  void end_if_done(Person& p);
  /// Who is at this place as somebody sees it.
  std::optional<int> at_place(const Person& seen_by, const Endpoint& place) const;
  /// `loopback`: over that address of a machine that both are on.
  void arrive(std::size_t sender, std::size_t receiver, bool loopback, std::vector<std::byte> datagram);

  VirtualNetworkConfig config_;
  Micros now_ = 0;
  std::vector<Person> persons_;
  std::map<Endpoint, int> by_place_;
  link::LinkMesh links_;
  link::LinkMesh loopback_links_;
  std::map<int, int> sides_;
  std::set<std::pair<int, int>> cuts_;
  std::optional<Vec2> attraction_;
};

}  // namespace padr::lab
