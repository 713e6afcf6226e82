#include "tools/capture/sentence.h"

#include <set>

#include "shell/text.h"

namespace padr::capture {
namespace {

std::string first(const Record& r, std::string_view name) {
  const auto* values = r.find(name);
  return values == nullptr ? "" : values->front().text;
}

std::string joined(const std::vector<Record::Value>* values) {
  std::string out;
  if (values == nullptr) return out;
  for (const auto& v : *values) out += (out.empty() ? "" : " ") + v.text;
  return out;
}

std::string who(const Record& r) {
  const std::string from = first(r, "padr.peer");
  const std::string to = first(r, "padr.to");
  const std::string address = first(r, "ip.dst") +
                              (first(r, "ipv6.dst").empty() ? "" : "[" + first(r, "ipv6.dst") + "]") + ":" +
                              first(r, "udp.dstport");
  const std::string carried = first(r, "padr.carried.to").empty() ? "" : "carried, ";
  return carried + (from == "255" || from.empty() ? "newcomer" : "peer " + from) + " -> " +
         (to.empty() ? address : to) + ": ";
}

std::string causes(const Record& r) {
  std::set<std::string> all;
  if (const auto* values = r.find("padr.cause"))
    for (const auto& v : *values) all.insert(v.text);
  std::string out;
  for (const std::string& c : all) out += (out.empty() ? " (" : ", ") + c;
  return out.empty() ? out : out + ")";
}

std::string state(const Record& r) {
  std::string out = "tick " + first(r, "padr.tick");
  const std::string updates = first(r, "padr.updates");
  if (first(r, "padr.mark") == "true") {
    out += ", mark, has " + first(r, "padr.have");
  } else {
    out += ", " + shell::counted(std::stoul(updates), "update") + causes(r);
    if (const auto* bodies = r.find("padr.entity"))
      out += ", " + std::string(bodies->size() == 1 ? "body " : "bodies ") + joined(bodies);
  }
  if (r.find("padr.update.leave") != nullptr) out += ", leaves";
  if (r.find("padr.update.spectates") != nullptr) out += ", spectates";
  if (const auto* in = r.find("padr.admission.slot")) out += ", admits " + joined(in);
  if (const auto* gone = r.find("padr.removal.slot")) out += ", declares gone " + joined(gone);
  if (const auto* passed = r.find("padr.passed_on.slot")) out += ", passes on of " + joined(passed);
  if (r.find("padr.check_hash") != nullptr)
    out += ", confirms " + first(r, "padr.check_tick") + ": " + first(r, "padr.check_hash");
  return out;
}

}  // namespace

std::string sentence(const Record& r) {
  std::string out = first(r, "frame.time_epoch") + "  " + who(r);
  if (r.find("padr.drop") != nullptr) return out + "dropped: " + first(r, "padr.drop");
  if (r.find("padr.seq") != nullptr) return out + state(r);
  if (r.find("padr.message") == nullptr) return out + "cut off by the capture";
  out += first(r, "padr.message");
  if (r.find("padr.join.scenario") != nullptr) out += " " + first(r, "padr.join.scenario");
  if (r.find("padr.welcome.peer") != nullptr) out += " as peer " + first(r, "padr.welcome.peer");
  if (r.find("padr.refuse.reason") != nullptr) out += ": " + first(r, "padr.refuse.reason");
  if (r.find("padr.piece.index") != nullptr)
    out += " " + first(r, "padr.piece.index") + " of " + first(r, "padr.piece.count");
  return out;
}

}  // namespace padr::capture
