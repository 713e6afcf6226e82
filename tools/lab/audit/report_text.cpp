#include "tools/lab/audit/report_text.h"

#include <algorithm>
#include <map>
#include <string_view>

#include "shell/command_line.h"
#include "shell/json.h"
#include "shell/revision.h"
#include "shell/text.h"

namespace padr::lab::audit {
namespace {

constexpr std::size_t kKeyBytesShown = 4;

std::string number(float v) {
  return shell::fixed(static_cast<double>(v), 2);
}

std::string key_text(const PublicKey& key, std::size_t bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string hex;
  for (std::size_t i = 0; i < bytes; ++i) {
    hex += kDigits[key[i] >> 4U];
    hex += kDigits[key[i] & 15U];
  }
  return hex;
}

std::string name_of(const Member& m) {
  std::string name = "slot " + std::to_string(m.slot) + ", incarnation " + std::to_string(m.incarnation);
  if (m.has_key()) name += ", key " + key_text(m.key, kKeyBytesShown) + "...";
  return name;
}

std::string labels_of(const Report& r, const std::vector<std::size_t>& traces) {
  std::string all;
  for (const std::size_t t : traces) all += (all.empty() ? "" : ", ") + r.labels[t];
  return all;
}

std::string about(const Finding& f) {
  return f.body == kNoEntity ? "" : " body " + std::to_string(f.body);
}

std::string measured(const Finding& f) {
  const std::string unit(kKindUnits[static_cast<std::size_t>(f.kind)]);
  return number(f.measured) + " " + unit + ", at most " + number(f.allowed) + " " + unit + " possible";
}

std::string words_of(const Finding& f) {
  switch (f.kind) {
    case Kind::kTwoUpdates:
      return "said two things with one number: " + f.what +
             (f.is_signed ? "; PROOF: it signed both"
              : f.passed_on_by != kNoPeer
                  ? "; unproven: slot " + std::to_string(f.passed_on_by) + " passed one of them on"
                  : "; unproven: not both signatures can be checked");
    case Kind::kAvatarSpeed:
      return "avatar at " + measured(f);
    case Kind::kAvatarAcceleration:
      return "avatar accelerates with nothing near, by " + measured(f);
    case Kind::kAvatarWay:
      return "avatar has moved by " + measured(f);
    case Kind::kClaim:
      return "claims" + about(f) + " out of reach: a chain of contacts lacks " + measured(f);
    case Kind::kBodySpeed:
      return "gives" + about(f) + " " + measured(f);
    case Kind::kBodySpin:
      return "gives the rim of" + about(f) + " " + measured(f);
    case Kind::kBodyWay:
      return "has moved" + about(f) + " by " + measured(f);
    case Kind::kBodyJump:
      return "has" + about(f) + " elsewhere than it lay, by " + measured(f);
  }
  return "";
}

std::string line_of(const Report& r, const Finding& f) {
  return "  tick " + std::to_string(f.tick) + ", update " + std::to_string(f.index) + ": " + words_of(f) + " [" +
         labels_of(r, f.traces) + "]\n";
}

using FindingIterator = std::vector<Finding>::const_iterator;

std::string paragraph(const Report& r, FindingIterator from, FindingIterator to, int worst) {
  const auto all = to - from;
  std::string out = name_of(r.evidence.members[from->who]) + ": " + shell::counted(all, "finding") + '\n';
  while (from != to) {
    const auto end = std::find_if(from, to, [from](const Finding& f) { return f.kind != from->kind; });
    const auto shown = std::min<std::ptrdiff_t>(end - from, worst);
    for (auto f = from; f != from + shown; ++f) out += line_of(r, *f);
    if (const auto more = end - from - shown; more > 0)
      out += "  and " + std::to_string(more) + " more of the kind " +
             std::string(kKindNames[static_cast<std::size_t>(from->kind)]) + "\n";
    from = end;
  }
  return out;
}

std::string pushes_text(const Report& r) {
  std::map<MemberId, std::size_t> count;
  for (const Push& p : r.pushes) ++count[p.who];
  std::string out;
  for (const auto& [who, n] : count)
    out += name_of(r.evidence.members[who]) + ": pushed bodies " + std::to_string(n) + " times; no finding\n";
  return out;
}

std::string other_worlds_text(const Report& r) {
  struct Differs {
    std::vector<std::size_t> traces;
    Tick first = 0;
  };
  std::map<MemberId, Differs> by_member;
  for (const OtherWorld& o : r.other_worlds) {
    const auto [place, fresh] = by_member.try_emplace(o.who, Differs{{}, o.noticed});
    place->second.traces.push_back(o.trace);
    place->second.first = std::min(place->second.first, o.noticed);
  }
  std::string out;
  for (const auto& [who, d] : by_member)
    out += name_of(r.evidence.members[who]) + ": its confirmed world differs from that of " + labels_of(r, d.traces) +
           ", first noticed at tick " + std::to_string(d.first) + "; no finding, as it may have been told otherwise\n";
  return out;
}

void put_member(shell::Json& j, const Member& m) {
  j.field("slot", m.slot).field("incarnation", m.incarnation).key("key");
  if (m.has_key())
    j.value(key_text(m.key, m.key.size()));
  else
    j.null();
}

void put_traces(shell::Json& j, const Report& r, const std::vector<std::size_t>& traces) {
  j.key("traces").begin_array();
  for (const std::size_t t : traces) j.value(shell::valid_utf8(r.labels[t]));
  j.end_array();
}

void put_closest(shell::Json& j, const Measure& m, std::size_t kind) {
  j.key(kKindNames[kind]).begin_object();
  if (m.is_set())
    j.field("measured", static_cast<double>(m.measured)).field("allowed", static_cast<double>(m.allowed));
  else
    j.key("measured").null().key("allowed").null();
  j.field("unit", kKindUnits[kind]).end_object();
}

void put_finding(shell::Json& j, const Report& r, const Finding& f) {
  const auto kind = static_cast<std::size_t>(f.kind);
  j.begin_object();
  put_member(j, r.evidence.members[f.who]);
  j.field("kind", kKindNames[kind]).field("tick", f.tick).field("index", f.index).key("body");
  if (f.body == kNoEntity)
    j.null();
  else
    j.value(f.body);
  j.field("measured", static_cast<double>(f.measured)).field("allowed", static_cast<double>(f.allowed));
  j.field("unit", kKindUnits[kind]).field("signed", f.is_signed).key("passed_on_by");
  if (f.passed_on_by == kNoPeer)
    j.null();
  else
    j.value(f.passed_on_by);
  j.field("what", shell::valid_utf8(words_of(f)));
  put_traces(j, r, f.traces);
  j.end_object();
}

}  // namespace

std::string text(const Report& r, int worst) {
  std::string out;
  for (auto from = r.findings.begin(); from != r.findings.end();) {
    const auto to = std::find_if(from, r.findings.end(), [from](const Finding& f) { return f.who != from->who; });
    out += paragraph(r, from, to, worst);
    from = to;
  }
  out += pushes_text(r) + other_worlds_text(r);
  for (const std::string& label : r.truncated) out += "Note: " + label + " breaks off, and counts as far as it goes\n";
  for (const std::string& label : r.with_rest)
    out += "Note: " + label + " has something behind its end that is no part of a trace\n";
  const std::string found = r.findings.empty() ? "nothing found" : shell::counted(r.findings.size(), "finding");
  return out + found + ": " + shell::counted(r.labels.size(), "trace") + ", " + std::to_string(r.updates) +
         " updates compared, " + std::to_string(r.judged) + " held against physics\n";
}

std::string json(const Report& r, const std::vector<std::string>& command) {
  shell::Json j;
  j.begin_object().field("command", shell::shell_line(command)).field("revision", shell::revision());
  j.field("updates", r.updates).field("judged", r.judged);
  put_traces(j, r, [&r] {
    std::vector<std::size_t> all(r.labels.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    return all;
  }());
  j.key("closest").begin_object();
  for (std::size_t k = 1; k < kKinds; ++k) put_closest(j, r.closest[k], k);
  j.end_object().key("findings").begin_array();
  for (const Finding& f : r.findings) put_finding(j, r, f);
  j.end_array().key("pushes").begin_array();
  for (const Push& p : r.pushes) {
    j.begin_object();
    put_member(j, r.evidence.members[p.who]);
    j.field("tick", p.tick).field("index", p.index).field("body", p.body);
    j.field("speed_mps", static_cast<double>(p.speed)).field("recorded", p.recorded);
    put_traces(j, r, p.traces);
    j.end_object();
  }
  j.end_array().key("other_worlds").begin_array();
  for (const OtherWorld& o : r.other_worlds) {
    j.begin_object();
    put_member(j, r.evidence.members[o.who]);
    j.field("trace", shell::valid_utf8(r.labels[o.trace])).field("noticed_tick", o.noticed).end_object();
  }
  return j.end_array().end_object().text();
}

}  // namespace padr::lab::audit
