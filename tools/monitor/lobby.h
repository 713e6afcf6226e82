#pragma once

#include <deque>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "tools/monitor/page_server.h"
#include "tools/monitor/projector.h"
#include "tools/monitor/samples.h"

namespace padr::monitor {

/// Where pages come to. They are shown what the program was started for, or, with `?sample=NAME` in their address, that
/// sample: it is filmed when the first page asks for it, and kept. All pages that look at a sample share its position.
///
/// Filming takes seconds on a slow machine, and peers and other pages must not wait for it: a thread does it, one
/// sample after the other.
class Lobby : public Site {
 public:
  Lobby(const Options& options, std::unique_ptr<PageServer> main);

  /// Where messages go; null: nowhere.
  void connect(WebServer* web);
  /// To be called often: does what is due.
  void advance(Micros now);

  Reply get(std::string_view path, std::string_view query) override;
  void came(ViewerId viewer, bool local, std::string_view query) override;
  void said(ViewerId viewer, std::string_view text) override;
  void left(ViewerId viewer) override;

 private:
  /// Puts a film that is ready where it belongs, and has the next one made.
  void film();
  /// For a query: what was asked for, else the main one.
  PageServer& desk(std::string_view query);

  const Options& options_;
  WebServer* web_ = nullptr;
  Micros now_ = 0;
  std::unique_ptr<PageServer> main_;
  std::map<std::string, std::unique_ptr<Projector>, std::less<>> samples_;
  std::map<ViewerId, PageServer*> where_;
  std::deque<const Sample*> wanted_;  ///< without a film; the first is being filmed if there is a `filmed_`
  std::future<Film> filmed_;
};

}  // namespace padr::monitor
