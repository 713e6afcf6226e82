#include "tools/monitor/page_server.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "tools/monitor/assets.h"
#include "tools/monitor/guard.h"

namespace padr::monitor {
namespace {

constexpr int kWrongTokens = 5;  // of one viewer, until it is dismissed

Reply json(std::string text) {
  return {200, "application/json", std::move(text), ""};
}

Reply error(unsigned status, const std::string& why) {
  Reply r;
  r.status = status;
  r.body = why + "\n";
  return r;
}

}  // namespace

PageServer::PageServer(const Options& options, std::string mode, std::string source, std::string sample)
    : options_(options), mode_(std::move(mode)), source_(std::move(source)), sample_(std::move(sample)) {}

Reply PageServer::get(std::string_view path, std::string_view query) {
  if (path == "/api/session") return json(session_json());
  if (path == "/metrics") return {200, "text/plain; version=0.0.4; charset=utf-8", metrics(), ""};
  if (path == "/api/path") return path_reply(query);
  if (path == "/") path = "/index.html";
  for (const Asset& a : assets())
    if (a.path == path) return {200, std::string(a.type), std::string(a.body), std::string(a.etag)};
  return error(404, "not here");
}

Reply PageServer::path_reply(std::string_view query) {
  const std::string_view text = query_field(query, "peer").value_or("");
  int slot = -1;
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), slot);
  if (wrong != std::errc() || end != text.data() + text.size() || slot < 0 || slot >= kMaxPeers)
    return error(400, "peer: give a slot, 0 to " + std::to_string(kMaxPeers - 1));
  std::string csv = path_csv(static_cast<PeerId>(slot));
  if (csv.empty()) return error(404, "peer " + std::to_string(slot) + " has not been driven from a page");
  return {200, "text/csv; charset=utf-8", std::move(csv), ""};
}

std::string PageServer::greeting(const Viewer& viewer) const {
  HelloWords h;
  h.mode = mode_;
  h.control = viewer.control;
  h.needs_token = !viewer.control && !options_.view_only && !options_.token.empty();
  h.source = source_;
  h.sample = sample_;
  return hello_text(h);
}

void PageServer::came(ViewerId id, bool local, std::string_view) {
  Viewer& v = viewers_[id];
  v.local = local;
  // A proxy need not say that it is one: where there is a token, it is asked of everybody.
  v.control = local && !options_.view_only && options_.token.empty();
  tell(id, greeting(v));
  introduce(id);
}

std::string_view PageServer::why_no_control() const {
  if (options_.view_only) return "this monitor only shows (--view-only)";
  if (!options_.token.empty()) return "only pages with the monitor's token may do that";
  return "only pages on the monitor's own machine may do that, as it has no token";
}

void PageServer::left(ViewerId viewer) {
  viewers_.erase(viewer);
  gone(viewer);
}

void PageServer::said(ViewerId id, std::string_view text) {
  const auto found = viewers_.find(id);
  if (found == viewers_.end()) return;
  Viewer& v = found->second;
  const Asked asked = read_request(text);
  if (!asked.request) return tell(id, answer_text(asked.id, false, asked.wrong, asked.about));
  if (const auto* s = std::get_if<Subscribe>(&*asked.request)) {
    if ((s->views & ~v.wants.views) != 0) v.serial = 0;  // what is new to it may be old
    v.wants = *s;
    return answer(id, asked, true, "");
  }
  if (std::holds_alternative<GiveToken>(*asked.request)) return take_token(id, v, asked);
  if (!v.control) return tell(id, answer_text(asked.id, false, why_no_control(), asked.about));
  act(id, asked);
}

// Telling a viewer may dismiss it: nothing of it is touched afterwards.
void PageServer::take_token(ViewerId id, Viewer& viewer, const Asked& asked) {
  const std::string& token = std::get<GiveToken>(*asked.request).token;
  const bool right = !options_.view_only && !options_.token.empty() && same_secret(token, options_.token);
  viewer.control = viewer.control || right;
  viewer.wrong_tokens += right ? 0 : 1;
  const bool guesses = viewer.wrong_tokens >= kWrongTokens;
  const std::string hello = greeting(viewer);
  answer(id, asked, right, right ? "" : "this is not the token");
  if (right) tell(id, hello);
  if (guesses && web_ != nullptr) web_->dismiss(id, "too many wrong tokens");
}

void PageServer::answer(ViewerId viewer, const Asked& asked, bool ok, std::string_view text) {
  if (asked.id || !ok) tell(viewer, answer_text(asked.id, ok, text, asked.about));
}

void PageServer::tell(ViewerId viewer, const std::string& text, bool may_miss) {
  if (web_ != nullptr) web_->tell(viewer, std::make_shared<const std::string>(text), may_miss);
}

void PageServer::tell_all(const std::string& text, bool may_miss) {
  if (web_ == nullptr) return;
  const auto shared = std::make_shared<const std::string>(text);
  // Telling may dismiss one of them.
  const auto viewers = viewers_;
  for (const auto& [id, viewer] : viewers) web_->tell(id, shared, may_miss);
}

void PageServer::introduce_all() {
  const auto viewers = viewers_;
  for (const auto& [id, viewer] : viewers) introduce(id);
}

void PageServer::forget_shown() {
  for (auto& [id, v] : viewers_) v.serial = 0;
}

void PageServer::show(ViewSource& source) {
  if (web_ == nullptr) return;
  // Most viewers want the same and have the same.
  std::map<std::pair<unsigned, std::uint64_t>, Shared> made;
  std::vector<std::pair<ViewerId, Shared>> out;
  for (auto& [id, v] : viewers_) {
    if (now_ < v.due || v.serial == source.serial()) continue;
    const Micros period = kMicrosPerSecond / v.wants.rate;
    v.due = std::max(v.due + period, now_ + period / 2);
    Shared& bytes = made[{v.wants.views, v.serial}];
    if (!bytes) {
      const auto views = source.views(v.wants.views, v.serial);
      std::string all;
      for (const ViewSource::View& view : views) all += *view.bytes;
      bytes = std::make_shared<const std::string>(std::move(all));
    }
    v.serial = source.serial();
    if (!bytes->empty()) out.emplace_back(id, bytes);
  }
  for (const auto& [id, bytes] : out) web_->show(id, bytes);
}

}  // namespace padr::monitor
