// Who is in which region, found out from what peers tell one another: a few finders on a network that loses what a test
// says, without worlds.
#include "common/crowd/finder.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>

#include "tests/seed.h"

namespace padr::crowd {
namespace {

constexpr Micros kDelay = 40'000;
constexpr Micros kStep = 10'000;

Endpoint at_port(int n) {
  return ipv4({10, 0, 0, 1}, static_cast<std::uint16_t>(7000 + n));
}

/// A peer that is in what it finds or founds as soon as it has.
struct Peer {
  std::unique_ptr<Finder> finder;
  std::vector<Region> sought;
  Standing standing;
  std::map<Region, std::optional<Endpoint>> found;  ///< by whom
  bool ended = false;
};

class Net {
 public:
  explicit Net(int peers) {
    for (int i = 0; i < peers; ++i) {
      Finder::Config c;
      if (i > 0) c.contact = at_port(0);
      c.seed = derive_seed(test::seed(), 7, static_cast<std::uint64_t>(i));
      add(c);
    }
  }
  Peer& add(const Finder::Config& c) {
    peers_.push_back(std::make_unique<Peer>());
    peers_.back()->finder = std::make_unique<Finder>(c);
    return *peers_.back();
  }
  Peer& operator[](int i) { return *peers_[static_cast<std::size_t>(i)]; }
  Micros now() const { return now_; }
  double loss = 0;

  void run(double seconds) {
    for (const Micros end = now_ + static_cast<Micros>(seconds * kMicrosPerSecond); now_ < end; now_ += kStep) step();
  }
  int founders_of(Region r) const {
    int n = 0;
    for (const auto& p : peers_) n += p->found.contains(r) && !p->found.at(r);
    return n;
  }

 private:
  void step() {
    for (auto it = way_.begin(); it != way_.end() && it->first <= now_; it = way_.erase(it)) {
      const auto& [from, to, bytes] = it->second;
      if (!peers_[to]->ended) peers_[to]->finder->receive(at_port(static_cast<int>(from)), bytes, now_);
    }
    for (std::size_t i = 0; i < peers_.size(); ++i) turn(i);
  }
  void turn(std::size_t i) {
    Peer& p = *peers_[i];
    if (p.ended) return;
    p.standing.clock = p.standing.in.empty() ? 0 : now_ + 1;
    p.finder->advance(p.standing, p.sought, now_);
    for (const Finder::Finding& f : p.finder->take_findings()) {
      p.found[f.region] = f.member;
      p.standing.in.push_back(f.region);
      std::erase(p.sought, f.region);
    }
    for (node::Parcel& d : p.finder->take_outgoing()) {
      const std::size_t to = static_cast<std::size_t>(d.to.port) - 7000;
      if (to < peers_.size() && !rng_.chance(loss)) way_.emplace(now_ + kDelay, std::tuple(i, to, std::move(d.bytes)));
    }
  }

  std::vector<std::unique_ptr<Peer>> peers_;
  std::multimap<Micros, std::tuple<std::size_t, std::size_t, wire::Bytes>> way_;
  Rng rng_{test::seed()};
  Micros now_ = kMicrosPerSecond;
};

TEST(Finder, TheFirstOfACrowdFoundsAtOnceAndTheNextFindsIt) {
  Net net(2);
  net[0].sought = {{0, 0}};
  net.run(0.1);
  ASSERT_TRUE(net[0].found.contains({0, 0}));
  EXPECT_FALSE(net[0].found.at({0, 0}));
  net[1].sought = {{0, 0}};
  net.run(0.3);
  ASSERT_TRUE(net[1].found.contains({0, 0}));
  EXPECT_EQ(net[1].found.at({0, 0}), at_port(0));
  ASSERT_TRUE(net[1].finder->clock(net.now()));
  EXPECT_NEAR(static_cast<double>(*net[1].finder->clock(net.now()) - net.now()), 0, 30'000) << "the crowd's clock";
}

TEST(Finder, WhoIsToJoinItselfIsToldSoAtOnce) {
  Net net(2);
  Finder::Config c;
  c.contact = at_port(2);
  c.seed = 5;
  net.add(c).sought = {{0, 0}};
  net.run(0.3);
  EXPECT_EQ(net[2].finder->failure(), "the peer to join, " + to_string(at_port(2)) + ", is this peer itself");
}

TEST(Finder, OfAllWhoLookForARegionAtOnceOneFoundsIt) {
  for (const double loss : {0.0, 0.1, 0.3}) {
    Net net(12);
    net.loss = loss;
    net[0].sought = {{0, 0}};
    net.run(0.1);
    for (int i = 1; i < 12; ++i) net[i].sought = {{3, 3}};
    net.run(20);
    EXPECT_EQ(net.founders_of({3, 3}), 1) << "at " << loss;
    for (int i = 1; i < 12; ++i) EXPECT_TRUE(net[i].found.contains({3, 3})) << i << " at " << loss;
  }
}

// Once, what others said of somebody who had spoken for itself lately was not believed: two who had just met, and then
// looked for one region, both founded it, though all around had told each of them that the other one was looking.
TEST(Finder, WhatOthersSayOfSomebodyIsNewerThanWhatItSaidBefore) {
  for (const double met_before : {0.3, 1.0, 2.0, 5.0})
    for (const double apart : {0.0, 0.2}) {
      Net net(7);
      for (int i = 0; i < 5; ++i) net[i].sought = {{i < 3 ? 4 : 5, i < 3 ? 4 + i : 2 * i - 2}};  // next to 5,5
      net.run(8);
      for (const int i : {5, 6}) net[i].sought = {{9, 9}};
      net.run(met_before);
      for (const int i : {5, 6}) {
        net[i].standing.in.clear();
        net[i].sought = {{5, 5}};
        net.run(apart);
      }
      net.run(8);
      EXPECT_EQ(net.founders_of({5, 5}), 1) << met_before << " s after they have met, " << apart << " s apart";
    }
}

TEST(Finder, WhoWalksFarFindsWhoIsThereThoughNobodyOnTheWayKnowsIt) {
  Net net(8);
  net.loss = 0.05;
  for (int i = 0; i < 8; ++i) net[i].standing.home = {4 * i, i % 3};
  for (int i = 0; i < 8; ++i) net[i].sought = {net[i].standing.home};
  net.run(20);
  net[0].standing.home = {27, 1};  // next to the last one's
  net[0].sought = {{28, 1}};
  net.run(5);
  ASSERT_TRUE(net[0].found.contains({28, 1}));
  EXPECT_EQ(net[0].found.at({28, 1}), at_port(7));
}

TEST(Finder, WhoHasEndedIsForgotten) {
  Net net(3);
  net[0].sought = {{0, 0}};
  net.run(0.2);
  net[1].sought = {{1, 0}};
  net.run(3);
  net[1].ended = true;
  net.run(1);
  net[2].sought = {{1, 0}};
  net.run(40);
  ASSERT_TRUE(net[2].found.contains({1, 0}));
  EXPECT_FALSE(net[2].found.at({1, 0})) << "nobody is there any more";
}

// Once, whoever had lost four answers of another one in a row overlooked that one, and founded the region that it was
// in.
TEST(Finder, WhoHasEverAnsweredIsNotGivenUpForFourLostAnswers) {
  AddressBook book;
  const auto ask = [&book](const Endpoint& at, int times) {
    for (int i = 0; i < times; ++i) {
      Acquaintance* a = book.note(at);
      a->asked = (i + 1) * 600'000;
      if (a->unanswered++ == 0) a->asked_first = a->asked;
    }
    return AddressBook::ended(*book.find(at));
  };
  EXPECT_FALSE(ask(at_port(1), 3));
  EXPECT_TRUE(ask(at_port(2), 4)) << "a hint that nobody stands for";
  book.note(at_port(3))->heard = 0;
  EXPECT_FALSE(ask(at_port(3), 7));
  book.note(at_port(4))->heard = 0;
  EXPECT_TRUE(ask(at_port(4), 8));
}

TEST(Finder, AllNextToARegionAreNearestToIt) {
  AddressBook book;
  const Region r{0, 0};
  for (int i = 0; i < 60; ++i) book.note(at_port(i))->in = {{i % 3 - 1, i < 30 ? 1 : -1}};
  for (int i = 60; i < 70; ++i) book.note(at_port(i))->in = {{5, i}};
  EXPECT_EQ(book.nearest(r, 4).size(), AddressBook::kMostAround);
  EXPECT_EQ(book.nearest({5, 64}, 1).size(), 3U) << "itself and both beside it";
  EXPECT_EQ(book.nearest({20, 20}, 4).size(), 4U) << "where nobody is near";
  book.note(at_port(7))->seeks = {r};
  for (const Acquaintance* a : book.nearest(r, 4)) EXPECT_NE(a->at, at_port(7)) << "who looks for it is not in it";
}

TEST(Finder, TwoSidesOfARegionAreStrangersAfterAWhile) {
  Net net(2);
  net[0].sought = {{0, 0}};
  net.run(0.2);
  net[1].standing.in = {{0, 0}};  // it has founded it, too
  net[1].sought = {{0, 1}};
  net.run(2);
  EXPECT_TRUE(net[0].finder->strangers(net.now()).empty());
  net.run(8);
  const auto strangers = net[0].finder->strangers(net.now());
  ASSERT_EQ(strangers.size(), 1U);
  EXPECT_EQ(strangers[0], std::pair(Region{}, at_port(1)));
  net[0].standing.fellows = {{at_port(1), {0, 0}}};
  net[1].standing.fellows = {{at_port(0), {0, 0}}};
  net.run(0.2);
  EXPECT_TRUE(net[0].finder->strangers(net.now()).empty()) << "it is a member now";
}

TEST(Finder, AnotherCrowdIsToldOf) {
  Net net(1);
  net[0].sought = {{0, 0}};
  Finder::Config c;
  c.plane.seed = 2;
  c.contact = at_port(0);
  Peer& other = net.add(c);
  other.sought = {{0, 0}};
  net.run(2);
  EXPECT_TRUE(other.found.empty());
  EXPECT_NE(other.finder->failure().find("another crowd"), std::string::npos);
  EXPECT_EQ(net[0].finder->acquaintances(), 0U);
}

/// What it sends to whoever has said this.
std::vector<wire::Bytes> answers_to(Finder& finder, const wire::SessionMessage& message) {
  finder.receive(at_port(9), wire::seal({wire::Kind::kSession, kNoPeer, 0}, wire::encode_session(message)), 1);
  std::vector<wire::Bytes> all;
  for (node::Parcel& p : finder.take_outgoing()) all.push_back(std::move(p.bytes));
  return all;
}

TEST(Finder, NoAnswerIsLargerThanWhatProvokedItHoweverManyAreKnown) {
  Finder finder({Plane{}, std::nullopt, 1});
  Standing standing;
  for (int i = 0; i < 8; ++i) standing.in.push_back({i, 0});
  for (int n = 20; n < 60; ++n)
    for (const Region r : standing.in) standing.fellows.emplace_back(at_port(n), r);
  finder.advance(standing, {}, 0);
  const wire::Ask ask{5, plane_hash(Plane{}), id_of({0, 0}), {}, 1};
  const std::size_t asked = wire::seal({wire::Kind::kSession, kNoPeer, 0}, wire::encode_session(ask)).size();
  const std::vector<wire::Bytes> out = answers_to(finder, ask);
  ASSERT_EQ(out.size(), 2U) << "a Tell, and an Ask back";
  for (const wire::Bytes& bytes : out) EXPECT_LE(bytes.size(), asked);
}

TEST(Finder, WhatNobodyAskedForIsNotBelieved) {
  Finder finder({Plane{}, std::nullopt, 1});
  finder.advance({}, {}, 0);
  wire::Tell tell{5, plane_hash(Plane{}), id_of({0, 0}), {{id_of({0, 0})}, {}}, 1};
  tell.known.push_back({at_port(30), {{id_of({0, 0})}, {}}});
  EXPECT_TRUE(answers_to(finder, tell).empty());
  EXPECT_EQ(finder.acquaintances(), 0U);
  EXPECT_EQ(finder.stats().strange, 1U);
}

TEST(Finder, TheBookIsBoundedWhateverOthersSay) {
  Finder finder({Plane{}, std::nullopt, 1});
  for (int n = 0; n < 2000; ++n) {
    const wire::Ask ask{5, plane_hash(Plane{}), id_of({n, 0}), {{id_of({n, 0})}, {}}, 1};
    finder.receive(at_port(n), wire::seal({wire::Kind::kSession, kNoPeer, 0}, wire::encode_session(ask)), n * 10'000);
    finder.take_outgoing();
  }
  EXPECT_LE(finder.acquaintances(), AddressBook::kMost);
}

// Somebody who answers every question with new names, of which each is said to be in the region sought.
TEST(Finder, WhatIsKeptForASearchIsBoundedWhateverOthersSay) {
  Finder finder({Plane{}, at_port(0), 1});
  int names = 0;
  for (Micros local = kMicrosPerSecond; local < 300 * kMicrosPerSecond; local += 50'000) {
    finder.advance({}, {{3, 3}}, local);
    for (const node::Parcel& p : finder.take_outgoing()) {
      wire::SealError error{};
      const auto opened = wire::open(p.bytes, error);
      const auto message = wire::decode_session(opened->payload);
      const auto* ask = std::get_if<wire::Ask>(&*message);
      ASSERT_NE(ask, nullptr);
      wire::Tell tell{ask->nonce, ask->crowd, ask->about, {{}, {id_of({3, 3})}}, 0};
      for (int i = 0; i < 8; ++i, ++names)
        tell.known.push_back({ipv4({10, 1, static_cast<std::uint8_t>(names >> 8), static_cast<std::uint8_t>(names)}, 9),
                              {{id_of({3, 3})}, {}}});
      tell.noted = true;
      finder.receive(p.to, wire::seal({wire::Kind::kSession, kNoPeer, 0}, wire::encode_session(tell)), local + 10'000);
    }
  }
  EXPECT_GT(names, 2000);
  EXPECT_LE(finder.sayings(), 3 * AddressBook::kMost);
}

}  // namespace
}  // namespace padr::crowd
