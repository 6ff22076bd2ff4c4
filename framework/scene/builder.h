// Builds a Scene shape by shape in code, as the built-in scenes do.
#pragma once

#include "framework/scene/scene.h"

#include <optional>
#include <vector>

namespace etendue {

struct MeshData {
  std::vector<vec3> positions;
  std::vector<uvec3> triangles;
  std::vector<vec3> normals;  // per vertex, or empty
  std::vector<vec2> uvs;      // per vertex, or empty
};

// Corners in order around the rectangle; its normal is cross(b - a, d - a).
MeshData quad(const vec3& a, const vec3& b, const vec3& c, const vec3& d);
// Normals point outward.
MeshData box(const vec3& lower, const vec3& upper);
MeshData transformed(MeshData mesh, const Transform& transform);

class SceneBuilder {
 public:
  explicit SceneBuilder(std::string name) { scene_.name = std::move(name); }

  std::uint32_t material(Material material);
  void mesh(const MeshData& mesh, std::uint32_t material, const std::optional<Rgb>& emitted = std::nullopt);
  // `inward`: the normal points to the inside.
  void quadric(const Quadric& quadric, std::uint32_t material, const std::optional<Rgb>& emitted = std::nullopt,
               bool inward = false);
  void plane(const InfinitePlane& plane) { scene_.planes.push_back(plane); }
  void light(Light light) { scene_.lights.push_back(std::move(light)); }
  void camera(const vec3& eye, const vec3& target, float fov_degrees, ivec2 resolution, const vec3& up = {0, 1, 0});
  void max_depth(int scattering_events) { scene_.max_depth = scattering_events; }
  void closed_form(std::string source, std::function<dvec3(const Ray&)> radiance);

  Scene finish();

 private:
  struct PendingQuadric {
    Quadric quadric;
    std::uint32_t material;
    std::optional<Rgb> emitted;
    bool inward;
  };

  Scene scene_;
  std::vector<Emission> emissions_;
  std::vector<PendingQuadric> quadrics_;  // their ids follow the last triangle's
};

}  // namespace etendue
