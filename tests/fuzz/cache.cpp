// Caches on disk: the bytes as a whole file, and as what a file with a right checksum holds: its records.
#include "integrators/caches/records/cache_file.h"
#include "integrators/caches/records/record_file.h"
#include "tests/fuzz/fuzz_input.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace etendue;
  const std::string bytes = fuzz::text_of(data, size);
  const Location where{"c.cache"};
  fuzz::expect_read_or_refused([&] { (void)open_cache_file(bytes, where); });
  return fuzz::expect_read_or_refused([&] {
    const std::string whole =
        make_cache_file({.integrator = "irradiance-cache", .scene = "s", .params = {{"samples", "32"}}}, bytes);
    ByteReader in(open_cache_file(whole, where).body, where);
    CacheStanding().read(in);
    (void)read_levels<IrradianceEstimate>(in, size % 2 == 0, IrradianceEstimate{});
  });
}
