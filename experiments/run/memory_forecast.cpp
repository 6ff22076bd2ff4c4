#include "experiments/run/memory_forecast.h"

#include "accel/registry.h"
#include "framework/core/counters.h"
#include "framework/core/memory.h"
#include "framework/core/units.h"
#include "integrators/method_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace etendue {

double MemoryForecast::bytes() const {
  double sum = 0;
  for (const MemoryPart& part : parts) sum += part.bytes;
  return sum;
}

std::string MemoryForecast::text() const {
  auto taken = parts | std::views::filter([](const MemoryPart& part) { return part.bytes > 0; });
  return joined(taken, ", ", [](const MemoryPart& part) { return part.name + " " + format_bytes(part.bytes); });
}

MemoryForecast forecast_memory(const Scene& scene, const SceneNeeds& needs, const Method& accel, const Method& integrator,
                               ivec2 resolution) {
  constexpr double bytes_a_pixel = 80;  // of sums with weights, their mean and its copy
  const double pixels = static_cast<double>(resolution.x) * resolution.y;
  const MethodMemory method = method_memory(integrator.name, integrator.params, needs, resolution);
  ParamMap params = accel.params;
  params.erase("memory");
  params.erase("over_memory");
  const MemoryNeed need = find_ray_structure(accel.name, accel.where).need(scene, params);
  const double image = bytes_a_pixel * pixels, later = image + method.photons + method.pixels;
  const double structure = std::max(static_cast<double>(need.kept), static_cast<double>(need.peak) - later);
  const std::string fewer_pixels = "fewer pixels";
  return {{{"program and scene", static_cast<double>(resident_memory_bytes())},
           {"structure", structure,
            accel.name == "brute" ? "" : "a structure that takes less (`etendue accel SCENE` shows what each takes)"},
           {"image", image, fewer_pixels},
           {"photons", method.photons, fmt::format("fewer photons than {}", format_count(method.photon_count))},
           {"what " + integrator.name + " keeps of pixels", method.pixels, fewer_pixels}}};
}

void refuse_over_memory(const std::string& what, const Scene& scene, const SceneNeeds& needs, const Method& accel,
                        const Method& integrator, ivec2 resolution) {
  const std::uint64_t limit = memory_limit();
  if (limit == 0) return;
  const MemoryForecast forecast = forecast_memory(scene, needs, accel, integrator, resolution);
  if (forecast.bytes() <= static_cast<double>(limit)) return;
  const MemoryPart* largest = nullptr;
  for (const MemoryPart& part : forecast.parts)
    if (!part.leaner.empty() && (largest == nullptr || part.bytes > largest->bytes)) largest = &part;
  if (forecast.parts[0].bytes > static_cast<double>(limit)) largest = nullptr;
  throw Error(Location{"--memory"},
              fmt::format("{} needs about {} ({}), and {} are allowed; expected {}, or more memory", what,
                          format_bytes(forecast.bytes()), forecast.text(), format_bytes(static_cast<double>(limit)),
                          largest != nullptr && largest->bytes > 0 ? largest->leaner : "a smaller scene"));
}

void require_room_for_photons(const SceneNeeds& needs, const Method& integrator, ivec2 resolution) {
  constexpr double surely_stored = 0.1;  // of those emitted: in open scenes most leave, and a caustic map keeps few
  const MethodMemory method = method_memory(integrator.name, integrator.params, needs, resolution);
  require_memory(surely_stored * method.photons, integrator.where,
                 fmt::format("{}: room for a tenth of {} photons", integrator.name, format_count(method.photon_count)),
                 "fewer photons, or more memory");
}

void fail_over_memory(std::uint64_t iterations) {
  const std::uint64_t limit = memory_limit();
  if (limit == 0) return;
  const std::uint64_t taken = peak_memory_bytes();
  if (taken <= limit) return;
  throw std::runtime_error(
      fmt::format("--memory: {} were taken {}, and {} are allowed: more was needed than foreseen, and no image is changed to "
                  "save memory",
                  format_bytes(static_cast<double>(taken)),
                  iterations == 0 ? "in preparation" : fmt::format("after {} iterations", iterations),
                  format_bytes(static_cast<double>(limit))));
}

}  // namespace etendue
