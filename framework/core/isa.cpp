#include "framework/core/isa.h"

#include "framework/core/check.h"

#include <algorithm>
#include <array>
#include <vector>

namespace etendue {

namespace {

struct IsaNames {
  std::string_view name, option;
};
constexpr std::array<IsaNames, 4> names{{{"scalar", "scalar"}, {"SSE4.1", "sse"}, {"AVX2", "avx2"}, {"AVX-512", "avx512"}}};

Isa& choice() {
  static Isa isa = supported_isas().back();
  return isa;
}

}  // namespace

std::string_view isa_name(Isa isa) { return names[static_cast<std::size_t>(isa)].name; }
std::string_view isa_option(Isa isa) { return names[static_cast<std::size_t>(isa)].option; }

Isa isa_of_option(std::string_view option) {
  const auto found = std::find_if(names.begin(), names.end(), [&](const IsaNames& n) { return n.option == option; });
  CHECK(found != names.end());
  return static_cast<Isa>(found - names.begin());
}

bool is_supported(Isa isa) { return std::ranges::count(supported_isas(), isa) > 0; }

std::span<const Isa> supported_isas() {
  static const std::vector<Isa> supported = [] {
    std::vector<Isa> isas{Isa::scalar};
#if defined(__x86_64__)
    if (__builtin_cpu_supports("sse4.1")) isas.push_back(Isa::sse);
    if (__builtin_cpu_supports("avx2")) isas.push_back(Isa::avx2);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
        __builtin_cpu_supports("avx512bw"))
      isas.push_back(Isa::avx512);
#endif
    return isas;
  }();
  return supported;
}

Isa chosen_isa() { return choice(); }

void choose_isa(Isa isa) {
  CHECK(is_supported(isa));
  choice() = isa;
}

}  // namespace etendue
