// What is written over what.
#include "shell/files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/model/user_error.h"

namespace padr::shell {
namespace {

// Once, `padr-lab audit --json a.trace b.trace` wrote its result over the first trace.
TEST(Files, NoTextIsWrittenOverWhatIsNone) {
  const auto folder = std::filesystem::temp_directory_path() / "padr-files-test";
  std::filesystem::create_directories(folder);
  const std::string path = (folder / "result").string();
  const auto written = [&](std::string_view before, Content content) {
    OutputFile(".", path, Readers::kAsUsual, Content::kBinary).write(before);
    try {
      OutputFile("--json", path, Readers::kAsUsual, content).write("{}");
    } catch (const UserError& e) {
      EXPECT_NE(std::string(e.what()).find("--json: '" + path + "' is no text"), std::string::npos) << e.what();
    }
    return read_file(".", path) == "{}";
  };
  using std::string_view_literals::operator""sv;
  for (const std::string_view text : {"", "{\"a\": 1}\n", "a,b\r\n\t1", "caf\xC3\xA9"})
    EXPECT_TRUE(written(text, Content::kText)) << text;
  for (const std::string_view recording : {"PADRTRC\x09\x01"sv, "\xD4\xC3\xB2\xA1\x02\0"sv, "\n\r\r\n\0\0"sv}) {
    EXPECT_FALSE(written(recording, Content::kText)) << recording;
    EXPECT_TRUE(written(recording, Content::kBinary)) << recording;
  }
  std::filesystem::remove_all(folder);
}

TEST(Files, WhatCannotBeWrittenIsToldBeforeAndChangesNothing) {
  const auto folder = std::filesystem::temp_directory_path() / "padr-writable-test";
  std::filesystem::create_directories(folder);
  const auto why = [](const std::string& file) -> std::string {
    try {
      check_writable("--json", file);
    } catch (const UserError& e) {
      return e.what();
    }
    return "";
  };
  const std::string fresh = (folder / "fresh.json").string();
  EXPECT_EQ(why(fresh), "");
  EXPECT_FALSE(std::filesystem::exists(fresh)) << "nothing is left behind";
  write_text("--json", fresh, "old");
  EXPECT_EQ(why(fresh), "");
  EXPECT_EQ(read_file(".", fresh), "old");
  EXPECT_EQ(why(""), "");
  EXPECT_EQ(why("-"), "");
  const std::string nowhere = (folder / "no" / "such.json").string();
  EXPECT_EQ(why(nowhere), "--json: cannot write '" + nowhere + "': No such file or directory");
  EXPECT_EQ(why(folder.string()), "--json: cannot write '" + folder.string() + "': Is a directory");
  OutputFile(".", fresh, Readers::kAsUsual, Content::kBinary).write("\x01\x02");
  EXPECT_NE(why(fresh).find("is no text"), std::string::npos);
  std::filesystem::remove_all(folder);
}

TEST(Files, AllStepsAreDoneAndTheFirstFailureIsTold) {
  std::string done;
  const auto step = [&done](char c) { return [&done, c] { done += c; }; };
  const auto failing = [&done](char c) {
    return [&done, c] {
      done += c;
      throw UserError(std::string(1, c));
    };
  };
  do_all({step('a'), step('b')});
  EXPECT_EQ(done, "ab");
  try {
    do_all({failing('c'), step('d'), failing('e')});
    FAIL() << "nothing thrown";
  } catch (const UserError& e) {
    EXPECT_STREQ(e.what(), "c");
  }
  EXPECT_EQ(done, "abcde");
}

// Once, `padr-lab sweep --summary /dev/full` put a file in the place of the device.
TEST(Files, OnlyTextIsReplacedAndNotTheLinkToIt) {
  const auto folder = std::filesystem::temp_directory_path() / "padr-replace-test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder / "kept");
  const auto place = [&](const std::string& name) { return (folder / name).string(); };
  const auto refused = [](const std::string& path) {
    try {
      replaceable("--csv", path);
    } catch (const UserError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  write_text(".", place("kept/rows"), "a,b\n");
  std::filesystem::create_symlink("kept/rows", folder / "link");
  EXPECT_EQ(replaceable("--csv", place("link")), std::filesystem::weakly_canonical(folder / "kept/rows"));
  std::filesystem::create_symlink("not yet", folder / "kept/dangling");
  std::filesystem::create_symlink("kept/dangling", folder / "twice");
  EXPECT_EQ(replaceable("--csv", place("twice")), std::filesystem::weakly_canonical(folder / "kept/not yet"));
  EXPECT_EQ(replaceable("--csv", place("new")), std::filesystem::weakly_canonical(folder / "new"));
  OutputFile(".", place("trace"), Readers::kAsUsual, Content::kBinary).write(std::string_view("PADRTRC\x09\x01"));
  EXPECT_TRUE(refused(place("trace")).starts_with("--csv: '" + place("trace") + "' is no text"));
  EXPECT_TRUE(refused("/dev/null").starts_with("--csv: '/dev/null' is no regular file"));
  EXPECT_TRUE(refused(place("kept")).starts_with("--csv: '" + place("kept") + "' is no regular file"));
  EXPECT_TRUE(refused("-").starts_with("--csv: this cannot be printed"));
  std::filesystem::remove_all(folder);
}

// One refused joiner's trace once made a folder of traces useless for the page and for audits.
TEST(Files, OfSeveralRecordingsTheEmptyOnesAreLeftOut) {
  const auto folder = std::filesystem::temp_directory_path() / "padr-empty-test";
  std::filesystem::create_directories(folder);
  const auto file = [&folder](const char* name) { return (folder / name).string(); };
  for (const char* name : {"full", "empty", "none"})
    OutputFile(".", file(name), Readers::kAsUsual, Content::kBinary).write(std::string_view(name[0] == 'f' ? "x" : ""));
  std::vector<std::string> said;
  const auto note = [&said](const std::string& text) { said.push_back(text); };
  using Files = std::vector<std::string>;
  EXPECT_EQ(without_empty({file("full"), file("empty")}, note), (Files{file("full")}));
  EXPECT_EQ(said, (Files{file("empty") + ": is empty: left out"}));
  EXPECT_EQ(without_empty({file("empty"), file("none")}, note), (Files{file("empty"), file("none")}));
  EXPECT_EQ(without_empty({file("full"), file("empty"), file("missing")}, note).size(), 3U);
  EXPECT_EQ(said.size(), 1U);
  std::filesystem::remove_all(folder);
}

TEST(Files, ATextTakesTheOldOnesPlaceOrLeavesIt) {
  const auto folder = std::filesystem::temp_directory_path() / "padr-replace-whole-test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const std::string file = folder / "rows";
  write_text(".", file, "old\n");
  const std::string nowhere = (folder / "no" / "rows").string();
  try {
    replace_text("--health", nowhere, "x");
    FAIL() << "nothing thrown";
  } catch (const UserError& e) {
    EXPECT_EQ(std::string(e.what()),
              "--health: cannot write '" + nowhere + "': there is no folder " + (folder / "no").string());
  }
  std::filesystem::create_directories(folder / "rows.part");  // in the way
  EXPECT_THROW(replace_text("--csv", file, "new\n"), UserError);
  EXPECT_EQ(read_file(".", file), "old\n");
  std::filesystem::remove_all(folder / "rows.part");
  replace_text("--csv", file, "new\n");
  EXPECT_EQ(read_file(".", file), "new\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "rows.part"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace padr::shell
