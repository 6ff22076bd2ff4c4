// Mitsuba's serialized meshes.
#include "framework/io/mesh/serialized.h"
#include "tests/fuzz/fuzz_input.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace etendue;
  return fuzz::expect_read_or_refused([&] { (void)parse_serialized(fuzz::text_of(data, size), "m.serialized", 0); });
}
