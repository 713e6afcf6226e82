#include "tools/report/survey.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "common/model/user_error.h"
#include "common/trace/trace_reader.h"

namespace padr::report {
namespace {

template <typename T>
void same(const char* what, const T& a, const T& b, const std::string& first, const std::string& second) {
  if (a != b) throw UserError(second + ": is of another session than " + first + ": " + what + " differs");
}

void check_pair(const trace::Header& a, const trace::Header& b, const std::string& first, const std::string& second) {
  same("the scenario", a.scene_hash, b.scene_hash, first, second);
  same("the session number", a.session, b.session, first, second);
  if (a.incarnation == 0 && b.incarnation == 0) same("the number of peers", a.peers, b.peers, first, second);
  same("the number of avatar slots", a.slots, b.slots, first, second);
  same("the number of bodies", a.bodies, b.bodies, first, second);
  same("the physics", a.fingerprint, b.fingerprint, first, second);
  same("whether there is authority over bodies", a.technique.authority, b.technique.authority, first, second);
}

}  // namespace

Survey survey(const TraceBytes& trace) {
  trace::TraceReader reader(trace.bytes, trace.label);
  Survey s;
  s.header = reader.header();
  while (const auto event = reader.next()) {
    if (const auto* step = std::get_if<trace::Step>(&*event)) {
      if (s.first_step < 0) s.first_step = step->tick;
      if (s.came < 0 && !step->outside) s.came = step->tick;
      s.last_tick = step->tick;
    }
    if (const auto* c = std::get_if<trace::Confirmed>(&*event); c != nullptr && s.confirmed_from < 0)
      s.confirmed_from = c->tick;
    if (const auto* f = std::get_if<trace::Footer>(&*event)) s.superseded = f->superseded;
  }
  return s;
}

std::optional<std::size_t> life_at(const std::vector<Survey>& all, PeerId slot, std::uint32_t incarnation, Tick t) {
  for (std::size_t i = all.size(); i-- > 0;) {
    const trace::Header& h = all[i].header;
    if (h.peer == slot && h.incarnation == incarnation && all[i].covers(t)) return i;
  }
  return std::nullopt;
}

void check_together(const std::vector<Survey>& all, const std::vector<TraceBytes>& traces) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    check_pair(all[0].header, all[i].header, traces[0].label, traces[i].label);
    for (std::size_t j = 0; j < i; ++j)
      if (same_incarnation(all[j].header, all[i].header))
        throw UserError(traces[i].label + ": is a trace of peer " + std::to_string(all[i].header.peer) +
                        ", and so is " + traces[j].label);
  }
}

std::vector<std::size_t> in_order(const std::vector<Survey>& all) {
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto key = [&all](std::size_t i) {
    const trace::Header& h = all[i].header;
    return std::tuple(h.peer, h.incarnation, all[i].came, h.start_unix_us);
  };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  return order;
}

void give_names(std::vector<Survey>& ordered) {
  for (std::size_t i = 0; i < ordered.size(); ++i) {
    const PeerId slot = ordered[i].header.peer;
    const auto in_slot = [slot](const Survey& s) { return s.header.peer == slot; };
    const auto before = std::count_if(ordered.begin(), ordered.begin() + static_cast<std::ptrdiff_t>(i), in_slot);
    const bool alone = std::count_if(ordered.begin(), ordered.end(), in_slot) == 1;
    ordered[i].name = std::to_string(slot) + (alone ? "" : "." + std::to_string(before + 1));
  }
}

}  // namespace padr::report
