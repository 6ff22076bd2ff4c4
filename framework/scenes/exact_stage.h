// A scene of rectangles whose radiance is known. One list defines both the geometry and the closed form, so that they agree on
// what hides what.
//
// Rectangles are black unless a radiance is given, and a mirror shows what lies before it. Where light must count as indirect
// (irradiance caches, maps of caustic photons) a *veil* stands before it: a pane of index 1. It changes no image, but shadow
// rays end on it: only traced rays and photons find light through it.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/builder.h"

#include <numbers>

namespace etendue {

inline constexpr double pi_d = std::numbers::pi;
inline const ivec2 exact_resolution{128, 128};  // of scenes with a closed form

// Parameters of scenes with a veil.
struct VeilParams {
  bool veil = true;
};

template <class Visitor>
void describe(Visitor& v, VeilParams& p) {
  v.flag("veil", p.veil, "before the light, a pane of index 1: no shadow ray gets through, the image stays the same");
}

class ExactStage {
 public:
  using Radiance = std::function<dvec3(const dvec3& point)>;  // leaving a point of a side, the same in all directions

  explicit ExactStage(std::string name);

  SceneBuilder builder;  // for lights and camera

  std::uint32_t black() const { return black_; }
  // The front of a rectangle with corners a, b, c, d faces cross(b - a, d - a), and there it reflects what is known; an empty
  // function is black. Its back is black in the closed form: no light may reach it.
  void reflector(const MeshData& quad, std::uint32_t material, Radiance front);
  // The same, but it also emits; `front` is then all radiance that leaves it.
  void glowing_reflector(const MeshData& quad, std::uint32_t material, const Rgb& emitted, Radiance front);
  // Emits on its front; reflects nothing unless of another material, and then no light may reach it.
  void emitter(const MeshData& quad, const Rgb& radiance) { emitter(quad, radiance, black_); }
  void emitter(const MeshData& quad, const Rgb& radiance, std::uint32_t material);
  void blocker(const MeshData& quad);                    // black
  void mirror(const MeshData& quad, float reflectance);  // on both sides
  void veil(const MeshData& quad);

  Scene finish(std::string source);

 private:
  struct Side {
    dvec3 corner, u, v, normal;
    Radiance front;
    double mirror = 0;
  };
  void add(const MeshData& quad, Radiance front, double mirror = 0);
  static dvec3 radiance(const std::vector<Side>& sides, const dvec3& origin, const dvec3& direction, int reflections);

  std::uint32_t black_;
  std::vector<Side> sides_;
};

}  // namespace etendue
