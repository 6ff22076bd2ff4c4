// OpenEXR images, with their attributes.
#include "framework/io/image/exr.h"
#include "tests/fuzz/fuzz_input.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace etendue;
  return fuzz::expect_read_or_refused([&] {
    std::map<std::string, std::string> attributes;
    (void)parse_exr(fuzz::text_of(data, size), "i.exr", &attributes);
  });
}
