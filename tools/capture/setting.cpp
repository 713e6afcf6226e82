#include "tools/capture/setting.h"

#include <algorithm>
#include <charconv>

#include "common/model/user_error.h"
#include "common/scenarios/scenarios.h"
#include "shell/command_line.h"
#include "shell/scenario_flags.h"
#include "shell/text.h"

namespace padr::capture {
namespace {

/// A Join's label is "NAME seed N"; false if it is not.
bool split_label(const std::string& label, std::string& name, std::uint64_t& seed) {
  constexpr std::string_view kSeed = " seed ";
  const auto at = label.rfind(kSeed);
  if (at == std::string::npos) return false;
  const char* begin = label.data() + at + kSeed.size();
  const char* end = label.data() + label.size();
  const auto [stop, error] = std::from_chars(begin, end, seed);
  name = label.substr(0, at);
  return error == std::errc() && stop == end;
}

bool is_built_in(const std::string& name) {
  const auto names = scenarios::embedded_names();
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

void declare_keylogs(CLI::App& app, std::vector<std::string>& keylogs) {
  app.add_option("--keylog", keylogs,
                 "File of padr-peer --keylog, to check the senders of datagrams and to decrypt. May be repeated")
      ->type_name("FILE")
      ->allow_extra_args(false);
}

CLI::Validator session_number() {
  return {[](std::string& text) -> std::string {
            const bool hex = text.starts_with("0x") || text.starts_with("0X");
            const char* begin = text.data() + (hex ? 2 : 0);
            const char* end = text.data() + text.size();
            std::uint16_t number = 0;
            const auto [stop, error] = std::from_chars(begin, end, number, hex ? 16 : 10);
            if (error != std::errc() || stop != end || number == 0)
              return "'" + text + "' is no number of a session, allowed: 1 .. 65535 or 0x1 .. 0xffff";
            text = std::to_string(number);
            return "";
          },
          ""};
}

void SettingFlags::declare(CLI::App& app, const std::string& group) {
  app.add_option("--session", session_, "Number of the session, if the capture has several; also as 0x3039")
      ->type_name("N")
      ->transform(session_number())
      ->group(group);
  app.add_option("--scenario", scenario_, "Scenario, if the capture has no Join or the session used a scenario file")
      ->type_name("NAME|FILE")
      ->group(group);
  app.add_option("--seed", seed_, "Seed of the scenario; default: the one in the Join, else 1")
      ->type_name("N")
      ->check(shell::whole_number())
      ->group(group);
  app.add_option("--wait-peers", wait_peers_, "Peers that the session waited for, if the capture has no Welcome")
      ->type_name("N")
      ->check(shell::range(1, kMaxPeers))
      ->group(group);
  app.add_option(
         "--slots", slots_,
         "Avatar slots, if the capture has no Welcome; default: that of padr-peer, 32 or as many spawn points as\n"
         "the scenario has")
      ->type_name("N")
      ->check(shell::range(1, kMaxPeers))
      ->group(group);
  app.add_flag("--avatar-only", avatar_only_,
               "The session was avatar-only (bodies have no owners), if the capture has no Join")
      ->group(group);
}

void SettingFlags::refuse_contradictions(const SessionLog& session_log) const {
  const auto refuse = [](const std::string& flag, std::optional<int> given, int told) {
    if (given && told > 0 && *given != told)
      throw UserError(flag + ": the session's Welcome says " + std::to_string(told) + ", not " +
                      std::to_string(*given));
  };
  refuse("--slots", slots_, session_log.slots);
  refuse("--wait-peers", wait_peers_, session_log.wanted);
  if (avatar_only_ && session_log.join && session_log.join->authority)
    throw UserError("--avatar-only: the session was played with dynamic authority, its Join says");
}

Setting SettingFlags::setting(const SessionLog& session_log) const {
  refuse_contradictions(session_log);
  std::string name = scenario_;
  std::uint64_t seed = 1;
  std::string told;
  if (session_log.join && split_label(session_log.join->scenario, told, seed) && name.empty()) {
    if (!is_built_in(told))
      throw UserError("--scenario: the session was played in '" + told + "', which is not built in; give the file");
    name = told;
  }
  if (name.empty())
    throw UserError("--scenario: the capture has no Join, so say what was played: --scenario NAME|FILE --seed N" +
                    std::string(session_log.slots == 0
                                    ? " --slots N, and if it begins with the session's start --wait-peers N"
                                    : ""));
  const shell::LoadedScenario loaded = shell::load_scenario(name, seed_.value_or(seed));
  Setting s;
  s.scene = loaded.scene;
  s.label = loaded.label + " seed " + std::to_string(loaded.seed);
  if (session_log.join) {
    const std::uint64_t ours = scene_hash(s.scene);
    if (ours != session_log.join->scene_hash)
      throw UserError(std::string(scenario_.empty() && seed_ ? "--seed" : "--scenario") +
                      ": the session was played in '" + session_log.join->scenario + "' (hash " +
                      shell::hex(session_log.join->scene_hash) + "), and '" + s.label + "' is another here (hash " +
                      shell::hex(ours) + ")");
    s.checked = true;
  }
  const int most = static_cast<int>(s.scene.avatar.spawns.size());
  s.authority = session_log.join ? session_log.join->authority : !avatar_only_;
  s.slots = session_log.slots > 0 ? session_log.slots : slots_.value_or(std::min(most, shell::kUsualSlots));
  s.wanted = session_log.wanted > 0 ? session_log.wanted : wait_peers_.value_or(0);
  if (s.slots > most || s.wanted > s.slots)
    throw UserError("--slots: " + std::to_string(s.slots) + " slots and " + std::to_string(s.wanted) +
                    " peers waited for do not go with scenario '" + s.label + "', which has " + std::to_string(most));
  return s;
}

}  // namespace padr::capture
