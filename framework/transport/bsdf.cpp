#include "framework/transport/bsdf.h"

namespace etendue {

namespace {

// Becomes what `make` returns, made where it is wanted: a copy of what was just stored piece by piece would wait for it.
template <class Make>
struct MadeInPlace {
  const Make& make;

  operator std::invoke_result_t<const Make&>() const { return make(); }
};

}  // namespace

Bsdf::AnyPlaced Bsdf::place(const Scene& scene, const SurfacePoint& point) {
  const auto colour = [&](const TexturedRgb& c) { return etendue::evaluate(c, scene.textures, point.uv); };
  return std::visit(
      [&](const auto& material) {
        const auto made = [&] { return place_lobes<float>(material, point, colour); };
        return AnyPlaced(std::in_place_type<decltype(made())>, MadeInPlace<decltype(made)>{made});
      },
      scene.materials[point.material]);
}

Bsdf::Bsdf(const Scene& scene, const SurfacePoint& point)
    : placed_(place(scene, point)),
      has_specular_(etendue::has_specular(scene.materials[point.material])),
      has_non_specular_(etendue::has_non_specular(scene.materials[point.material])) {}

Rgb Bsdf::diffuse_albedo() const {
  const auto* diffuse = std::get_if<Placed<Diffuse>>(&placed_);
  return diffuse ? diffuse->lobes.albedo : Rgb(0);
}

Rgb Bsdf::evaluate(const vec3& wo, const vec3& wi, TransportMode mode) const {
  return std::visit([&](const auto& placed) { return placed.evaluate(wo, wi, mode); }, placed_);
}
float Bsdf::pdf(const vec3& wo, const vec3& wi) const {
  return std::visit([&](const auto& placed) { return placed.pdf(wo, wi); }, placed_);
}
BsdfPair Bsdf::pair(const vec3& wo, const vec3& wi, TransportMode mode) const {
  return std::visit([&](const auto& placed) { return placed.pair(wo, wi, mode); }, placed_);
}
BsdfSample Bsdf::sample(const vec3& wo, float u_lobe, const vec2& u, TransportMode mode) const {
  return std::visit([&](const auto& placed) { return placed.sample(wo, u_lobe, u, mode); }, placed_);
}

}  // namespace etendue
