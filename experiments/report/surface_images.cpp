#include "experiments/report/surface_images.h"

#include "framework/core/check.h"
#include "framework/core/parallel.h"

#include <algorithm>

namespace etendue {

namespace {

constexpr int rays_across = 4;  // of a pixel, where a mean is taken

// Of the surface that a material is part of, for light along its normal.
struct AlbedoStraightOn {
  const std::vector<Texture>& textures;
  const vec2& uv;

  Rgb operator()(const Diffuse& m) const { return evaluate(m.reflectance, textures, uv); }
  Rgb operator()(const Conductor& m) const { return m.ideal ? m.tint : m.tint * fresnel_conductor(1.0f, m.eta, m.k); }
  Rgb operator()(const Dielectric& m) const {
    return glm::mix(m.transmit_tint, m.reflect_tint, fresnel_dielectric(1.0f, m.eta));
  }
  // The integral of Plastic's base over all directions: (1 - the average of Fresnel's factor) / eta^2 is what is not reflected
  // back inside.
  Rgb operator()(const Plastic& m) const {
    const Rgb base = evaluate(m.reflectance, textures, uv);
    const float coat = fresnel_dielectric(1.0f, m.eta), inside = m.eta.internal_reflectance();
    return coat + (1 - coat) * (1 - inside) * base / (1.0f - inside * base);
  }
};

struct SeenSurface {
  const Scene& scene;
  const Ray& ray;
  const Hit& hit;
  const SurfacePoint& point;
};

dvec3 albedo_of(const SeenSurface& s) {
  return dvec3(std::visit(AlbedoStraightOn{s.scene.textures, s.point.uv}, s.scene.materials[s.point.material]));
}
dvec3 normal_of(const SeenSurface& s) {
  return dvec3(glm::dot(s.point.normal, s.ray.direction) > 0 ? -s.point.shading_normal : s.point.shading_normal);
}
dvec3 position_of(const SeenSurface& s) { return dvec3(s.point.position) + dvec3(s.scene.origin); }
dvec3 depth_of(const SeenSurface& s) { return dvec3(s.hit.t); }
dvec3 primitive_of(const SeenSurface& s) {
  if (s.hit.instance == plane_instance) return {s.hit.primitive, -2, -2};
  return {s.hit.primitive, s.hit.instance, s.scene.instances[s.hit.instance].object};
}
dvec3 material_number_of(const SeenSurface& s) { return dvec3(s.point.material); }

struct SurfaceImage {
  dvec3 (*value)(const SeenSurface&);
  double nothing;  // where nothing is seen
  bool is_mean;
};
const std::string surface_names[] = {"albedo", "normal", "position", "depth", "primitive", "material"};
constexpr SurfaceImage surface_images[] = {{albedo_of, 0, true},      {normal_of, 0, true},
                                           {position_of, 0, false},   {depth_of, infinity, false},
                                           {primitive_of, -1, false}, {material_number_of, -1, false}};

dvec3 seen_at(const SurfaceImage& image, const RenderContext& context, const vec2& film) {
  const Ray ray = context.scene.camera.ray(context.resolution, film, vec2(0.5f));
  const Hit hit = context.rays.closest(ray);
  if (!hit) return dvec3(image.nothing);
  return image.value({context.scene, ray, hit, context.scene.surface_at(ray, hit)});
}

}  // namespace

std::span<const std::string> surface_image_names() { return surface_names; }

bool is_surface_image(const std::string& name) { return std::ranges::find(surface_names, name) != std::end(surface_names); }

Image draw_surface_image(const std::string& name, const RenderContext& context) {
  CHECK(is_surface_image(name));
  const SurfaceImage& kind = surface_images[std::ranges::find(surface_names, name) - std::begin(surface_names)];
  const int across = kind.is_mean ? rays_across : 1;
  Image image(context.resolution);
  parallel_pixels(context.resolution, [&](ivec2 pixel) {
    dvec3 sum(0);
    for (int i = 0; i < across * across; ++i) {
      const vec2 within = (vec2(i % across, i / across) + 0.5f) / static_cast<float>(across);
      sum += seen_at(kind, context, vec2(pixel) + within);
    }
    image.at(pixel.x, pixel.y) = sum / static_cast<double>(across * across);
  });
  return image;
}

}  // namespace etendue
