// Runs the `etendue` program as its users do.
#pragma once

#include "tests/places.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

namespace etendue {

inline std::string read_text_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline bool is_installed(const std::string& program) {
  return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
}

struct Outcome {
  int status = -1;  // exit status, or -signal
  std::string out, err;
};

// A directory of its own for each test, in which the program runs, its cache included.
class ProgramTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    directory_ = std::filesystem::temp_directory_path() /
                 (std::string("etendue-") + info->test_suite_name() + "-" + info->name() + "-" + std::to_string(getpid()));
    std::filesystem::remove_all(directory_);
    std::filesystem::create_directories(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  pid_t start(const std::vector<std::string>& arguments) {
    const pid_t pid = fork();
    if (pid != 0) return pid;
    std::filesystem::current_path(directory_);
    if (in_child_) in_child_();
    setenv("XDG_CACHE_HOME", (directory_ / "cache").c_str(), 1);
    for (const auto& [name, descriptor] : {std::pair("stdout.txt", STDOUT_FILENO), std::pair("stderr.txt", STDERR_FILENO)})
      dup2(open(name, O_WRONLY | O_CREAT | O_TRUNC, 0644), descriptor);
    std::vector<char*> argv{const_cast<char*>("etendue")};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    execv(program_path, argv.data());
    _exit(127);
  }

  Outcome finish(pid_t pid) {
    int status = 0;
    waitpid(pid, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), read_text_file(directory_ / "stdout.txt"),
            read_text_file(directory_ / "stderr.txt")};
  }

  Outcome run(const std::vector<std::string>& arguments) { return finish(start(arguments)); }

  void write_file(const std::string& name, const std::string& text) { std::ofstream(directory_ / name) << text; }

  std::filesystem::path directory_;
  std::function<void()> in_child_;  // before the program begins: limits, environment
};

}  // namespace etendue
