// What is written over what.
#include "shell/files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <string_view>

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

}  // namespace
}  // namespace padr::shell
