#include "tools/lab/crowd/command.h"

#include <fmt/printf.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <utility>

#include "common/model/user_error.h"
#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/json.h"
#include "shell/netem_flags.h"
#include "shell/revision.h"
#include "shell/run_main.h"
#include "tools/lab/crowd/census.h"

namespace padr::lab {
namespace {

constexpr int kMostPeers = 10000;
/// Ticks between two measurements of the peers' views.
constexpr Tick kLook = 6;

/// Who strolls so far from the edge of the crowd's ground, m, has neighbours all around, whatever the crowd's size.
constexpr float kInner = 12;

constexpr std::array kMeans = {
    &CrowdRow::regions_each, &CrowdRow::members,   &CrowdRow::links,        &CrowdRow::updates,
    &CrowdRow::kbps,         &CrowdRow::cpu_us,    &CrowdRow::inner_kbps,   &CrowdRow::inner_cpu_us,
    &CrowdRow::neighbours,   &CrowdRow::avatars_m, &CrowdRow::per_avatar_m, &CrowdRow::bodies_m,
    &CrowdRow::unseen,       &CrowdRow::handovers, &CrowdRow::entered,      &CrowdRow::late};
constexpr std::array kOfNear = {&CrowdRow::per_avatar_m, &CrowdRow::unseen};
constexpr std::array kSums = {&CrowdRow::failed,    &CrowdRow::bodies_over, &CrowdRow::compared,
                              &CrowdRow::different, &CrowdRow::confirmed,   &CrowdRow::split};

/// What is counted over the whole run, by so many peers together.
struct Sums {
  int peers = 0;
  double updates = 0, bytes = 0, cpu = 0, handovers = 0, entered = 0, late = 0;

  /// Of those who stroll so far from the edge, m.
  static Sums of(const CrowdRun& run, float from_edge = std::numeric_limits<float>::lowest()) {
    Sums s;
    for (int i = 0; i < run.persons(); ++i) {
      if (run.from_edge(i) < from_edge) continue;
      const crowd::CrowdStats& c = run.peer(i).stats();
      ++s.peers;
      s.cpu += run.cpu_seconds(i);
      s.updates += static_cast<double>(run.peer(i).updates());
      s.bytes += static_cast<double>(c.wire_bytes);
      s.handovers += static_cast<double>(c.handovers);
      s.entered += static_cast<double>(c.entered);
      s.late += static_cast<double>(c.late);
    }
    return s;
  }
  /// What each of them has sent since, kbit/s.
  double kbps(const Sums& before, double seconds) const { return each(bytes - before.bytes, seconds) * 8 / 1000; }
  /// What a tick of each of them has taken since, us.
  double cpu_us(const Sums& before, double seconds) const {
    return each(cpu - before.cpu, seconds) * 1e6 / kTicksPerSecond;
  }

 private:
  double each(double sum, double seconds) const { return sum / (seconds * std::max(1, peers)); }
};

/// Of crowds of one size: what is counted is added up, all else is the mean, of those near somebody over all of those.
CrowdRow mean_of(std::vector<CrowdRow> rows) {
  for (CrowdRow& r : rows)
    for (double CrowdRow::*of_near : kOfNear) r.*of_near *= r.neighbours;
  CrowdRow all = rows.front();
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const CrowdRow& r = rows[i];
    for (double CrowdRow::*mean : kMeans) all.*mean += r.*mean;
    for (std::uint64_t CrowdRow::*sum : kSums) all.*sum += r.*sum;
    all.regions += r.regions;
    all.inner += r.inner;
    all.bodies.bodies += r.bodies.bodies;
    all.bodies.lost += r.bodies.lost;
    all.bodies.doubled += r.bodies.doubled;
  }
  for (double CrowdRow::*mean : kMeans) all.*mean /= static_cast<double>(rows.size());
  if (all.neighbours > 0)
    for (double CrowdRow::*of_near : kOfNear) all.*of_near /= all.neighbours;
  all.crowds = static_cast<int>(rows.size());
  return all;
}

const char* const kHead =
    "  peers  regions  each  members  links  updates/s  kbit/s   us/tick   CPU  near  avatars m  each m  bodies m  "
    "crossings/s  late\n";

std::string line_of(const CrowdRow& r, const CrowdRow& base) {
  return fmt::sprintf("%7d %8zu %5.2f %8.1f %6.1f %10.1f %7.1f %9.1f %5.2f %5.1f %10.3f %7.3f %9.3f %12.3f %5.3f\n",
                      r.peers, r.regions, r.regions_each, r.members, r.links, r.updates, r.kbps, r.cpu_us,
                      base.cpu_us > 0 ? r.cpu_us / base.cpu_us : 0, r.neighbours, r.avatars_m, r.per_avatar_m,
                      r.bodies_m, r.handovers, r.late);
}

std::string inner_of(const CrowdRow& r) {
  return fmt::sprintf("%7d: %d of them %g m or more from the edge: %.1f kbit/s, %.1f us/tick\n", r.peers, r.inner,
                      static_cast<double>(kInner), r.inner_kbps, r.inner_cpu_us);
}

std::string footnote_of(const CrowdRow& r) {
  return fmt::sprintf(
      "%7d: %.2f%% of those near not seen, %.3f regions entered/s, %llu entries failed; of %zu bodies %llu times "
      "one handed over, %zu lost, %zu in two regions just now\n",
      r.peers, r.unseen * 100, r.entered, static_cast<unsigned long long>(r.failed), r.bodies.bodies,
      static_cast<unsigned long long>(r.bodies_over), r.bodies.lost, r.bodies.doubled);
}

std::vector<int> sizes_of(const std::string& text) {
  std::vector<int> sizes;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (bool more = true; more;) {
    int size = 0;
    const auto [next, error] = std::from_chars(at, end, size);
    more = next != end && *next == ',';
    if (error != std::errc() || size < 1 || size > kMostPeers || (next != end && !more))
      throw UserError("--peers: '" + text + "' is not allowed; give numbers from 1 to " + std::to_string(kMostPeers) +
                      " with commas between them");
    sizes.push_back(size);
    at = next + (more ? 1 : 0);
  }
  return sizes;
}

}  // namespace

void CrowdCommand::declare(CLI::App& app) {
  app.add_option("--peers", peers_text_, "Sizes of crowds, 1 to 10000 [4,50,200]")->type_name("N,N,...");
  app.add_option("--seconds", seconds_, "Virtual length of the measurement")
      ->check(shell::range(1.0, 3600.0))
      ->capture_default_str();
  app.add_option("--warm-up", warm_up_, "Virtual time between the last arrival and the measurement, s")
      ->check(shell::range(2.0, 600.0))
      ->capture_default_str();
  app.add_option("--seed", seed_, "Seed of everything random")->capture_default_str();
  app.add_option("--netem", netem_, "Impairment of every directed link")->type_name("SPEC")->capture_default_str();
  app.add_option("--arrivals", arrivals_, "Peers that join in a second, one after another")
      ->check(shell::range(1.0, 1000.0))
      ->capture_default_str();
  app.add_option("--room", room_, "Area of the plane for every peer, m^2")
      ->check(shell::range(10.0, 10000.0))
      ->capture_default_str();
  app.add_option("--near", near_, "Inconsistency counts entities up to this distance from the peer's avatar, m")
      ->check(shell::range(1.0, 16.0))
      ->capture_default_str();
  app.add_option("--side", plane_.side, "Side of a region, m")->check(shell::range(16.0, 200.0))->capture_default_str();
  app.add_option("--reach", plane_.reach, "An avatar is a guest beyond a border up to this distance, m")
      ->check(shell::range(2.0, 12.0))
      ->capture_default_str();
  app.add_flag("--uniform", uniform_, "No relevance: the same thresholds at every distance");
  app.add_option("--shoves", shoves_, "How often every avatar pushes a body near it, 1/s")
      ->check(shell::range(0.0, 10.0))
      ->capture_default_str();
  technique_.declare(app);
  app.add_option("--fill", fill_, "Repeat crowds of each size, with successive seeds, until they have N peers in all")
      ->check(shell::range(0, kMostPeers))
      ->capture_default_str();
  app.add_option("--jobs", jobs_, "Threads; the results are the same with any number")
      ->check(shell::range(1, 256))
      ->capture_default_str();
  app.add_option("--json", json_, "Results to a file, or - for standard output in place of the table")
      ->type_name("FILE|-");
  app.footer(
      "A plane without end has square regions, and each region has its own agreed world; docs/crowds.md has the\n"
      "design. Every avatar wanders in a square of 24 m and meets bodies and other avatars. Its peer is in the "
      "regions\n"
      "near it. Peers find each other by asking. If two peers found one region at once, it has several sides; each\n"
      "side agrees with itself, and later the sides merge.\n"
      "\n"
      "CPU is the thread time of a peer's tick, and its ratio to that of the first size. Peers at the edge of a crowd\n"
      "have fewer neighbours, and a small crowd has more of them. So the cost of peers 12 m or more from the edge has\n"
      "rows of its own. Crowds of all sizes play in turns in one process, so processor and caches are equally busy "
      "for\n"
      "each. 1,000 peers take 7 GB of memory. With --fill small crowds play several times; the table has the mean of\n"
      "measurements and the sum of counts. Inconsistency is the error of the entities near a peer, summed, and the\n"
      "error of one avatar.\n"
      "Example:\n"
      "  padr-lab crowd --peers 4,50,200 --seconds 20 --seed 1\n"
      "Exit: 0 all peers on one side confirmed the same worlds, 1 some differed or a file could not be written, 2 "
      "usage.");
}

CrowdRunConfig CrowdCommand::config_of(int peers, std::uint64_t seed) const {
  CrowdRunConfig c;
  c.plane = plane_;
  c.plane.seed = seed;
  c.technique = technique_.technique();
  c.relevance = !uniform_;
  c.shoves = shoves_;
  c.netem = shell::parse_netem_flag("--netem", netem_, nullptr);
  c.seed = seed;
  c.peers = peers;
  c.room = static_cast<float>(room_);
  c.arrivals = arrivals_;
  c.threads = jobs_;
  return c;
}

/// One crowd, and what is counted of it.
class CrowdCommand::Watched {
 public:
  Watched(const CrowdRunConfig& config, float near) : plane_(config.plane), run_(config), census_(near) {}

  /// By one turn, which is one tick or several.
  void advance() { run_.advance(); }
  /// That take so many seconds.
  Tick turns(double seconds) const {
    const auto ticks = static_cast<Tick>(std::lround(seconds * kTicksPerSecond));
    return (ticks + run_.stride() - 1) / run_.stride();
  }
  void begin() {
    before_ = Sums::of(run_);
    inner_before_ = Sums::of(run_, kInner);
    run_.take_links();
    second_ = run_.now() + kTicksPerSecond;
    look_ = run_.now();
  }
  void advance_and_look() {
    run_.advance();
    if (run_.now() >= look_) {
      census_.look(run_);
      look_ = run_.now() + kLook;
    }
    if (run_.now() < second_) return;
    links_ += static_cast<double>(run_.take_links());
    second_ += kTicksPerSecond;
  }
  CrowdRow row(double seconds) const;

 private:
  crowd::Plane plane_;
  CrowdRun run_;
  Census census_;
  Sums before_, inner_before_;
  double links_ = 0;
  Tick second_ = 0;
  Tick look_ = 0;
};

CrowdRow CrowdCommand::Watched::row(double seconds) const {
  const Sums after = Sums::of(run_);
  const Sums inner = Sums::of(run_, kInner);
  const double each_second = 1 / (seconds * run_.persons());
  CrowdRow r;
  r.peers = run_.persons();
  r.regions = run_.regions();
  r.regions_each = census_.regions();
  for (const auto& [region, members] : run_.members()) r.members += static_cast<double>(members.size());
  r.members /= static_cast<double>(std::max<std::size_t>(1, r.regions));
  r.links = links_ * each_second;
  r.updates = (after.updates - before_.updates) * each_second;
  r.kbps = after.kbps(before_, seconds);
  r.cpu_us = after.cpu_us(before_, seconds);
  r.inner = inner.peers;
  r.inner_kbps = inner.kbps(inner_before_, seconds);
  r.inner_cpu_us = inner.cpu_us(inner_before_, seconds);
  r.neighbours = census_.neighbours();
  r.avatars_m = census_.avatars();
  r.per_avatar_m = census_.per_avatar();
  r.bodies_m = census_.bodies();
  r.unseen = census_.unseen();
  r.handovers = (after.handovers - before_.handovers) * each_second;
  r.entered = (after.entered - before_.entered) * each_second;
  r.late = (after.late - before_.late) * each_second / kTicksPerSecond;
  for (int i = 0; i < run_.persons(); ++i) {
    r.failed += run_.peer(i).stats().failed;
    r.bodies_over += run_.peer(i).handover().entries();
  }
  r.bodies = inventory_of(run_, plane_);
  r.compared = run_.compared();
  r.different = run_.different();
  r.confirmed = run_.confirmed();
  r.split = run_.split();
  return r;
}

/// Crowds of one size.
struct CrowdCommand::Size {
  Tick before = 0;  ///< turns until it is measured
  std::vector<std::unique_ptr<Watched>> crowds;
};

CrowdCommand::Size CrowdCommand::begin(int peers) const {
  Size s;
  const int several = std::max(1, fill_ / peers);
  s.crowds.reserve(static_cast<std::size_t>(several));
  for (int i = 0; i < several; ++i)
    s.crowds.push_back(
        std::make_unique<Watched>(config_of(peers, seed_ + static_cast<std::uint64_t>(i)), static_cast<float>(near_)));
  s.before = s.crowds.front()->turns(warm_up_ + peers / arrivals_);
  return s;
}

// All sizes in turns, so that whatever else the machine does, and what of it is in the processor's caches, is the same
// for each; a smaller crowd, which is there sooner, begins later.
std::vector<CrowdRow> CrowdCommand::measure() const {
  std::vector<Size> sizes;
  sizes.reserve(peers_.size());
  for (const int peers : peers_) sizes.push_back(begin(peers));
  Tick before = 0;
  for (const Size& s : sizes) before = std::max(before, s.before);
  for (Tick turn = 0; turn < before; ++turn)
    for (const Size& s : sizes)
      for (const auto& c : s.crowds)
        if (turn >= before - s.before) c->advance();
  for (const Size& s : sizes)
    for (const auto& c : s.crowds) c->begin();
  const Tick measured = sizes.front().crowds.front()->turns(seconds_);
  for (Tick turn = 0; turn < measured; ++turn)
    for (const Size& s : sizes)
      for (const auto& c : s.crowds) c->advance_and_look();
  std::vector<CrowdRow> means;
  means.reserve(sizes.size());
  for (const Size& s : sizes) {
    std::vector<CrowdRow> rows;
    rows.reserve(s.crowds.size());
    for (const auto& c : s.crowds) rows.push_back(c->row(seconds_));
    means.push_back(mean_of(std::move(rows)));
  }
  return means;
}

std::string CrowdCommand::json(const std::vector<std::string>& command, const std::vector<CrowdRow>& rows) const {
  shell::Json j;
  j.begin_object().field("command", shell::shell_line(command)).field("revision", shell::revision());
  j.field("seed", seed_).field("seconds", seconds_).field("netem", netem_).key("crowds").begin_array();
  for (const CrowdRow& r : rows) {
    j.begin_object()
        .field("peers", r.peers)
        .field("crowds", r.crowds)
        .field("regions", r.regions)
        .field("regions_per_peer", r.regions_each);
    j.field("members_per_region", r.members).field("links_per_peer", r.links).field("updates_per_s", r.updates);
    j.field("kbit_per_s", r.kbps).field("cpu_us_per_tick", r.cpu_us).field("neighbours", r.neighbours);
    j.field("inner_peers", r.inner).field("inner_kbit_per_s", r.inner_kbps);
    j.field("inner_cpu_us_per_tick", r.inner_cpu_us);
    j.field("avatar_inconsistency_m", r.avatars_m).field("per_avatar_m", r.per_avatar_m);
    j.field("body_inconsistency_m", r.bodies_m).field("unseen", r.unseen).field("crossings_per_s", r.handovers);
    j.field("entered_per_s", r.entered).field("late", r.late).field("failed_entries", r.failed);
    j.field("bodies_handed_over", r.bodies_over).field("bodies", r.bodies.bodies);
    j.field("bodies_lost", r.bodies.lost)
        .field("bodies_in_two_regions", r.bodies.doubled)
        .field("hashes_compared", r.compared);
    j.field("hashes_different", r.different).field("region_ticks", r.confirmed);
    j.field("region_ticks_split", r.split).end_object();
  }
  j.end_array().end_object();
  return j.text();
}

int CrowdCommand::run(const std::vector<std::string>& command) {
  peers_ = sizes_of(peers_text_);
  (void)config_of(1, seed_);
  shell::check_writable("--json", json_);
  const bool table = json_ != "-";
  const std::vector<CrowdRow> rows = measure();
  std::uint64_t compared = 0;
  std::uint64_t different = 0;
  std::uint64_t confirmed = 0;
  std::uint64_t split = 0;
  for (const CrowdRow& r : rows) {
    compared += r.compared;
    different += r.different;
    confirmed += r.confirmed;
    split += r.split;
  }
  if (table) {
    std::cout << kHead;
    for (const CrowdRow& r : rows) std::cout << line_of(r, rows.front());
    for (const CrowdRow& r : rows)
      if (r.inner > 0) std::cout << inner_of(r);
    for (const CrowdRow& r : rows) std::cout << footnote_of(r);
    std::cout << compared << " confirmed hashes compared, " << different << " different\n"
              << split << " of " << confirmed << " ticks of regions confirmed on several sides\n";
  }
  if (!json_.empty()) shell::write_text("--json", json_, json(command, rows));
  return different == 0 ? shell::kExitFine : shell::kExitFailure;
}

}  // namespace padr::lab
