// The traces of a peer: a file for each incarnation, which holds what its last beginning has recorded, and nothing
// before.
#include "peer/recordings.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <string_view>

#include "shell/files.h"

namespace padr::peer {
namespace {

void record(Recordings& recordings, int incarnation, std::string_view text) {
  const auto recording = recordings.of(incarnation);
  ASSERT_TRUE(recording);
  recording->sink(std::as_bytes(std::span(text)));
}

// A joiner that took too long to catch up began anew, and its trace had two beginnings.
TEST(Recordings, AnIncarnationThatBeginsAnewWritesItsFileAnew) {
  const auto folder = std::filesystem::temp_directory_path() / "padr-recordings-test";
  std::filesystem::create_directories(folder);
  Options options;
  options.trace = (folder / "peer.trace").string();
  Log log(options.log_level, options.log_levels);
  Recordings recordings(options, log);
  record(recordings, 0, "got nowhere");
  record(recordings, 0, "second");
  record(recordings, 1, "got nowhere, too");
  record(recordings, 1, "third");
  recordings.close();
  EXPECT_EQ(shell::read_file("", options.trace, 1000), "second");
  EXPECT_EQ(shell::read_file("", (folder / "peer.2.trace").string(), 1000), "third");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace padr::peer
