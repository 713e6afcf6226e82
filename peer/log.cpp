#include "peer/log.h"

#include <spdlog/sinks/stdout_sinks.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace padr::peer {
namespace {

constexpr std::array<std::string_view, 4> kSubsystems{"net", "play", "session", "status"};

}  // namespace

Log::Log(spdlog::level::level_enum level, const std::map<std::string, spdlog::level::level_enum>& levels) {
  const auto sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();  // also of the thread that keeps a port mapped
  sink->set_pattern("%H:%M:%S.%e %^%l%$ %n: %v");
  const auto make = [&](const std::string& name) {
    auto logger = std::make_shared<spdlog::logger>(name, sink);
    const auto own = levels.find(name);
    logger->set_level(own == levels.end() ? level : own->second);
    logger->flush_on(spdlog::level::trace);
    return logger;
  };
  session = make("session");
  net = make("net");
  play = make("play");
  status = make("status");
}

bool is_subsystem(const std::string& name) {
  return std::find(kSubsystems.begin(), kSubsystems.end(), name) != kSubsystems.end();
}

std::string subsystem_names() {
  std::string all;
  for (const std::string_view s : kSubsystems) all += (all.empty() ? "" : ", ") + std::string(s);
  return all;
}

bool RateLimit::pass(Micros now) {
  tokens_ = std::min(burst_, tokens_ + static_cast<double>(now - last_) * burst_ / kMicrosPerSecond);
  last_ = now;
  if (tokens_ < 1) return false;
  tokens_ -= 1;
  return true;
}

}  // namespace padr::peer
