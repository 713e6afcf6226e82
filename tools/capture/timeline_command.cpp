#include <algorithm>
#include <cstdio>
#include <optional>

#include "common/model/user_error.h"
#include "shell/files.h"
#include "tools/capture/commands.h"
#include "tools/capture/setting.h"
#include "tools/capture/timeline.h"

namespace padr::capture {
namespace {

struct TimelineOptions {
  std::vector<std::string> files;
  std::vector<std::string> keylogs;
  std::optional<int> session;
  std::string csv, svg, json;
};

/// The session's events, with the Joins that nobody has answered if there is no other session.
std::pair<std::uint16_t, std::vector<Event>> choose(const std::map<std::uint16_t, std::vector<Event>>& all,
                                                    std::optional<int> session) {
  auto found = all.end();
  for (auto it = all.begin(); it != all.end(); ++it) {
    if (it->first == 0) continue;
    if (session ? *session == it->first : found == all.end() || it->second.size() > found->second.size()) found = it;
  }
  if (found == all.end()) {
    std::string numbers;
    for (const auto& [number, events] : all)
      if (number != 0) numbers += (numbers.empty() ? "" : ", ") + std::to_string(number);
    if (session && !numbers.empty())
      throw UserError("--session: " + std::to_string(*session) + " is not in the capture; it has " + numbers);
    throw UserError("CAPTURE: it has no events of a session of PADR");
  }
  std::vector<Event> events = found->second;
  if (const auto joins = all.find(0); joins != all.end() && all.size() == 2)
    events.insert(events.begin(), joins->second.begin(), joins->second.end());
  std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.time_ns < b.time_ns; });
  return {found->first, std::move(events)};
}

int run_timeline(const TimelineOptions& o) {
  Captures captures(o.files, o.keylogs);
  Timeline timeline;
  while (const Datagram* d = captures.next()) timeline.take(*d);
  const int read = warn_unread(captures);
  const auto all = timeline.events();
  const auto [session, events] = choose(all, o.session);
  const auto in_sessions = all.size() - (all.contains(0) ? 1U : 0U);
  if (!o.session && in_sessions > 1)
    std::fprintf(stderr,
                 "padr-capture: timeline: of %zu sessions in the capture this is %d (--session N for another)\n",
                 in_sessions, int{session});
  if (!o.svg.empty()) shell::write_text("--svg", o.svg, timeline_svg(session, events));
  if (!o.json.empty()) shell::write_text("--json", o.json, timeline_json(session, events));
  if (!o.csv.empty()) shell::write_text("--csv", o.csv, timeline_csv(events));
  if (o.csv.empty() && o.svg.empty() && o.json.empty()) shell::write_text("", "-", timeline_csv(events));
  return read;
}

}  // namespace

Run declare_timeline(CLI::App& app) {
  const auto o = std::make_shared<TimelineOptions>();
  declare_captures(app, o->files, o->keylogs);
  app.footer(
      "Events:\n" + std::string(kEventsHelp) +
      "\n\nThe time of an event is that of the capture. Its tick is the tick of the update. Without --csv, --svg "
      "and --json\nthe CSV goes to standard output.\n\nExample:\n"
      "  padr-capture timeline peer0.pcapng --csv events.csv --svg events.svg");
  app.add_option("--session", o->session, "Number of the session; default: the one with most events")
      ->type_name("N")
      ->transform(session_number());
  app.add_option("--csv", o->csv, "Write one row for each event; - is standard output")->type_name("FILE|-");
  app.add_option("--svg", o->svg, "Draw the peers and the owners of bodies; - is standard output")->type_name("FILE|-");
  app.add_option("--json", o->json, "Write the events as JSON; - is standard output")->type_name("FILE|-");
  return [o](const std::vector<std::string>&) { return run_timeline(*o); };
}

}  // namespace padr::capture
