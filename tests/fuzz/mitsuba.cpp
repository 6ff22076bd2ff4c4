// Mitsuba scenes. They are confined to a folder that does not exist: no file of the disk is read. What cannot be represented is
// approximated, so that more of the reader runs.
#include "framework/io/mitsuba/mitsuba.h"
#include "tests/fuzz/fuzz_input.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace etendue;
  return fuzz::expect_read_or_refused([&] {
    (void)parse_mitsuba(fuzz::text_of(data, size), "/nonexistent-folder/s.xml", {.confined = true, .approximate = true});
  });
}
