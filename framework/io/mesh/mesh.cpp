#include "framework/io/mesh/mesh.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace {

// Unit, or zero where there is no direction. One that is unit as floats go stays as it is: read again it is the same.
vec3 unit_or_zero(const vec3& v) {
  const double length = glm::length(dvec3(v));
  if (std::abs(length - 1) <= 4 * 0x1p-24) return v;
  return length > 0 && std::isfinite(length) ? vec3(dvec3(v) / length) : vec3(0);
}

std::vector<dvec3> surrounding_normals(const TriangleMesh& mesh) {
  std::vector<dvec3> sums(mesh.positions.size(), dvec3(0));
  for (const uvec3& t : mesh.triangles) {
    const dvec3 p0(mesh.positions[t.x]), p1(mesh.positions[t.y]), p2(mesh.positions[t.z]);
    dvec3 normal = glm::cross(p1 - p0, p2 - p0);  // twice the area long
    const dvec3 side(mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z]);
    if (glm::dot(normal, side) < 0) normal = -normal;
    for (int i = 0; i < 3; ++i) sums[t[i]] += normal;
  }
  return sums;
}

// Counts what is not finite, and keeps which were the first ten.
class NotFinite {
 public:
  void add(std::size_t vertex) {
    if (count_++ < 10) first_ += fmt::format("{}{}", first_.empty() ? "" : ", ", vertex);
  }
  void warn(TriangleMesh& mesh, const std::string& name, std::string_view what) const {
    if (count_ > 0)
      mesh.warnings.push_back(fmt::format("{}: NaN or infinity in the {} of {} vertices, counted from 0: {}{}", name, what,
                                          count_, first_, count_ > 10 ? ", ..." : ""));
  }

 private:
  std::uint64_t count_ = 0;
  std::string first_;
};

void list_not_finite(TriangleMesh& mesh, const std::string& name) {
  NotFinite normals, uvs;
  for (std::size_t i = 0; i < mesh.normals.size(); ++i)
    if (!is_finite(mesh.normals[i])) normals.add(i);
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i)
    if (!std::isfinite(mesh.uvs[i].x) || !std::isfinite(mesh.uvs[i].y)) uvs.add(i);
  normals.warn(mesh, name, "normals (replaced by those of the faces)");
  uvs.warn(mesh, name, "texture coordinates (taken as 0)");
}

}  // namespace

void warn_of_concave_fans(TriangleMesh& mesh, std::span<const Fan> fans, const std::string& name) {
  const auto across = [&](std::size_t triangle) {
    const uvec3 t = mesh.triangles[triangle];
    const dvec3 p(mesh.positions[t.x]);
    return glm::cross(dvec3(mesh.positions[t.y]) - p, dvec3(mesh.positions[t.z]) - p);
  };
  const auto is_concave = [&](const Fan& fan) {
    dvec3 sum(0);
    for (std::size_t i = 0; i < fan.count; ++i) sum += across(fan.first + i);
    for (std::size_t i = 0; i < fan.count; ++i)
      if (glm::dot(across(fan.first + i), sum) < 0) return true;
    return false;
  };
  const auto concave = std::ranges::count_if(fans, is_concave) + std::ranges::count_if(mesh.quads, [&](std::uint32_t quad) {
                         return is_concave({quad, 2});
                       });
  if (concave > 0)
    mesh.warnings.push_back(
        fmt::format("{}: {} polygons are not convex; the triangles that they became cover more than they do. "
                    "Triangulate them",
                    name, concave));
}

void mend_attributes(TriangleMesh& mesh, const std::string& name) {
  list_not_finite(mesh, name);
  for (vec2& uv : mesh.uvs)
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) uv = vec2(0);
  for (vec3& n : mesh.normals) n = unit_or_zero(n);
  const auto unusable = std::count(mesh.normals.begin(), mesh.normals.end(), vec3(0));
  if (unusable == 0) return;
  if (static_cast<std::size_t>(unusable) == mesh.normals.size()) {
    mesh.normals.clear();
    return;
  }
  const std::vector<dvec3> sums = surrounding_normals(mesh);
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
    if (mesh.normals[i] != vec3(0)) continue;
    const double length = glm::length(sums[i]);
    mesh.normals[i] = length > 0 && std::isfinite(length) ? vec3(sums[i] / length) : vec3(0, 0, 1);
  }
}

void give_default_uvs(TriangleMesh& mesh) {
  if (!mesh.uvs.empty()) return;
  TriangleMesh apart{.positions = {}, .normals = {}, .uvs = {}, .triangles = {}, .warnings = std::move(mesh.warnings)};
  for (const uvec3& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(apart.positions.size());
    for (int i = 0; i < 3; ++i) {
      apart.positions.push_back(mesh.positions[t[i]]);
      if (!mesh.normals.empty()) apart.normals.push_back(mesh.normals[t[i]]);
      apart.uvs.push_back(mesh.uv(t, i));
    }
    apart.triangles.push_back(first + uvec3(0, 1, 2));
  }
  apart.quads = std::move(mesh.quads);
  mesh = std::move(apart);
}

}  // namespace etendue
