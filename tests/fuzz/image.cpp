// PNG, JPEG, TGA and HDR images.
#include "framework/io/image/image_file.h"
#include "tests/fuzz/fuzz_input.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace etendue;
  return fuzz::expect_read_or_refused(
      [&] { (void)decode_image(fuzz::text_of(data, size), "i", size % 2 == 0 ? Encoding::srgb : Encoding::linear); });
}
