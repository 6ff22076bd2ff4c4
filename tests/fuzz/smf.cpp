// SMF meshes.
#include "framework/io/mesh/smf.h"
#include "tests/fuzz/fuzz_input.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace etendue;
  return fuzz::expect_read_or_refused([&] { (void)parse_smf(fuzz::text_of(data, size), "m.smf"); });
}
