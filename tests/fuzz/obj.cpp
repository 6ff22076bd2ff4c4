// OBJ meshes.
#include "framework/io/mesh/obj.h"
#include "tests/fuzz/fuzz_input.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace etendue;
  return fuzz::expect_read_or_refused([&] {
    (void)parse_obj_parts(fuzz::text_of(data, size), "m.obj", true);
    (void)parse_obj(fuzz::text_of(data, size), "m.obj");
  });
}
