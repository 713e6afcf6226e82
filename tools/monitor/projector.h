#pragma once

#include "tools/monitor/film.h"
#include "tools/monitor/page_server.h"

namespace padr::monitor {

/// Shows a film: one position for all pages. With an empty one it only greets, until another is put.
class Projector : public PageServer {
 public:
  Projector(const Options& options, std::string mode, std::string source, Film film, std::string sample = "");

  /// In place of the empty film: plays from the beginning.
  void put(Film film);

  void advance(Micros now) override;
  /// Plays from the beginning.
  void begin();

 private:
  void introduce(ViewerId viewer) override;
  void act(ViewerId viewer, const Asked& asked) override;
  std::string session_json() override;
  std::string metrics() override;

  bool empty() const { return film_.moments.empty(); }
  void seek(Tick tick);
  void tell_timeline();
  std::string timeline() const;
  void halt();
  void tell_table();
  void tell_series();

  Film film_;
  Screen screen_;
  double position_;  ///< tick, with its fraction
  bool playing_ = true;
  double speed_ = 1;
  Micros last_ = 0;
  Micros next_timeline_ = 0;
  const Film::Table* told_ = nullptr;
};

}  // namespace padr::monitor
