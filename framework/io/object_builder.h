// Collects the shapes of one object in the order they are met and lays them out as an Object: triangles first, then quadrics.
#pragma once

#include "framework/io/mesh/mesh.h"
#include "framework/scene/scene.h"

#include <optional>
#include <vector>

namespace etendue {

// How far from the origin anything may lie, in metres: areas and powers then stay in the range of single precision, though the
// squares of areas do not.
inline constexpr float farthest = 1e12f;
// The half angle, in degrees, of the narrowest spot that readers take: by its cosine, in single precision, its light is right
// to 1 %. A spot of 0.02 degrees would be black.
inline constexpr float narrowest_spot = 0.3f;
inline bool within_reach(const vec3& p) { return glm::all(glm::lessThanEqual(glm::abs(p), vec3(farthest))); }

struct ShapeLook {
  std::uint32_t material = 0;
  bool flip_normal = false;
  struct Glow {
    Rgb radiance;
    bool two_sided;
    std::uint32_t texture = no_id;  // as of Emission
  };
  std::optional<Glow> glow;
  std::uint32_t mask = no_id;  // as of Shape
};

// Throws Error where there is no room for more of them: an object of many parts has an instance for each, wherever it is.
void add_instance(Scene& scene, const Instance& instance);

class ObjectBuilder {
 public:
  // The mesh is in the object's space. Throws Error where there is no room for it. Returns how many of its triangles no
  // structure may hold (Geometry::is_valid).
  std::uint64_t add(TriangleMesh mesh, const ShapeLook& look);
  void add(const Quadric& quadric, const ShapeLook& look);

  bool empty() const { return meshes_.empty() && quadrics_.empty(); }
  // The object, leaving the builder empty. Emissions name shapes of this object.
  Object take(std::vector<Emission>* emissions = nullptr);

 private:
  struct Part {
    Shape shape;
    std::optional<ShapeLook::Glow> glow;
  };

  Object object_;
  std::vector<Part> meshes_, quadrics_;
};

}  // namespace etendue
