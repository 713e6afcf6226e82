#include "tools/lab/crowd/command.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>

#include "common/model/user_error.h"
#include "tools/lab/crowd/census.h"
#include "tools/support/command_line.h"
#include "tools/support/files.h"
#include "tools/support/json.h"
#include "tools/support/netem_flags.h"
#include "tools/support/revision.h"
#include "tools/support/run_main.h"

namespace padr::lab {
namespace {

constexpr int kMostPeers = 10000;
/// Ticks between two looks at who has what where.
constexpr Tick kLook = 6;

template <typename... Args>
std::string text(const char* format, Args... args) {
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), format, args...);
  return line.data();
}

/// What is counted over the whole run, by all peers together.
struct Sums {
  double updates = 0, bytes = 0, cpu = 0, handovers = 0, entered = 0, late = 0;

  static Sums of(const CrowdRun& run) {
    Sums s;
    s.cpu = run.cpu_seconds();
    for (int i = 0; i < run.persons(); ++i) {
      const crowd::CrowdStats& c = run.peer(i).stats();
      s.updates += static_cast<double>(run.peer(i).updates());
      s.bytes += static_cast<double>(c.wire_bytes);
      s.handovers += static_cast<double>(c.handovers);
      s.entered += static_cast<double>(c.entered);
      s.late += static_cast<double>(c.late);
    }
    return s;
  }
};

const char* const kHead =
    "  peers  regions  each  members  links  updates/s  kbit/s   us/tick   CPU  near  avatars m  each m  bodies m  "
    "crossings/s  late\n";

std::string line_of(const CrowdRow& r, const CrowdRow& base) {
  return text("%7d %8zu %5.2f %8.1f %6.1f %10.1f %7.1f %9.1f %5.2f %5.1f %10.3f %7.3f %9.3f %12.3f %5.3f\n", r.peers,
              r.regions, r.regions_each, r.members, r.links, r.updates, r.kbps, r.cpu_us,
              base.cpu_us > 0 ? r.cpu_us / base.cpu_us : 0, r.neighbours, r.avatars_m, r.per_avatar_m, r.bodies_m,
              r.handovers, r.late);
}

std::string footnote_of(const CrowdRow& r) {
  return text(
      "%7d: %.2f%% of those near not seen, %.3f regions entered/s, %llu entries failed; of %zu bodies %llu times "
      "one handed over, %zu lost, %zu in two regions just now\n",
      r.peers, r.unseen * 100, r.entered, static_cast<unsigned long long>(r.failed), r.bodies.bodies,
      static_cast<unsigned long long>(r.bodies_over), r.bodies.lost, r.bodies.doubled);
}

}  // namespace

void CrowdCommand::declare(CLI::App& app) {
  app.add_option("--peers", peers_, "Sizes of crowds, one run each")
      ->delimiter(',')
      ->check(CLI::Range(1, kMostPeers))
      ->type_name("N,N,...")
      ->capture_default_str();
  app.add_option("--seconds", seconds_, "Virtual length of what is measured")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  app.add_option("--warm-up", warm_up_, "Before that, s, besides the time that it takes all to come")
      ->check(CLI::Range(2.0, 600.0))
      ->capture_default_str();
  app.add_option("--seed", seed_, "Of everything drawn")->capture_default_str();
  app.add_option("--netem", netem_, "Every directed link")->type_name("SPEC")->capture_default_str();
  app.add_option("--arrivals", arrivals_, "Peers that come in a second, one after another")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  app.add_option("--room", room_, "m^2 of the plane for every peer")
      ->check(CLI::Range(10.0, 10000.0))
      ->capture_default_str();
  app.add_option("--near", near_, "Inconsistency counts what is so near to one's avatar, m")
      ->check(CLI::Range(1.0, 16.0))
      ->capture_default_str();
  app.add_option("--side", plane_.side, "Of a region, m")->check(CLI::Range(16.0, 200.0))->capture_default_str();
  app.add_option("--reach", plane_.reach, "Beyond a border, m, that avatars are guests")
      ->check(CLI::Range(2.0, 12.0))
      ->capture_default_str();
  app.add_flag("--uniform", uniform_, "No relevance: the same thresholds however far others are");
  app.add_option("--shoves", shoves_, "Everybody pushes a body near it so often, 1/s")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  technique_.declare(app);
  app.add_option("--jobs", jobs_, "Threads; the results are the same with any number")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  app.add_option("--json", json_, "Results to a file, or - for standard output in place of the table")
      ->type_name("FILE|-");
  app.footer(
      "A plane without end, in square regions that agree on a world each; docs/crowds.md has the design. Every peer\n"
      "strolls about a square of 24 m, runs into bodies and others, and is in the regions that it is near. Who is in\n"
      "a region they find out from one another; a region that two found at once has several sides, which agree with\n"
      "themselves, until they come together. CPU is thread time of a peer's tick, and its ratio to the first run's.\n"
      "Inconsistency is what a peer has wrong of what is near it, summed, and that of one avatar.\n"
      "Example:\n"
      "  padr-lab crowd --peers 4,50,200 --seconds 20 --seed 1\n"
      "Exit: 0 all who were on one side confirmed the same worlds, 1 some differed, 2 usage.");
}

CrowdRunConfig CrowdCommand::config_of(int peers) const {
  CrowdRunConfig c;
  c.plane = plane_;
  c.plane.seed = seed_;
  c.technique = technique_.technique();
  c.relevance = !uniform_;
  c.shoves = shoves_;
  c.netem = support::parse_netem_flag("--netem", netem_, nullptr);
  c.seed = seed_;
  c.peers = peers;
  c.room = static_cast<float>(room_);
  c.arrivals = arrivals_;
  c.threads = jobs_;
  return c;
}

CrowdRow CrowdCommand::measure(int peers) const {
  CrowdRun run(config_of(peers));
  const auto ticks = [](double s) { return static_cast<Tick>(std::lround(s * kTicksPerSecond)); };
  while (run.now() < ticks(warm_up_ + peers / arrivals_)) run.advance();
  Census census(static_cast<float>(near_));
  const Sums before = Sums::of(run);
  double links = 0;
  run.take_links();
  const Tick end = run.now() + ticks(seconds_);
  Tick second = run.now() + kTicksPerSecond;
  Tick look = run.now();
  while (run.now() < end) {
    run.advance();
    if (run.now() >= look) census.look(run);
    if (run.now() >= look) look = run.now() + kLook;
    if (run.now() < second) continue;
    links += static_cast<double>(run.take_links());
    second += kTicksPerSecond;
  }
  const Sums after = Sums::of(run);
  const double each_second = 1 / (seconds_ * peers);
  CrowdRow r;
  r.peers = peers;
  r.regions = run.regions();
  r.regions_each = census.regions();
  for (const auto& [region, members] : run.members()) r.members += static_cast<double>(members.size());
  r.members /= static_cast<double>(std::max<std::size_t>(1, r.regions));
  r.links = links * each_second;
  r.updates = (after.updates - before.updates) * each_second;
  r.kbps = (after.bytes - before.bytes) * 8 / 1000 * each_second;
  r.cpu_us = (after.cpu - before.cpu) * 1e6 * each_second / kTicksPerSecond;
  r.neighbours = census.neighbours();
  r.avatars_m = census.avatars();
  r.per_avatar_m = census.per_avatar();
  r.bodies_m = census.bodies();
  r.unseen = census.unseen();
  r.handovers = (after.handovers - before.handovers) * each_second;
  r.entered = (after.entered - before.entered) * each_second;
  r.late = (after.late - before.late) * each_second / kTicksPerSecond;
  for (int i = 0; i < run.persons(); ++i) {
    r.failed += run.peer(i).stats().failed;
    r.bodies_over += run.peer(i).customs().entries();
  }
  r.bodies = inventory_of(run, plane_);
  r.compared = run.compared();
  r.different = run.different();
  r.confirmed = run.confirmed();
  r.split = run.split();
  return r;
}

std::string CrowdCommand::json(const std::vector<std::string>& command, const std::vector<CrowdRow>& rows) const {
  support::Json j;
  j.begin_object().field("command", support::shell_line(command)).field("revision", support::revision());
  j.field("seed", seed_).field("seconds", seconds_).field("netem", netem_).key("crowds").begin_array();
  for (const CrowdRow& r : rows) {
    j.begin_object().field("peers", r.peers).field("regions", r.regions).field("regions_per_peer", r.regions_each);
    j.field("members_per_region", r.members).field("links_per_peer", r.links).field("updates_per_s", r.updates);
    j.field("kbit_per_s", r.kbps).field("cpu_us_per_tick", r.cpu_us).field("neighbours", r.neighbours);
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
  (void)config_of(1);
  std::vector<CrowdRow> rows;
  const bool table = json_ != "-";
  if (table) std::cout << kHead;
  for (const int peers : peers_) {
    rows.push_back(measure(peers));
    if (table) std::cout << line_of(rows.back(), rows.front()) << std::flush;
  }
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
    for (const CrowdRow& r : rows) std::cout << footnote_of(r);
    std::cout << compared << " confirmed hashes compared, " << different << " different\n"
              << split << " of " << confirmed << " ticks of regions confirmed on several sides\n";
  }
  if (json_ == "-") std::cout << json(command, rows);
  if (!json_.empty() && json_ != "-") {
    support::OutputFile file("--json", json_);
    file.write(json(command, rows));
    file.close();
  }
  return different == 0 ? support::kExitFine : support::kExitFailure;
}

}  // namespace padr::lab
