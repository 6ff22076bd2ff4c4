// pbrt scenes. They are confined to a folder that does not exist: no file of the disk is read.
#include "framework/io/pbrt/pbrt.h"
#include "tests/fuzz/fuzz_input.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace etendue;
  // What is refused otherwise is read on by approximation.
  return fuzz::expect_read_or_refused([&] {
    (void)parse_pbrt(fuzz::text_of(data, size), "/nonexistent-folder/s.pbrt", {.confined = true, .approximate = true});
  });
}
