// Experiments: TOML whose every key is checked.
#include "experiments/config/config.h"
#include "tests/fuzz/fuzz_input.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace etendue;
  return fuzz::expect_read_or_refused([&] { (void)parse_experiment(fuzz::text_of(data, size), "e.toml", {}); });
}
