#pragma once

#include <spdlog/logger.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "common/model/ids.h"

namespace padr::peer {

/// The peer's loggers, one a subsystem, all to standard error.
struct Log {
  Log(spdlog::level::level_enum level, const std::map<std::string, spdlog::level::level_enum>& levels);
  std::shared_ptr<spdlog::logger> session;  ///< coming together, leaving, losing one another
  std::shared_ptr<spdlog::logger> net;      ///< socket, datagrams, impairment
  std::shared_ptr<spdlog::logger> play;     ///< ticks and worlds
  std::shared_ptr<spdlog::logger> status;   ///< the line a second
};

bool is_subsystem(const std::string& name);
/// For messages: "net, play, ...".
std::string subsystem_names();

/// Lets through `burst` messages at once and as many a second: for whatever can repeat per packet.
class RateLimit {
 public:
  explicit RateLimit(double burst = 5) : burst_(burst), tokens_(burst) {}
  bool pass(Micros now);

 private:
  double burst_;
  double tokens_;
  Micros last_ = 0;
};

}  // namespace padr::peer
