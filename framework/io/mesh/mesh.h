// A triangle mesh as the mesh readers give it, before it becomes part of a scene.
#pragma once

#include "framework/core/vec.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace etendue {

// `normals` and `uvs` are per vertex, or empty. Indices are valid and positions finite: readers throw otherwise.
struct TriangleMesh {
  std::vector<vec3> positions, normals;
  std::vector<vec2> uvs;
  std::vector<uvec3> triangles;
  std::vector<std::string> warnings;      // what the file holds that was left out
  std::vector<std::uint32_t> quads = {};  // of each quadrilateral of a PLY the first of its two triangles
  bool face_normals = false;              // a serialized mesh says that it is faceted, whatever normals it has
  bool names_materials = false;           // an OBJ file names a library of them, which is not read

  // Without texture coordinates each triangle has those of pbrt.
  vec2 uv(const uvec3& triangle, int corner) const {
    constexpr vec2 otherwise[3] = {{0, 0}, {1, 0}, {1, 1}};
    return uvs.empty() ? otherwise[corner] : uvs[triangle[corner]];
  }
};

// The triangles that a polygon became, all of them at its first corner.
struct Fan {
  std::size_t first = 0, count = 0;
};
// Warns of those, and of quads, that are no polygon's shape, since it is not convex: a triangle faces away from the rest.
void warn_of_concave_fans(TriangleMesh& mesh, std::span<const Fan> fans, const std::string& name);

// Gives each triangle the texture coordinates of pbrt and vertices of its own, where the mesh has none.
void give_default_uvs(TriangleMesh& mesh);

// Makes every normal unit. A zero or non-finite one becomes the area-weighted mean of the geometric normals around its vertex,
// each turned to the side of the usable normals of its face. Where no normal is usable, `normals` becomes empty. Texture
// coordinates that are not finite become 0. What was not finite is listed in the mesh's warnings, which `name` begins.
void mend_attributes(TriangleMesh& mesh, const std::string& name);

}  // namespace etendue
