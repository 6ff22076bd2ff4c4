// Shared by the tests of readers.
#pragma once

#include "framework/core/error.h"
#include "framework/core/rng.h"
#include "framework/scene/scene.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

namespace etendue {

// A directory of the test's own, gone with it.
class TestDirectory {
 public:
  TestDirectory() {
    static int count = 0;
    path_ =
        std::filesystem::temp_directory_path() / ("etendue-io-" + std::to_string(::getpid()) + "-" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~TestDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TestDirectory(const TestDirectory&) = delete;
  TestDirectory& operator=(const TestDirectory&) = delete;

  std::string path(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::filesystem::remove(path_ / name);  // ext4 waits for the disk when a truncated file is closed
    std::ofstream(path_ / name, std::ios::binary) << bytes;
    return path(name);
  }
  std::size_t file_count() const {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) count += entry.is_regular_file();
    return count;
  }

 private:
  std::filesystem::path path_;
};

inline std::string slurp(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// The text of the Error that `call` throws; empty when it throws none.
template <class Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

inline ::testing::AssertionResult contains(const std::string& message, const std::string& expected) {
  if (message.find(expected) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "says '" << message << "', not '" << expected << "'";
}

inline bool warns(const Scene& scene, const std::string& text) {
  return std::any_of(scene.warnings.begin(), scene.warnings.end(),
                     [&](const std::string& w) { return w.find(text) != std::string::npos; });
}

#define EXPECT_ERROR(call, text) EXPECT_TRUE(contains(error_of([&] { (void)(call); }), text))

// Reads every beginning of `bytes`, then `flips` copies with one to four random bytes changed. A reader may accept or throw
// Error; anything else fails the test by escaping.
template <class Read>
void damage(const std::string& bytes, int flips, const Read& read) {
  for (std::size_t length = 0; length < bytes.size(); ++length) error_of([&] { read(bytes.substr(0, length)); });
  Pcg32 rng(7, 11);
  for (int i = 0; i < flips; ++i) {
    std::string damaged = bytes;
    for (std::uint32_t n = 1 + rng.next() % 4; n > 0; --n)
      damaged[rng.next() % damaged.size()] = static_cast<char>(rng.next() & 0xff);
    error_of([&] { read(damaged); });
  }
}

}  // namespace etendue
