// Logs of runs (runs.jsonl), read from a file that lives in memory. Every line that could be a record is given the checksum
// that its bytes have: what is to be tried lies behind it.
#include "experiments/log/log.h"
#include "tests/fuzz/fuzz_input.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

namespace {

std::string with_checksums(const std::string& text) {
  std::string sealed_text;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    sealed_text += line.ends_with('}') ? etendue::sealed(line) : line;
    if (end < text.size()) sealed_text += '\n';
    begin = end + 1;
  }
  return sealed_text;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace etendue;
  static const int file = ::memfd_create("runs.jsonl", MFD_CLOEXEC);
  static const std::string path = "/proc/self/fd/" + std::to_string(file);
  const std::string text = with_checksums(fuzz::text_of(data, size));
  const auto written = static_cast<ssize_t>(text.size());
  if (file < 0 || ::ftruncate(file, 0) != 0 || ::pwrite(file, text.data(), text.size(), 0) != written) std::abort();
  return fuzz::expect_read_or_refused([&] { (void)read_log(path); });
}
