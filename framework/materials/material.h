// The materials that there are. A new one is a file of this room and a name in this variant.
#pragma once

#include "framework/materials/conductor.h"
#include "framework/materials/dielectric.h"
#include "framework/materials/diffuse.h"
#include "framework/materials/diffuse_transmission.h"
#include "framework/materials/plastic.h"

#include <variant>

namespace etendue {

using Material = std::variant<Diffuse, Conductor, Dielectric, Plastic, DiffuseTransmission>;

// Can light be reflected or refracted into a delta direction? (A smooth plastic can.)
inline bool has_specular(const Material& material) {
  return std::visit([](const auto& m) { return m.has_specular(); }, material);
}
// Is there a lobe that is not a delta?
inline bool has_non_specular(const Material& material) {
  return std::visit([](const auto& m) { return m.has_non_specular(); }, material);
}
// Does light go through to the other side?
inline bool transmits(const Material& material) {
  return std::visit([]<class M>(const M&) { return M::template Lobes<float>::transmits; }, material);
}
// Does it depend on texture coordinates, or on the tangent along them? (Textures and anisotropic lobes do.)
inline bool uses_uvs(const Material& material) {
  return std::visit([](const auto& m) { return m.uses_uvs(); }, material);
}

}  // namespace etendue
