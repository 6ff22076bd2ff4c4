// TOML, as a tree of values with their places.
#include "experiments/config/config_tree.h"
#include "tests/fuzz/fuzz_input.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace etendue;
  return fuzz::expect_read_or_refused([&] { (void)canonical_text(parse_config(fuzz::text_of(data, size), "e.toml")); });
}
