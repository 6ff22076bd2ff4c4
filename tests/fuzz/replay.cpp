// Feeds a driver what libFuzzer would: each file of the folders that are named, its beginnings, and the file with one bit
// flipped.
#include "tests/fuzz/fuzz_input.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

namespace {

void feed(const std::vector<std::uint8_t>& bytes) {
  // A copy of the exact size: a sanitizer sees what is read past its end.
  const std::vector<std::uint8_t> copy(bytes.begin(), bytes.end());
  LLVMFuzzerTestOneInput(copy.data(), copy.size());
}

std::size_t replay(const std::filesystem::path& file) {
  constexpr std::size_t changes = 64;
  std::ifstream in(file, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
  feed(bytes);
  std::size_t inputs = 1;
  const std::size_t step = std::max<std::size_t>(1, bytes.size() / changes);
  for (std::size_t i = 0; i < bytes.size(); i += step, inputs += 2) {
    feed({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(i)});
    const auto bit = static_cast<std::uint8_t>(1u << (i / step % 8));
    bytes[i] ^= bit;
    feed(bytes);
    bytes[i] ^= bit;
  }
  return inputs;
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t files = 0, inputs = 0;
  for (int i = 1; i < argc; ++i)
    for (const auto& entry : std::filesystem::recursive_directory_iterator(argv[i]))
      if (entry.is_regular_file()) {
        inputs += replay(entry.path());
        ++files;
      }
  std::printf("%zu files, %zu inputs\n", files, inputs);
  return files > 0 ? 0 : 1;
}
