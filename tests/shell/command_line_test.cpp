// What a wrong value on a command line is answered with.
#include "shell/command_line.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "common/model/user_error.h"

namespace padr::test {
namespace {

/// The message, or nothing if the words are taken.
std::string answer_of(CLI::App& app, const std::vector<const char*>& words) {
  std::vector<const char*> argv{"program"};
  argv.insert(argv.end(), words.begin(), words.end());
  try {
    shell::parse(app, static_cast<int>(argv.size()), argv.data());
  } catch (const UserError& e) {
    return e.what();
  }
  return "";
}

std::string answer_to(const std::vector<const char*>& words) {
  double seconds = 1;
  int peers = 2;
  double factor = 1;
  std::uint64_t seed = 1;
  CLI::App app;
  app.add_option("--seconds", seconds)->check(shell::range(0.1, 1'000'000));
  app.add_option("--peers", peers)->check(shell::range(1, 64));
  app.add_option("--factor", factor);
  app.add_option("--seed", seed)->check(shell::whole_number());
  return answer_of(app, words);
}

TEST(CommandLine, AWrongValueIsNamedWithWhatIsAllowed) {
  struct Row {
    std::vector<const char*> words;
    std::string answer;
  };
  const std::vector<Row> rows{
      {{"--seconds", "0.1", "--peers", "64", "--factor", "1e9", "--seed", "0"}, ""},
      {{"--seconds", "0"}, "--seconds: '0' is not allowed; give 0.1 to 1000000 (see --help)"},
      {{"--seconds", "nan"}, "--seconds: 'nan' is not allowed; give 0.1 to 1000000 (see --help)"},
      {{"--peers", "65"}, "--peers: '65' is not allowed; give 1 to 64 (see --help)"},
      {{"--peers", "2.5"}, "--peers: '2.5' is not allowed; give a whole number (see --help)"},
      {{"--factor", "x"}, "--factor: 'x' is not allowed; give a number (see --help)"},
      {{"--seed", "-1"},
       "--seed: '-1' is not allowed; give a whole number from 0 to 18446744073709551615 (see --help)"},
      {{"--peers", "2", "--peers", "3"}, "--peers: given 2 times; give it once (see --help)"},
      {{"--peers"}, "--peers: no value; give INT (see --help)"},
      {{"--sed", "1"}, "'--sed' is no option here; did you mean --seed? (see --help)"},
      {{"--seconds", "2", "--duration", "2"}, "'--duration' is no option here (see --help)"},
      {{"--pears", "2"}, "'--pears' is no option here; did you mean --peers? (see --help)"},
      {{"--beds=2"}, "'--beds' is no option here (see --help)"},
  };
  for (const Row& r : rows) EXPECT_EQ(answer_to(r.words), r.answer);
}

// Once, what was written replaced what was to be read, or the other result.
TEST(CommandLine, NoTwoOptionsNameOneFile) {
  struct Row {
    std::vector<const char*> words;
    std::string answer;
  };
  const std::vector<Row> rows{
      {{"a", "--json", "b", "--csv", "c"}, ""},
      {{"-", "--json", "-"}, ""},
      {{"a", "a", "--json", "/dev/null", "--csv", "/dev/null"}, ""},
      {{"a", "b", "--json", "./b"}, "TRACE and --json: both name the file './b'; give each its own"},
      {{"a", "--json", "x/../c", "--csv", "c"}, "--json and --csv: both name the file 'c'; give each its own"},
      {{"a", "--json", "-", "--csv", "-"},
       "--json and --csv: only one of them can be printed; give a file in place of -"},
      {{"a", "--input", "path:b,loop", "--csv", "b"}, "--csv and --input: both name the file 'b'; give each its own"},
      {{"a", "--input", "wander", "--csv", "wander"}, ""},
      {{"a", "--netem", "delay 5ms trace b", "--json", "b"},
       "--json and --netem: both name the file 'b'; give each its own"},
      {{"a", "--netem-to", "2=trace b", "--json", "b"},
       "--json and --netem-to: both name the file 'b'; give each its own"},
      {{"a", "--netem-to", "2=trace b", "--netem", "trace b"}, ""},
      {{"a", "--scenario", "arena,b", "--json", "b"},
       "--json and --scenario: both name the file 'b'; give each its own"},
  };
  for (const Row& r : rows) {
    CLI::App app;
    std::vector<std::string> traces;
    std::string json;
    std::string csv;
    app.add_option("TRACE", traces)->type_name("FILE ...");
    app.add_option("--json", json)->type_name("FILE|-");
    app.add_option("--csv", csv)->type_name("FILE|-");
    std::string read;
    app.add_option("--input", read)->type_name("SPEC");
    app.add_option("--netem", read)->type_name("SPEC");
    app.add_option("--netem-to", read)->type_name("WHERE=SPEC");
    app.add_option("--scenario", read)->type_name("NAMES|FILES");
    EXPECT_EQ(answer_of(app, r.words), r.answer);
  }
}

// Once, only paths were compared, and a result replaced what was to be read.
TEST(CommandLine, TwoHardLinksAreOneFile) {
  const auto folder = std::filesystem::temp_directory_path() / "padr-hard-links-test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const auto path = [&folder](const char* name) { return (folder / name).string(); };
  for (const char* name : {"trace", "copy"}) std::ofstream(path(name)) << "x";
  std::filesystem::create_hard_link(path("trace"), path("link"));
  CLI::App app;
  std::string trace;
  std::string json;
  app.add_option("TRACE", trace)->type_name("FILE");
  app.add_option("--json", json)->type_name("FILE|-");
  const auto answer = [&](const std::string& read, const std::string& written) {
    return answer_of(app, {read.c_str(), "--json", written.c_str()});
  };
  EXPECT_EQ(answer(path("trace"), path("link")),
            "TRACE and --json: both name the file '" + path("link") + "'; give each its own");
  EXPECT_EQ(answer(path("trace"), path("copy")), "");
  EXPECT_EQ(answer(path("trace"), path("new")), "");
  std::filesystem::remove_all(folder);
}

// Once, `--key-file "$KEY"` without such a variable played without a key.
TEST(CommandLine, AnEmptyValueIsNotAnOptionThatIsLeftOut) {
  const auto answer = [](const std::vector<const char*>& words) -> std::string {
    CLI::App app;
    app.require_subcommand(0, 1);
    std::string text;
    app.add_option("--netem", text)->type_name("SPEC");
    app.add_option("--liar", text)->expected(0, 1)->type_name("[NAME]");
    CLI::App& command = *app.add_subcommand("audit");
    command.add_option("TRACE", text)->type_name("FILE");
    command.add_option("--json", text)->type_name("FILE|-");
    return answer_of(app, words);
  };
  EXPECT_EQ(answer({"audit", "a", "--json", "b"}), "");
  EXPECT_EQ(answer({"audit", "a", "--json", ""}), "--json: is empty; give FILE|-, or leave --json out");
  EXPECT_EQ(answer({"audit", "a", "--json="}), "--json: no value; give FILE|- (see --help)");
  EXPECT_EQ(answer({"audit", ""}), "TRACE: is empty; leave TRACE out");
  EXPECT_EQ(answer({"--netem", "", "audit", "a"}), "") << "no impairments";
  EXPECT_EQ(answer({"--liar"}), "") << "its value may be left out";
}

// CLI11 takes a number that begins with 0 for octal.
TEST(CommandLine, NoNumberIsTakenForOctal) {
  for (const CLI::Validator& check : {shell::whole_number(), shell::range(0, 100), shell::between(0, 100, "s")}) {
    EXPECT_EQ(check("10"), "");
    EXPECT_EQ(check("0"), "");
    EXPECT_TRUE(check("010").starts_with("'010' is not allowed; give ")) << check("010");
  }
  EXPECT_EQ(shell::range(0, 1)("0.25"), "");
  const auto answer = [](const char* option, const char* value) {
    int number = 0;
    unsigned size = 0;
    std::string name;
    CLI::App app;
    app.add_option("--number", number)->type_name("N");
    app.add_option("--size", size);
    app.add_option("--name", name)->type_name("NAME");
    return answer_of(app, {option, value});
  };
  EXPECT_EQ(answer("--number", "010"), "--number: '010' begins with 0; leave that out");
  EXPECT_EQ(answer("--size", "010"), "--size: '010' begins with 0; leave that out");
  EXPECT_EQ(answer("--name", "010"), "");
  EXPECT_EQ(answer("--number", "0"), "");
}

TEST(CommandLine, AWrongValueMayBeOfAnyLength) {
  CLI::App app;
  int count = 0;
  app.add_option("--count", count);
  const std::string word(1'000'000, 'x');
  const std::array argv{"program", "--count", word.c_str()};
  try {
    shell::parse(app, static_cast<int>(argv.size()), argv.data());
    FAIL() << "taken";
  } catch (const UserError& e) {
    EXPECT_TRUE(std::string(e.what()).starts_with("--count: 'xxx")) << std::string(e.what()).substr(0, 100);
    EXPECT_LT(std::string(e.what()).size(), 1000U);
  }
}

TEST(CommandLine, AFileWithoutAnOptionIsToldWhichTakeFiles) {
  CLI::App app;
  std::string trace;
  std::string capture;
  app.add_option("--trace", trace)->type_name("FILE|FOLDER");
  app.add_option("--capture", capture)->type_name("FILE");
  const auto answer = [&app](const char* word) {
    const std::array argv{"program", word};
    try {
      shell::parse(app, 2, argv.data());
    } catch (const UserError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(answer("/"), "'/' stands without an option; give a file by --trace or --capture (see --help)");
  EXPECT_EQ(answer("/no such file"),
            "'/no such file' is one word too many; put a value that has spaces in quotes (see --help)");
}

TEST(CommandLine, ASecondFileWhereOneIsReadIsSaidToBeTooMany) {
  CLI::App app;
  std::string capture;
  std::string keylog;
  app.add_option("CAPTURE", capture)->type_name("FILE");
  app.add_option("--keylog", keylog)->type_name("FILE");
  const std::array argv{"program", "/", "/tmp"};
  try {
    shell::parse(app, 3, argv.data());
    ADD_FAILURE() << "it was taken";
  } catch (const UserError& e) {
    EXPECT_EQ(std::string(e.what()), "'/tmp' is one word too many; give one CAPTURE (see --help)");
  }
}

TEST(CommandLine, WhoGivesNoCommandIsToldWhichThereAre) {
  CLI::App app;
  app.add_subcommand("run");
  app.add_subcommand("audit");
  app.require_subcommand(1);
  const auto answer = [&app](const std::vector<const char*>& argv) {
    try {
      shell::parse(app, static_cast<int>(argv.size()), argv.data());
    } catch (const UserError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(answer({"program"}), "give a command: run, audit (see --help)");
  EXPECT_EQ(answer({"program", "rum"}), "'rum' is no command; allowed: run, audit (see --help)");
  EXPECT_EQ(answer({"program", "audit"}), "");
}

}  // namespace
}  // namespace padr::test
