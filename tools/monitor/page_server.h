#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/model/ids.h"
#include "tools/monitor/options.h"
#include "tools/monitor/request.h"
#include "tools/monitor/view_source.h"
#include "tools/monitor/web_server.h"
#include "tools/monitor/words.h"

namespace padr::monitor {

/// What all modes have in common: the files of the page, who looks at it and what they may, and views for each at the
/// rate that it asked for. What there is to see is for who derives from it.
class PageServer : public Site {
 public:
  /// `sample`: the name of the sample that is shown; empty if it is none.
  PageServer(const Options& options, std::string mode, std::string source, std::string sample = "");

  /// Where messages go; null: nowhere.
  void connect(WebServer* web) { web_ = web; }
  /// To be called often: does what is due.
  virtual void advance(Micros now) = 0;

  Reply get(std::string_view path, std::string_view query) final;
  void came(ViewerId viewer, bool local, std::string_view query) final;
  void said(ViewerId viewer, std::string_view text) final;
  void left(ViewerId viewer) final;

 protected:
  struct Viewer {
    bool local = false;
    bool control = false;
    Subscribe wants;
    std::uint64_t serial = 0;  ///< of the newest view that it has been sent
    Micros due = 0;
    int wrong_tokens = 0;
  };

  /// Says all that a new viewer, or one that begins anew, has to know after hello.
  virtual void introduce(ViewerId viewer) = 0;
  /// A viewer that may control wants this.
  virtual void act(ViewerId viewer, const Asked& asked) = 0;
  virtual void gone(ViewerId) {}
  virtual std::string session_json() = 0;
  virtual std::string metrics() = 0;
  /// CSV; empty if there is none.
  virtual std::string path_csv(PeerId) { return ""; }

  const std::map<ViewerId, Viewer>& viewers() const { return viewers_; }
  Micros now() const { return now_; }
  void set_now(Micros now) { now_ = now; }
  void tell(ViewerId viewer, const std::string& text, bool may_miss = false);
  void tell_all(const std::string& text, bool may_miss = false);
  void answer(ViewerId viewer, const Asked& asked, bool ok, std::string_view text);
  /// To everybody whose turn it is, what is new to them.
  void show(ViewSource& source);
  /// What anybody has been shown counts no more: another source begins.
  void forget_shown();
  /// Everybody begins anew.
  void introduce_all();
  std::string greeting(const Viewer& viewer) const;
  const WebStats* web_stats() const { return web_ == nullptr ? nullptr : &web_->stats(); }
  const Options& options() const { return options_; }

 private:
  std::string_view why_no_control() const;
  void take_token(ViewerId id, Viewer& viewer, const Asked& asked);
  Reply path_reply(std::string_view query);

  const Options& options_;
  std::string mode_;
  std::string source_;
  std::string sample_;
  WebServer* web_ = nullptr;
  std::map<ViewerId, Viewer> viewers_;
  Micros now_ = 0;
};

}  // namespace padr::monitor
