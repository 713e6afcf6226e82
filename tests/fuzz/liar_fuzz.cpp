// A session with a key, one of whose members says what a script says: any message that a member may send, with any
// values, sealed and signed with its own keys, to some or to all. It never is the coordinator while all are there.
//
// Then it is honest for a while. By then the others, who were honest all the time, must be members to each other and
// confirm the same worlds, and none of them may have cut another off.
//
// An entry of a script is a step. With LIAR_FUZZ_STEPS=1 in the environment a run says at its end how many it made.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/scenarios/bodies.h"
#include "common/scenarios/scenarios.h"
#include "shell/session_words.h"
#include "tests/fuzz/good.h"
#include "tests/fuzz/liar_script.h"
#include "tests/fuzz/small_net.h"

namespace {

using namespace padr;
using test::LieEntry;
using test::SmallNet;

constexpr int kHonest = 3;  // persons 0, 1 and 2; the next one lies
constexpr int kLiar = kHonest;
constexpr int kSlots = 6;
constexpr std::size_t kHead = 2;  // how they seal; the way that the avatars go
constexpr std::size_t kMostEntries = 1000;
constexpr std::array kTurns{0, 0, 0, 0, 1, 1, 2, 3};  // until the next entry
constexpr int kPatience = 40;                         // turns, after which what could not be told is not told
constexpr int kWarmUp = 30;                           // turns before the first lie
constexpr int kQuiet = 20 * 60;                       // turns after the last one, at most
constexpr int kLeastQuiet = 4 * 60;                   // whoever is to be missed is missed by then
constexpr Tick kMostLag = 60;

/// Steps of all inputs.
struct Steps {
  std::uint64_t made = 0;
  std::uint64_t by_member = 0;  ///< while an honest peer had the liar as a member
  ~Steps() {
    if (std::getenv("LIAR_FUZZ_STEPS") != nullptr)
      std::printf("%llu steps, %llu of them by a member\n", static_cast<unsigned long long>(made),
                  static_cast<unsigned long long>(by_member));
  }
};
Steps steps;

/// The entries that are still to be told, and to whom.
class LyingMember {
 public:
  explicit LyingMember(SmallNet& net) : net_(net), key_(net.signing_key(kLiar)) {
    net.tamper = [this](int from, node::Parcel p) {
      return from == kLiar ? tamper(std::move(p)) : std::vector{std::move(p)};
    };
  }
  void say(const LieEntry& e) { waiting_.push_back({e, kPatience}); }
  void turn() {
    std::erase_if(waiting_, [](Waiting& w) { return --w.turns < 0 || w.entry.to == 0; });
  }
  void stop() { waiting_.clear(); }

 private:
  struct Waiting {
    LieEntry entry;
    int turns;
  };
  std::vector<node::Parcel> tamper(node::Parcel parcel) {
    std::vector<node::Parcel> out;
    wire::SealError error{};
    const auto opened = wire::open(parcel.bytes, error);
    if (waiting_.empty() || !opened || opened->header.kind != wire::Kind::kState) {
      out.push_back(std::move(parcel));
      return out;
    }
    const test::LiarsKnowledge knowledge{net_.peer(kLiar).replica(), key_};
    auto packet = wire::decode_state(opened->payload, opened->header.sender);
    const auto bit = static_cast<std::uint8_t>(1U << (parcel.state_to % 8U));
    for (Waiting& w : waiting_) {
      if ((w.entry.to & bit) == 0 || !packet) continue;
      w.entry.to &= static_cast<std::uint8_t>(~bit);
      if (test::is_of_state(w.entry))
        test::lie(*packet, w.entry, knowledge);
      else if (auto said = test::lie(w.entry, knowledge))
        out.push_back({parcel.to, parcel.state_to, std::move(*said)});
    }
    const wire::Bytes payload = packet ? wire::encode(*packet) : wire::Bytes{};
    if (packet && payload.size() <= wire::kMaxPayload) parcel.bytes = wire::seal(opened->header, payload);
    out.push_back(std::move(parcel));
    return out;
  }

  SmallNet& net_;
  wire::SigningKey key_;
  std::vector<Waiting> waiting_;
};

bool know_each_other(const SmallNet& net, int a, int b) {
  const node::Replica& n = net.peer(a).replica();
  const node::Replica& m = net.peer(b).replica();
  return n.self() != m.self() && n.seat(m.self()).there() && n.seat(m.self()).incarnation == m.config().incarnation;
}

bool is_member(const SmallNet& net, int person) {
  for (int p = 0; p < kHonest; ++p)
    if (net.peer(p).playing() && net.peer(person).playing() && know_each_other(net, p, person)) return true;
  return false;
}

bool confirm_the_same(const node::Replica& n, const node::Replica& m) {
  const Tick both = std::min(n.agreed().confirmed().tick, m.agreed().confirmed().tick);
  const sync::FoldState* ours = n.agreed().confirmed_at(both);
  const sync::FoldState* theirs = m.agreed().confirmed_at(both);
  return ours != nullptr && theirs != nullptr && sync::hash_of(*ours) == sync::hash_of(*theirs);
}

/// What is wrong among the honest; null if nothing is.
const char* complaint(const SmallNet& net) {
  for (int p = 0; p < kHonest; ++p)
    if (!net.peer(p).playing() || net.peer(p).returning()) return "one is out";
  for (int p = 0; p < kHonest; ++p) {
    const node::Replica& n = net.peer(p).replica();
    if (n.now() - n.agreed().confirmed().tick > kMostLag) return "one does not confirm";
    for (int q = 0; q < kHonest; ++q) {
      if (q == p) continue;
      if (!know_each_other(net, p, q)) return "two are not members to each other";
      if (!confirm_the_same(n, net.peer(q).replica())) return "two confirm different worlds";
    }
  }
  return nullptr;
}

/// What happened, by turn, for people.
using Story = std::vector<std::string>;

[[noreturn]] void fail(const std::string& what, const Story& story) {
  for (const std::string& line : story) std::fprintf(stderr, "%s\n", line.c_str());
  std::fprintf(stderr, "VIOLATED: %s\n", what.c_str());
  std::abort();
}

void check_bans(const SmallNet& net, const Story& story) {
  for (int p = 0; p < kHonest; ++p) {
    if (!net.peer(p).playing()) continue;
    const node::Replica& n = net.peer(p).replica();
    for (int q = 0; q < kHonest; ++q)
      if (q != p && net.peer(q).playing() && know_each_other(net, p, q) &&
          n.link(net.peer(q).replica().self()).cut_offs > 0)
        fail("person " + std::to_string(p) + " has cut off person " + std::to_string(q) + ", and both are honest",
             story);
  }
}

void play(const std::vector<LieEntry>& script, wire::SealMode mode, std::uint8_t way) {
  static const Scene kScene =
      scenarios::load(scenarios::with_bodies(scenarios::embedded_text("arena"), "arena", 6), "arena", 1);
  SmallNet net(kHonest + 1, 7, mode, kScene, kSlots);
  LyingMember liar(net);
  if (!net.come_together()) std::abort();
  int turns = 0;
  net.target = [&turns, way](int p) {
    const int phase = (turns / 20 + p * 7 + way) % 16;
    return Vec2{3.0F + static_cast<float>(phase), 4.0F + static_cast<float>((phase * 5 + way) % 8)};
  };
  Story story;
  net.on_event = [&](int p, const node::SessionEvent& e) {
    story.push_back("turn " + std::to_string(turns) + ", person " + std::to_string(p) + ": " + shell::words_of(e));
  };
  const auto turn = [&] {
    net.turn();
    liar.turn();
    ++turns;
    check_bans(net, story);
  };
  for (int i = 0; i < kWarmUp; ++i) turn();
  for (const LieEntry& e : script) {
    liar.say(e);
    ++steps.made;
    if (is_member(net, kLiar)) ++steps.by_member;
    for (int i = kTurns[e.turns % kTurns.size()]; i > 0; --i) turn();
  }
  liar.stop();
  for (int i = 0; i < kLeastQuiet || (complaint(net) != nullptr && i < kQuiet); ++i) turn();
  if (const char* what = complaint(net)) fail(what, story);
}

}  // namespace

// Each script leaves out about half of what can be said (swarm testing: Groce et al., ISSTA 2012): among entries of all
// kinds there soon is one for which the liar is thrown out, and what it says afterwards says nothing.
padr::wire::Bytes padr::test::good_input(Rng& rng) {
  std::vector<std::uint8_t> kinds;
  for (std::uint8_t k = 0; k < LieEntry::kKinds; ++k)
    if (rng.chance(0.5)) kinds.push_back(k);
  if (kinds.empty()) kinds.push_back(0);
  wire::Bytes all;
  const std::size_t size = kHead + LieEntry::kBytes * (1 + rng.below(rng.chance(0.7) ? kMostEntries : 20));
  while (all.size() < size) {
    const bool is_what = all.size() >= kHead && (all.size() - kHead) % LieEntry::kBytes == 0;
    const auto any = static_cast<std::uint8_t>(rng.below(256));
    all.push_back(static_cast<std::byte>(is_what ? kinds[any % kinds.size()] : any));
  }
  return all;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < kHead + LieEntry::kBytes) return 0;
  const auto mode = data[0] % 2 == 0 ? wire::SealMode::kAuth : wire::SealMode::kEncrypt;
  play(test::lie_script({data + kHead, size - kHead}, kMostEntries), mode, data[1]);
  return 0;
}
