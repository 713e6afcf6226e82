#include "tools/monitor/lobby.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "tools/monitor/guard.h"

namespace padr::monitor {

Lobby::Lobby(const Options& options, std::unique_ptr<PageServer> main) : options_(options), main_(std::move(main)) {}

void Lobby::connect(WebServer* web) {
  web_ = web;
  main_->connect(web);
  for (const auto& [name, projector] : samples_) projector->connect(web);
}

void Lobby::advance(Micros now) {
  now_ = now;
  film();
  main_->advance(now);
  for (const auto& [name, projector] : samples_) projector->advance(now);
}

void Lobby::film() {
  if (filmed_.valid()) {
    if (filmed_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    const Sample& done = *wanted_.front();
    wanted_.pop_front();
    samples_.find(done.name)->second->put(filmed_.get());
  }
  if (!wanted_.empty())
    filmed_ = std::async(std::launch::async, [sample = wanted_.front()] { return film_sample(*sample); });
}

PageServer& Lobby::desk(std::string_view query) {
  const Sample* sample = find_sample(query_field(query, "sample").value_or(""));
  if (sample == nullptr) return *main_;
  std::unique_ptr<Projector>& projector = samples_[std::string(sample->name)];
  if (!projector) {
    projector = std::make_unique<Projector>(options_, "trace", lab_command(*sample), Film{}, std::string(sample->name));
    wanted_.push_back(sample);
    projector->connect(web_);
    projector->advance(now_);  // its time begins now
  }
  return *projector;
}

Reply Lobby::get(std::string_view path, std::string_view query) {
  return path == "/api/session" ? desk(query).get(path, query) : main_->get(path, query);
}

void Lobby::came(ViewerId viewer, bool local, std::string_view query) {
  PageServer& where = desk(query);
  const bool first = std::none_of(where_.begin(), where_.end(), [&where](const auto& w) { return w.second == &where; });
  where_[viewer] = &where;
  if (first && &where != main_.get()) static_cast<Projector&>(where).begin();
  // Telling may dismiss the viewer: nothing of it is touched afterwards.
  where.came(viewer, local, query);
}

void Lobby::said(ViewerId viewer, std::string_view text) {
  const auto found = where_.find(viewer);
  if (found != where_.end()) found->second->said(viewer, text);
}

void Lobby::left(ViewerId viewer) {
  const auto found = where_.find(viewer);
  if (found == where_.end()) return;
  PageServer& where = *found->second;
  where_.erase(found);
  where.left(viewer);
}

}  // namespace padr::monitor
