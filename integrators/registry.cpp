#include "integrators/registry.h"

#include "integrators/appm.h"
#include "integrators/cppm.h"
#include "integrators/guided.h"
#include "integrators/hash_cache.h"
#include "integrators/irradiance_cache.h"
#include "integrators/path.h"
#include "integrators/photon_cache.h"
#include "integrators/photon_map.h"
#include "integrators/ppm_memoryless.h"
#include "integrators/radiance_cache.h"
#include "integrators/sppm.h"
#include "integrators/vcm.h"

namespace etendue {

std::span<const IntegratorEntry> integrators() {
  static const std::vector<IntegratorEntry> table = {
      path_entry(), light_trace_entry(),    bdpt_entry(),       photon_map_entry(),     ppm_entry(),
      sppm_entry(), ppm_memoryless_entry(), appm_entry(),       cppm_entry(),           irradiance_cache_entry(),
      vcm_entry(),  guided_entry(),         hash_cache_entry(), radiance_cache_entry(), photon_cache_entry(),
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
