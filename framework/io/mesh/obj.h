// Wavefront OBJ meshes, parsed and triangulated by tinyobjloader.
#pragma once

#include "framework/io/mesh/mesh.h"

#include <string>
#include <vector>

namespace etendue {

// All faces of the file as one mesh, with one vertex per distinct (v, vt, vn). Groups, smoothing and materials are left out
// (TriangleMesh::names_materials). Throws Error at `file:line:col` on numbers, indices or faces that are not valid,
// and on a file without faces.
TriangleMesh read_obj(const std::string& path);
// Polygons of more than three corners are cut into triangles that cover them once, or as Mitsuba does it: into those that the
// first corner makes with each edge.
enum class Polygons : std::uint8_t { covered, fans };
TriangleMesh parse_obj(std::string text, const std::string& name, Polygons polygons = Polygons::covered);

struct ObjPart {
  std::string material;  // as `usemtl` names it
  TriangleMesh mesh;     // with one vertex for all that are equal, whatever their numbers
};
// The parts that lines g and usemtl set apart, as Mitsuba 0.6 reads them; one of all faces unless `apart`. Polygons become
// fans. Throws as parse_obj.
std::vector<ObjPart> parse_obj_parts(std::string text, const std::string& name, bool apart);

}  // namespace etendue
