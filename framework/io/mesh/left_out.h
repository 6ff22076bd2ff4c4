// Which triangles of a scene's files no ray will meet: those of no area, or not finite (Geometry::is_valid). They are reported
// by mesh; else a file that holds nothing else would be a black image without a reason.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace etendue {

class LeftOutTriangles {
 public:
  // `name`: of the mesh, as a user finds it; how many it has in all, and how many of them are left out as they are placed (a
  // transform may leave nothing of a triangle).
  void add(std::string name, std::uint64_t triangles, std::uint64_t left_out);
  // One for each of the meshes that miss the largest share, one for all the others together; none where nothing is left out.
  std::vector<std::string> warnings() const;

 private:
  static constexpr std::size_t most_named = 4;

  struct Mesh {
    std::string name;
    std::uint64_t triangles, left_out;
    double share() const { return static_cast<double>(left_out) / static_cast<double>(triangles); }
  };

  std::vector<Mesh> meshes_;  // that miss any
};

}  // namespace etendue
