#include "shell/netem_flags.h"

#include "common/model/user_error.h"
#include "shell/command_line.h"
#include "shell/files.h"
#include "shell/netem_text.h"

namespace padr::shell {

namespace {

constexpr const char* kGrammar =
    "SPEC is what follows `netem` in `tc qdisc add ... netem SPEC`, see tc-netem(8), in one argument:\n"
    "  limit PACKETS    duplicate PERCENT [CORRELATION]    corrupt PERCENT [CORRELATION]\n"
    "  delay TIME [JITTER [CORRELATION]] [distribution uniform|normal|pareto|paretonormal]\n"
    "  loss PERCENT [CORRELATION] | loss state P13 [P31 [P32 [P23 [P14]]]] | loss gemodel P [R [1-H [1-K]]]\n"
    "  reorder PERCENT [CORRELATION] [gap N]    rate RATE [OVERHEAD [CELL [CELLOVERHEAD]]]\n"
    "  slot MIN [MAX] [packets N] [bytes B] | slot distribution NAME DELAY JITTER [packets N] [bytes B]    seed N\n"
    "  trace NAME|FILE [START|random]\n"
    "TIME and START are in s, ms, us or ns; a bare number is microseconds, as with tc. trace, which tc does not have,\n"
    "is a recorded link, without rate and slot: a FILE of mahimahi's form, or one that is built in: ";

link::NetemSpec parse_named(std::string_view name, std::string_view text, std::vector<std::string>* warnings,
                            const ReadFile& read) {
  std::vector<std::string> found;
  try {
    auto spec = parse_netem(text, &found, read);
    if (warnings != nullptr)
      for (const auto& line : found) warnings->push_back(std::string(name) + ": " + line);
    return spec;
  } catch (const UserError& e) {
    throw UserError(std::string(name) + ": " + e.what());
  }
}

}  // namespace

std::string netem_help() {
  return kGrammar + link_trace_names() + ".";
}

link::NetemSpec parse_netem_flag(std::string_view flag, std::string_view text, std::vector<std::string>* warnings) {
  return parse_named(flag, text, warnings, [](const std::string& file) { return read_file("as a file", file); });
}

link::NetemSpec parse_netem_field(std::string_view field, std::string_view text, std::vector<std::string>* warnings) {
  return parse_named(field, text, warnings, {});
}

std::string describe(const link::NetemSpec& spec) {
  const std::string text = to_string(spec);
  return text.empty() ? "unimpaired" : "\"" + text + "\"";
}

void NetemFlags::declare(CLI::App& app) {
  const std::string group = "Network";
  app.add_option("--netem", text_, "Impairment of outgoing datagrams, in the grammar of tc-netem; default: none")
      ->type_name("SPEC")
      ->group(group);
  app.add_option("--netem-seed", seed_,
                 "Seed of the impairments; the same seed impairs the same datagrams alike; default: --seed")
      ->type_name("N")
      ->check(whole_number())
      ->group(group);
}

link::NetemSpec NetemFlags::spec(std::vector<std::string>* warnings) const {
  return parse_netem_flag("--netem", text_, warnings);
}

}  // namespace padr::shell
