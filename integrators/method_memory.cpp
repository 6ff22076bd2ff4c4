#include "integrators/method_memory.h"

#include "integrators/registry.h"

#include <algorithm>

namespace etendue {

namespace {

constexpr double bytes_a_photon = 150;  // emitted, of which 0.9 to 2 are stored

class Parameters {
 public:
  Parameters(const IntegratorEntry& entry, const ParamMap& given) : entry_(entry), given_(given) {}

  bool has(const std::string& name) const {
    return std::ranges::any_of(entry_.params, [&](const ParamInfo& info) { return info.name == name; });
  }
  std::string text(const std::string& name) const {
    if (const auto found = given_.find(name); found != given_.end()) return to_text(found->second);
    for (const ParamInfo& info : entry_.params)
      if (info.name == name) return info.default_value;
    return "";
  }
  // 0 where there is none.
  double number(const std::string& name) const {
    const ParamValue value = parse_param_value(text(name), {});
    if (const auto* whole = std::get_if<std::int64_t>(&value.value)) return static_cast<double>(*whole);
    if (const auto* real = std::get_if<double>(&value.value)) return *real;
    return 0;
  }

 private:
  const IntegratorEntry& entry_;
  const ParamMap& given_;
};

// Emitted for the maps that stand at a time, where a number is not given as the methods choose it.
double photons_of(const std::string& method, const Parameters& parameters, const SceneNeeds& needs, double pixels) {
  double photons = parameters.number("photons");
  if (photons == 0 && parameters.has("photons_per_pixel")) {
    const double given = parameters.number("photons_per_pixel");
    photons = std::max(20000.0, pixels * (given > 0 ? given : needs.caustic_map ? 1 : 2.5));
  } else if (photons == 0 && parameters.has("photons")) {
    photons = method == "photon-cache" ? std::clamp(32 * pixels, 200000.0, 600000.0) : 200000;
  }
  const std::string map = parameters.text("caustic_map");
  const double caustic = parameters.number("caustic_photons");
  const bool seen_directly = method == "photon-map" && parameters.number("final_gather") == 0 && caustic == 0;
  if (map == "on" || (map == "auto" && needs.caustic_map && !seen_directly)) {
    const bool stays = method == "photon-map" || parameters.text("retrace") == "false";
    const double usual = stays ? 200000 : std::max({20000.0, 800 * parameters.number("k"), 3 * pixels});
    photons += 0.5 * (caustic > 0 ? caustic : usual);  // most of them miss what is specular
  }
  return photons;
}

}  // namespace

MethodMemory method_memory(const std::string& integrator, const ParamMap& params, const SceneNeeds& needs, ivec2 resolution) {
  const double pixels = static_cast<double>(resolution.x) * resolution.y;
  MethodMemory memory;
  if (integrator == "auto") {
    for (const char* chosen : {"sppm", "photon-cache", "hash-cache", "irradiance-cache", "bdpt"}) {
      const MethodMemory one = method_memory(chosen, {}, needs, resolution);
      if (one.photons + one.pixels > memory.photons + memory.pixels) memory = one;
    }
    return memory;
  }
  const IntegratorEntry& entry = find_integrator(integrator, {});
  memory.photon_count = photons_of(integrator, {entry, params}, needs, pixels);
  memory.photons = bytes_a_photon * memory.photon_count;
  memory.pixels = entry.bytes_a_pixel * pixels;
  return memory;
}

}  // namespace etendue
