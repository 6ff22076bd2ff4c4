#include "integrators/registry.h"

#include "integrators/bidirectional/vcm.h"
#include "integrators/caches/irradiance_cache.h"
#include "integrators/caches/photon_cache.h"
#include "integrators/caches/radiance_cache.h"
#include "integrators/choice/auto.h"
#include "integrators/guiding/guided.h"
#include "integrators/path_space/hash_cache.h"
#include "integrators/paths/path.h"
#include "integrators/photons/photon_map.h"
#include "integrators/progressive/methods.h"

namespace etendue {

std::span<const IntegratorEntry> integrators() {
  static const std::vector<IntegratorEntry> table = {
      path_entry(), light_trace_entry(),    bdpt_entry(),       photon_map_entry(),     ppm_entry(),
      sppm_entry(), ppm_memoryless_entry(), appm_entry(),       cppm_entry(),           irradiance_cache_entry(),
      vcm_entry(),  guided_entry(),         hash_cache_entry(), radiance_cache_entry(), photon_cache_entry(),
      auto_entry(),
  };
  return table;
}

const IntegratorEntry& find_integrator(const std::string& name, const Location& where) {
  std::vector<std::string> names;
  for (const IntegratorEntry& entry : integrators()) {
    if (entry.name == name) return entry;
    names.push_back(entry.name);
  }
  throw Error(where, unknown_name("integrator", name, names));
}

}  // namespace etendue
