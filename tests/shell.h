#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace padr::test {

/// What a user of a program sees of it.
struct Outcome {
  int status = -1;
  std::string out;
  std::string err;
};

/// A folder of its own for a test, gone afterwards, in which programs are run by the shell.
class Shell : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    dir_ = std::filesystem::path(testing::TempDir()) /
           (std::string("padr_") + info->test_suite_name() + "_" + info->name() + "_" + std::to_string(getpid()));
    std::filesystem::create_directories(dir_);
  }
  void TearDown() override { std::filesystem::remove_all(dir_); }

  std::string path(const std::string& name) const { return (dir_ / name).string(); }
  std::string read(const std::string& name) const {
    std::ifstream in(dir_ / name, std::ios::binary);
    std::stringstream s;
    s << in.rdbuf();
    return s.str();
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(dir_ / name, std::ios::binary) << text;
  }

  Outcome shell(const std::string& command) const {
    const std::string line = "cd '" + dir_.string() + "' && " + command + " >out 2>err";
    const int status = std::system(line.c_str());  // NOLINT(cert-env33-c): a test of what a shell user sees
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read("out"), read("err")};
  }

 private:
  std::filesystem::path dir_;
};

}  // namespace padr::test
