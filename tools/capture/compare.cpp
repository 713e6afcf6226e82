#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>

#include "common/model/user_error.h"
#include "common/scenarios/scenarios.h"
#include "shell/files.h"
#include "shell/json.h"
#include "shell/run_main.h"
#include "shell/text.h"
#include "tools/capture/commands.h"
#include "tools/capture/comparison.h"
#include "tools/capture/names.h"
#include "tools/capture/rebuild.h"
#include "tools/capture/setting.h"
#include "tools/capture/world_check.h"

namespace padr::capture {
namespace {

constexpr const char* kCompareFooter =
    "Give traces of padr-peer --trace, of one or all peers of a session. The program looks for each state datagram of\n"
    "a trace in the capture, and for each of the capture in the traces. A datagram that was sent and is not in the\n"
    "capture was lost before the capture (by --netem, or on the network). A datagram that is in the capture and was\n"
    "not received was lost behind it, or its receiver was not running. The program also rebuilds the confirmed world\n"
    "from the capture, and compares it with the world of the traces at every tick. A trace that breaks off, as of a\n"
    "peer that crashed, is used as far as it goes; an empty one, of a peer that has not got into the session, is left "
    "out.\n"
    "\n"
    "Example:\n"
    "  padr-capture compare lo.pcap out/demo/peer*.trace\n"
    "\n"
    "Exit code: 0 if capture and traces agree, except for lost datagrams; 1 if they do not agree, if the worlds could\n"
    "not be compared, or if a capture is damaged or breaks off; 2 for a wrong command line.";

struct CompareOptions {
  std::vector<std::string> files;
  std::vector<std::string> keylogs;
  std::string json;
  bool losses = false;
};

bool is_trace(const std::string& file) {
  std::array<char, trace::kMagic.size()> head{};
  std::ifstream in(file, std::ios::binary);
  in.read(head.data(), head.size());
  return in && std::string_view(head.data(), head.size()) == trace::kMagic;
}

/// A trace has it all, the scenario's text too.
Setting setting_of(const std::vector<TraceStory>& traces) {
  const trace::Header& h = traces.front().header;
  Setting s;
  s.scene =
      scenarios::load(h.scenario_text, traces.front().label + " (its scenario " + h.scenario + ")", h.scenario_seed);
  s.slots = h.slots;
  s.authority = h.technique.authority;
  for (const TraceStory& t : traces)
    if (t.header.incarnation == 0) {
      s.peers = t.header.peers;
      s.wanted = std::max(t.header.peers, t.header.wanted);
    }
  return s;
}

struct WorldChecks {
  std::vector<WorldCheck> traces;
  std::string not_compared;  ///< why nothing could be compared beyond what all begin with; empty if something was
};

const SessionLog& ledger_of(const Bookkeeper& books, std::uint16_t session) {
  const auto found = books.session_logs().find(session);
  if (found != books.session_logs().end() && found->second.states > 0) return found->second;
  const std::string all = books.sessions();
  throw UserError("compare: the traces are of session " + std::to_string(session) + ", and the capture has " +
                  (all.empty() ? "no state datagrams of PADR" : "others: " + all));
}

WorldChecks compare_worlds(const Bookkeeper& books, const Contents& contents, const std::vector<TraceStory>& traces) {
  const SessionLog& session_log = ledger_of(books, traces.front().header.session);
  WorldChecks out;
  out.not_compared = nothing_to_begin_with(session_log, contents);
  Setting setting = setting_of(traces);
  if (setting.wanted == 0) setting.wanted = session_log.wanted;
  Tick until = 0;
  for (const TraceStory& t : traces)
    if (!t.confirmed.empty()) until = std::max(until, t.confirmed.rbegin()->first);
  RebuiltWorlds rebuilt;
  const Rebuilt r = rebuild(session_log, setting, until, [&](const sync::FoldState& s, std::uint64_t hash) {
    RebuiltWorld& w = rebuilt[s.tick] = {hash, {}};
    for (const TraceStory& t : traces) {
      if (t.header.peer >= s.members.size()) continue;
      const sync::Member& m = s.members[t.header.peer];
      if (t.superseded && m.present && m.incarnation == t.header.incarnation) w.given_up.push_back(t.who());
    }
  });
  out.traces = check_worlds(rebuilt, traces);
  const bool beyond_begin =
      std::any_of(out.traces.begin(), out.traces.end(), [](const WorldCheck& c) { return c.last > 0; });
  if (!beyond_begin && out.not_compared.empty())
    out.not_compared = until == 0            ? "the traces have confirmed nothing beyond tick 0"
                       : r.stretches.empty() ? "the capture has neither the session's start nor a whole transfer"
                       : !r.got_anywhere()   ? "nothing beyond the beginning could be rebuilt: " + r.stretches[0].why
                                             : "no tick is both in what was rebuilt and in what the traces confirmed";
  return out;
}

std::string named(const std::vector<Passage>& list, std::size_t most) {
  std::string out;
  for (std::size_t i = 0; i < std::min(list.size(), most); ++i)
    out += (out.empty() ? "" : ", ") + std::to_string(list[i].seq) + " (tick " + std::to_string(list[i].tick) + ")";
  if (list.size() > most) out += ", ... (" + std::to_string(list.size()) + " in all; --losses names them)";
  return out;
}

Names names_in(const std::vector<LinkStory>& links) {
  Names all;
  for (const LinkStory& l : links) {
    all.add(l.from);
    all.add(l.to);
  }
  return all;
}

std::string links_text(const std::vector<LinkStory>& links, bool all) {
  shell::Table table(
      {"link", "sent", "captured", "received", "lost before", "lost behind", "duplicates", "outside", "contradict"});
  std::string names;
  std::string unseen;
  const auto count = [](std::uint64_t n, bool known) { return known ? std::to_string(n) : std::string("-"); };
  const Names names_of = names_in(links);
  for (const LinkStory& l : links) {
    const std::string link = names_of(l.from) + " -> " + names_of(l.to);
    if (l.captured == 0) {
      unseen += (unseen.empty() ? "" : ", ") + link;
      continue;
    }
    table.row({link, count(l.sent, l.sender_told), std::to_string(l.captured), count(l.received, l.receiver_told),
               count(l.lost_before.size(), l.sender_told && l.cut == 0),
               count(l.lost_after.size(), l.receiver_told && l.cut == 0), count(l.duplicates, l.cut == 0),
               count(l.outside, l.cut == 0), count(l.contradictions.size(), l.cut == 0)});
    if (l.cut > 0)
      names += link + " not judged: the capture has cut off " + std::to_string(l.cut) + " of its datagrams\n";
    const std::size_t most = all ? l.captured + l.sent + 1 : 8;
    const auto say = [&](const std::string& what, const std::vector<Passage>& list) {
      if (!list.empty()) names += link + " " + what + ": " + named(list, most) + "\n";
    };
    say("lost before the capture", l.lost_before);
    say("lost behind it", l.lost_after);
    say("not judged, after a trace breaks off", l.after_trace);
    say("CONTRADICTION", l.contradictions);
  }
  std::string out = table.text() + names;
  if (!unseen.empty()) out += "not seen by the capture: " + unseen + "\n";
  return out;
}

std::string worlds_text(const WorldChecks& checks) {
  if (!checks.not_compared.empty()) return "confirmed worlds: not compared: " + checks.not_compared + "\n";
  std::string out = "confirmed worlds, rebuilt from the capture:\n";
  for (const WorldCheck& c : checks.traces) {
    out += "  " + c.label + ": ";
    if (c.superseded) out += "given up for another incarnation, ";
    out += std::to_string(c.alike) + " of " + std::to_string(c.compared) + " ticks are the same";
    if (c.beyond > 0) out += ", " + std::to_string(c.beyond) + " could not be rebuilt";
    if (c.given_up > 0) out += ", " + std::to_string(c.given_up) + " are in the capture as another peer gave them up";
    if (c.first_difference >= 0) out += ", the first that differs is tick " + std::to_string(c.first_difference);
    out += '\n';
  }
  return out;
}

void put(shell::Json& j, const char* name, const std::vector<Passage>& list) {
  j.key(name).begin_array();
  for (const Passage& p : list) j.begin_object().field("seq", p.seq).field("tick", p.tick).end_object();
  j.end_array();
}

std::string as_json(const Comparison& c, const std::vector<LinkStory>& links, const WorldChecks& worlds, bool agree) {
  shell::Json j;
  j.begin_object().field("agree", agree).field("not_compared", worlds.not_compared);
  j.field("damaged_captured", c.damaged());
  j.field("damaged_received", c.damaged_received()).field("cut_captured", c.cut()).key("links").begin_array();
  const Names names_of = names_in(links);
  for (const LinkStory& l : links) {
    j.begin_object().field("from", names_of(l.from)).field("to", names_of(l.to)).field("captured", l.captured);
    j.field("sender_told", l.sender_told).field("receiver_told", l.receiver_told);
    j.field("sent", l.sent).field("received", l.received).field("duplicates", l.duplicates);
    j.field("outside", l.outside).field("cut", l.cut);
    put(j, "lost_before", l.lost_before);
    put(j, "lost_behind", l.lost_after);
    put(j, "after_trace", l.after_trace);
    put(j, "contradictions", l.contradictions);
    j.end_object();
  }
  j.end_array().key("confirmed").begin_array();
  for (const WorldCheck& w : worlds.traces) {
    j.begin_object().field("trace", w.label).field("compared", w.compared).field("alike", w.alike);
    j.field("not_rebuilt", w.beyond).field("given_up", w.given_up).field("superseded", w.superseded).end_object();
  }
  j.end_array().end_object();
  return j.text();
}

int run_compare(const CompareOptions& o) {
  Comparison comparison;
  std::vector<std::string> captures_files;
  const auto note = [](const std::string& text) { std::fprintf(stderr, "padr-capture: %s\n", text.c_str()); };
  for (const std::string& f : shell::without_empty(o.files, note)) {
    if (is_trace(f)) {
      comparison.add_trace(f);
    } else {
      captures_files.push_back(f);
    }
  }
  if (captures_files.empty()) throw UserError("compare: all of these are traces; give a capture, too");
  if (comparison.traces().empty()) {
    std::string names;
    for (const std::string& f : captures_files) open_source(f);  // throws if it is missing
    for (const std::string& f : captures_files) names += (names.empty() ? "'" : ", '") + f + "'";
    throw UserError("compare: give a trace of padr-peer --trace, too; none of these is one: " + names);
  }
  Captures captures(captures_files, o.keylogs);
  Bookkeeper books;
  while (const Datagram* d = captures.next()) {
    comparison.add(*d);
    books.take(*d);
  }
  const int read = warn_unread(captures);
  for (const TraceStory& t : comparison.traces())
    if (!t.clean)
      std::fprintf(stderr, "padr-capture: %s breaks off at tick %d; it is compared up to there\n", t.label.c_str(),
                   static_cast<int>(t.last_tick));
  const std::vector<LinkStory> links = comparison.links();
  const WorldChecks worlds = compare_worlds(books, captures.contents(), comparison.traces());
  const bool compared = worlds.not_compared.empty();
  bool agree = true;
  for (const LinkStory& l : links) agree = agree && (l.captured == 0 || l.contradictions.empty());
  for (const WorldCheck& w : worlds.traces) agree = agree && (w.superseded || w.alike == w.compared);
  if (o.json != "-") {
    std::string text = links_text(links, o.losses) + worlds_text(worlds);
    if (comparison.damaged() + comparison.damaged_received() > 0)
      text += "damaged on the way: " + std::to_string(comparison.damaged()) + " in the capture, " +
              std::to_string(comparison.damaged_received()) + " received\n";
    if (comparison.cut() > 0) text += "cut off by the capture: " + std::to_string(comparison.cut()) + "\n";
    text += !agree     ? "CAPTURE AND TRACES DISAGREE\n"
            : compared ? "capture and traces agree, except for lost datagrams\n"
                       : "the datagrams agree, except for lost ones; THE WORLDS WERE NOT COMPARED\n";
    shell::write_text("", "-", text);
  }
  if (!o.json.empty()) shell::write_text("--json", o.json, as_json(comparison, links, worlds, agree && compared));
  return agree && compared ? read : shell::kExitFailure;
}

}  // namespace

Run declare_compare(CLI::App& app) {
  const auto o = std::make_shared<CompareOptions>();
  app.footer(kCompareFooter);
  app.add_option("FILE", o->files, "Captures and traces in any order; the program recognises each")
      ->required()
      ->type_name("CAPTURE|TRACE");
  declare_keylogs(app, o->keylogs);
  app.add_flag("--losses", o->losses, "Name every datagram that was lost, not only the first of each link");
  app.add_option("--json", o->json, "Everything as JSON; - for standard output, in place of the text")
      ->type_name("FILE|-");
  return [o](const std::vector<std::string>&) { return run_compare(*o); };
}

}  // namespace padr::capture
