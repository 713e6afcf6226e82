#include "tools/capture/summary.h"

#include <algorithm>
#include <tuple>

#include "shell/text.h"
#include "tools/capture/names.h"

namespace padr::capture {
namespace {

std::string count(std::uint64_t n) {
  return std::to_string(n);
}

std::string percent(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? "-" : shell::fixed_or_dash(100.0 * static_cast<double>(part) / static_cast<double>(whole), 1);
}

double per_second(std::uint64_t n, double seconds) {
  return seconds > 0 ? static_cast<double>(n) / seconds : 0;
}

std::string contents_text(const Source& s, const Tally& t) {
  std::string out;
  for (const std::string& f : s.files) out += (out.empty() ? "" : ", ") + (f == "-" ? "standard input" : f);
  const Contents& c = s.contents;
  out += ": " + shell::counted(c.packets, "packet") + ", " + shell::counted(c.ours, "datagram") + " of PADR in " +
         shell::fixed_or_dash(t.all().seconds(), 1) + " s";
  const auto add = [&out](std::uint64_t n, const std::string& what) {
    if (n > 0) out += ", " + count(n) + " " + what;
  };
  const auto of = [&c](Content k) { return c.of[static_cast<std::size_t>(k)]; };
  add(c.seen_again, s.files.size() > 1 ? "seen in another file, too" : "seen from another address, too");
  add(c.back, "earlier than the one before");
  const auto sealed = [&c](Keyring::Reading r) { return c.sealed[static_cast<std::size_t>(r)]; };
  add(sealed(Keyring::Reading::kChecked), "sealed and checked");
  add(sealed(Keyring::Reading::kUnchecked), "sealed and not checked");
  add(sealed(Keyring::Reading::kHidden), "encrypted");
  add(sealed(Keyring::Reading::kWrong), "that fit no key of their senders");
  add(c.carried, "carried by a third peer");
  add(c.handshakes, "of handshakes");
  add(c.others, "of other UDP");
  add(of(Content::kOther), "without UDP");
  add(of(Content::kFragment), "fragments left out");
  add(of(Content::kUnknownLink), "of link types that are not understood");
  add(of(Content::kMalformed), "with malformed headers");
  add(of(Content::kCutHeaders), "cut off in their headers");
  out += '\n';
  for (const auto& [why, n] : t.dropped()) out += "dropped (" + why + "): " + count(n) + "\n";
  if (t.beyond() > 0) out += "in too many sessions, peers or links to be told apart: " + count(t.beyond()) + "\n";
  return out;
}

std::string session_text(std::uint16_t number, const SessionTally& s) {
  std::string out = "\nSession " + std::to_string(number) + ": ";
  if (s.join_seen) out += s.scenario + (s.authority ? ", dynamic authority, " : ", avatar-only, ");
  out += "ticks " + count(s.first_tick) + " to " + count(s.last_tick) + ", " + count(s.hashes) +
         (s.hashes == 1 ? " hash told" : " hashes told");
  if (s.slots > 0) out += ", " + std::to_string(s.slots) + " slots, " + std::to_string(s.wanted) + " waited for";
  return out + "\n";
}

std::string lives_text(const Tally& t, std::uint16_t session) {
  shell::Table table({"peer", "at", "s", "dgrams", "dgrams/s", "kbit/s", "mean B", "most B", "updates/s", "threshold",
                      "begin", "end", "proxy", "body", "rest", "left"});
  for (const auto& [key, who] : t.incarnations()) {
    if (key.session != session) continue;
    const Traffic& f = who.traffic;
    std::uint64_t updates = 0;
    for (const std::uint64_t n : who.updates) updates += n;
    std::vector<std::string> row{
        life_name(t, key),
        to_string(who.at),
        shell::fixed_or_dash(f.seconds(), 1),
        count(f.datagrams),
        shell::fixed_or_dash(per_second(f.datagrams, f.seconds()), 1),
        shell::fixed_or_dash(per_second(f.bytes * 8, f.seconds()) / 1000, 1),
        shell::fixed_or_dash(static_cast<double>(f.bytes - f.header_bytes) / static_cast<double>(f.datagrams), 0),
        count(f.most_size),
        shell::fixed_or_dash(per_second(updates, f.seconds()), 1)};
    for (std::size_t c = 0; c < 6; ++c) row.push_back(count(who.updates[c]));
    row.emplace_back(who.left ? "yes" : "no");
    table.row(std::move(row));
  }
  return "State datagrams; updates of entities by cause, each once; sizes of the UDP payload.\n" + table.text();
}

std::string links_text(const Tally& t, std::uint16_t session) {
  const auto [tick0, by_clock] = t.tick0(session);
  bool between = false;
  shell::Table table({"link",  "dgrams", "lost",         "of",    "loss %",   "told %", "of",
                      "dupl",  "late",   "gap ms",       "p95",   "delay ms", "p50",    "p95",
                      "least", "jitter", "peers' least", "marks", "resent",   "ack ms"});
  for (const auto& [key, tally] : links_of(t, session)) {
    const LinkTally& link = *tally;
    between = between || (link.passed_on && !link.direct);
    const DelayFigures d = delays_of(link, tick0);
    table.row({link_name(t, key),
               count(link.traffic.datagrams),
               t.judges(link) ? count(link.seqs.missing()) : "-",
               t.judges(link) ? count(link.seqs.span()) : "-",
               t.judges(link) ? shell::fixed_or_dash(loss_percent(link), 2) : "-",
               link.told_loss.of() == 0 ? "-" : shell::fixed_or_dash(link.told_loss.percent(), 1),
               count(link.told_loss.of()),
               count(link.duplicates),
               count(link.reordered),
               shell::fixed_or_dash(link.gaps.mean_us() / 1000, 1),
               shell::fixed_or_dash(link.gaps.percentile_us(0.95) / 1000, 1),
               shell::fixed_or_dash(d.mean_ms, 1),
               shell::fixed_or_dash(d.p50_ms, 1),
               shell::fixed_or_dash(d.p95_ms, 1),
               shell::fixed_or_dash(d.least_ms, 1),
               shell::fixed_or_dash(d.jitter_ms, 1),
               link.transit ? shell::fixed_or_dash(*link.transit / 10.0, 1) : "-",
               count(link.marks),
               count(link.repeats),
               link.acks.count() == 0 ? "-" : shell::fixed_or_dash(link.acks.mean_us() / 1000, 1)});
  }
  std::string out =
      "\nLinks. Of: datagram numbers from the first to the last in the capture. Lost: those of them that are not in "
      "it.\n"
      "Told: loss as the receiver tells it, in whole per cent, rounded down. Delay: from the begin of the tick of\n"
      "sending, by ";
  out += by_clock ? "the session's clock as Pings and Pongs tell it" : "the fastest datagram, which counts as 0";
  out +=
      ",\nto the capture. Peers' least: the delay to the receiver, as it tells it. Ack: until an update is "
      "acknowledged.\n";
  if (between && t.cut() == 0)
    out += "Of links without a loss the capture has only what a third peer carried: what went directly is not in it.\n";
  if (t.cut() > 0)
    out += "The capture has cut off " + shell::counted(t.cut(), "datagram") +
           " (snaplen; capture with -s 0): not known which links' they are, and so what was lost.\n";
  return out + table.text();
}

std::string bandwidth_text(const Tally& t) {
  const Traffic& a = t.all();
  shell::Table table({"bytes on the wire", "bytes", "%"});
  const auto row = [&](const std::string& what, std::uint64_t n) { table.row({what, count(n), percent(n, a.bytes)}); };
  row("IP and UDP headers", a.header_bytes);
  row("envelopes", a.envelope_bytes);
  row("updates", a.update_bytes);
  row("updates again", a.repeat_bytes);
  row("marks, acks, hashes", a.mark_bytes);
  row("session, membership", a.other_bytes);
  if (a.cut_bytes > 0) row("cut off by the capture", a.cut_bytes);
  row("all", a.bytes);
  std::string out = "\n" + table.text();
  if (!t.messages().empty()) {
    out += "\nSession and membership:";
    for (const auto& [name, n] : t.messages()) out += " " + name + " " + count(n);
    out += '\n';
  }
  return out;
}

}  // namespace

// An incarnation is told only after the first of its slot.
std::string life_name(const Tally& tally, const LifeKey& who) {
  const auto first = tally.incarnations().lower_bound({who.session, who.slot, 0});
  const bool alone = first != tally.incarnations().end() && first->first == who;
  return std::to_string(who.slot) + (alone ? "" : "." + std::to_string(who.incarnation));
}

std::string link_name(const Tally& tally, const LinkKey& link) {
  const PeerId to = tally.receiver(link);
  const std::string who = to == kNoPeer ? to_string(tally.links().at(link).at)
                                        : life_name(tally, {link.from.session, to, link.to_incarnation});
  return life_name(tally, link.from) + " -> " + who;
}

std::vector<std::pair<LinkKey, const LinkTally*>> links_of(const Tally& tally, std::uint16_t session) {
  std::vector<std::pair<LinkKey, const LinkTally*>> all;
  for (const auto& [key, link] : tally.links())
    if (key.from.session == session) all.emplace_back(key, &link);
  std::stable_sort(all.begin(), all.end(), [&tally](const auto& a, const auto& b) {
    const auto order = [&tally](const LinkKey& k) { return std::tuple(k.from, tally.receiver(k), k.to_incarnation); };
    return order(a.first) < order(b.first);
  });
  return all;
}

double loss_percent(const LinkTally& link) {
  const std::uint64_t of = link.seqs.span();
  return of == 0 ? 0 : 100.0 * static_cast<double>(link.seqs.missing()) / static_cast<double>(of);
}

DelayFigures delays_of(const LinkTally& link, std::int64_t tick0) {
  const auto zero = static_cast<double>(tick0);
  const Delays& d = link.delays;
  return {(d.mean_us() - zero) / 1000, (d.percentile_us(0.5) - zero) / 1000, (d.percentile_us(0.95) - zero) / 1000,
          (static_cast<double>(d.least_us()) - zero) / 1000, d.jitter_us() / 1000};
}

std::string summary_text(const Source& source, const Tally& tally) {
  std::string out = contents_text(source, tally);
  for (const auto& [number, session] : tally.sessions()) {
    if (session.states == 0) continue;
    out += session_text(number, session) + lives_text(tally, number) + links_text(tally, number);
  }
  if (tally.all().datagrams > 0) out += bandwidth_text(tally);
  for (const std::string& t : source.troubles) out += "\nIncomplete: " + t + "\n";
  return out;
}

}  // namespace padr::capture
