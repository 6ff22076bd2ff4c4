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
TriangleMesh parse_obj(std::string text, const std::string& name);

struct ObjPart {
  std::string material;  // as `usemtl` names it
  TriangleMesh mesh;     // with one vertex for all that are equal, whatever their numbers
};
// The parts that lines g and usemtl set apart, as Mitsuba 0.6 reads them; one of all faces unless `apart`. Throws as parse_obj.
std::vector<ObjPart> parse_obj_parts(std::string text, const std::string& name, bool apart);

}  // namespace etendue
