#include "framework/scenes/exact_stage.h"

#include "framework/core/check.h"

namespace etendue {

ExactStage::ExactStage(std::string name) : builder(std::move(name)), black_(builder.material(Diffuse{Rgb(0)})) {}

void ExactStage::add(const MeshData& quad, Radiance front, double mirror) {
  CHECK_EQ(quad.positions.size(), 4u);
  const dvec3 a(quad.positions[0]), u = dvec3(quad.positions[1]) - a, v = dvec3(quad.positions[3]) - a;
  CHECK(std::abs(glm::dot(u, v)) < 1e-6 * glm::length(u) * glm::length(v));
  sides_.push_back({a, u, v, glm::normalize(glm::cross(u, v)), std::move(front), mirror});
}

void ExactStage::reflector(const MeshData& quad, std::uint32_t material, Radiance front) {
  builder.mesh(quad, material);
  add(quad, std::move(front));
}

void ExactStage::glowing_reflector(const MeshData& quad, std::uint32_t material, const Rgb& emitted, Radiance front) {
  builder.mesh(quad, material, emitted);
  add(quad, std::move(front));
}

void ExactStage::emitter(const MeshData& quad, const Rgb& radiance, std::uint32_t material) {
  builder.mesh(quad, material, radiance);
  add(quad, [radiance](const dvec3&) { return dvec3(radiance); });
}

void ExactStage::blocker(const MeshData& quad) {
  builder.mesh(quad, black_);
  add(quad, {});
}

void ExactStage::mirror(const MeshData& quad, float reflectance) {
  builder.mesh(quad, builder.material(Conductor{.tint = Rgb(reflectance), .ideal = true}));
  add(quad, {}, reflectance);
}

void ExactStage::veil(const MeshData& quad) { builder.mesh(quad, builder.material(Dielectric{.eta = 1})); }

dvec3 ExactStage::radiance(const std::vector<Side>& sides, const dvec3& origin, const dvec3& direction, int reflections) {
  const Side* nearest = nullptr;
  double t_nearest = std::numeric_limits<double>::infinity();
  for (const Side& side : sides) {
    const double t = glm::dot(side.corner - origin, side.normal) / glm::dot(direction, side.normal);
    if (!(t > 1e-9 && t < t_nearest)) continue;
    const dvec3 p = origin + t * direction - side.corner;
    const double along_u = glm::dot(p, side.u) / glm::dot(side.u, side.u),
                 along_v = glm::dot(p, side.v) / glm::dot(side.v, side.v);
    if (along_u < 0 || along_u > 1 || along_v < 0 || along_v > 1) continue;
    nearest = &side;
    t_nearest = t;
  }
  if (!nearest) return dvec3(0);
  const dvec3 point = origin + t_nearest * direction;
  const double cosine = glm::dot(direction, nearest->normal);
  if (nearest->mirror > 0 && reflections > 0)
    return nearest->mirror * radiance(sides, point, direction - 2 * cosine * nearest->normal, reflections - 1);
  return nearest->front && cosine < 0 ? nearest->front(point) : dvec3(0);
}

Scene ExactStage::finish(std::string source) {
  constexpr int most_reflections = 8;
  builder.closed_form(std::move(source), [sides = sides_](const Ray& ray) {
    return radiance(sides, dvec3(ray.origin), glm::normalize(dvec3(ray.direction)), most_reflections);
  });
  return builder.finish();
}

}  // namespace etendue
