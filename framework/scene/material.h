// Materials as data; what light does at them is transport/bsdf.h.
#pragma once

#include "framework/scene/texture.h"

#include <string>
#include <string_view>
#include <variant>

namespace etendue {

struct Diffuse {
  TexturedRgb reflectance{Rgb(0.5f)};  // on both sides
};

// GGX alpha = roughness (no remapping); 0 in both: a perfect mirror. `eta` and `k` relative to the outside, per channel.
// With `k` 0 and `eta` 1 the Fresnel factor would be 0, so a perfect mirror of given colour uses `tint` with `ideal`.
struct Conductor {
  Rgb eta{1}, k{0};
  Rgb tint{1};         // multiplies the Fresnel factor
  bool ideal = false;  // Fresnel factor 1
  vec2 alpha{0};
};

// eta: inside over outside, the outside being where the geometric normal points.
struct Dielectric {
  float eta = 1.5f;
  float alpha = 0;
  Rgb reflect_tint{1}, transmit_tint{1};
};

// A diffuse base under a smooth or rough dielectric coat: the base is lit and seen through the coat's Fresnel transmission,
// with the light reflected back inside summed as a geometric series. Lossless for albedo 1 when smooth; a rough coat keeps the
// smooth one's transmission. (pbrt-v4's coateddiffuse walks the layers at random instead.)
struct Plastic {
  TexturedRgb reflectance{Rgb(0.5f)};
  float eta = 1.5f;
  float alpha = 0;
};

using Material = std::variant<Diffuse, Conductor, Dielectric, Plastic>;

// Can light be reflected or refracted into a delta direction? (A smooth plastic can.)
bool has_specular(const Material& material);
// Is there a lobe that is not a delta?
bool has_non_specular(const Material& material);
// Does it depend on texture coordinates, or on the tangent along them? (Textures and anisotropic lobes do.)
bool uses_uvs(const Material& material);

}  // namespace etendue
