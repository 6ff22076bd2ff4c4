#include "framework/io/mesh/cut_away.h"

#include "framework/core/elementary.h"
#include "framework/core/fuzzing.h"

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

class Cutter {
 public:
  Cutter(const TriangleMesh& mesh, const Opacity& opacity) : mesh_(mesh), opacity_(opacity) {
    result_.warnings = mesh.warnings;
    const auto each = static_cast<double>(std::max<std::size_t>(mesh.triangles.size(), 1));
    depth_ = std::clamp(static_cast<int>(math::log2(4e6 / each) / 2), 0, unless_fuzzed(7, 2));
    for (const uvec3& t : mesh.triangles) cut(t);
  }
  TriangleMesh take() { return std::move(result_); }

 private:
  struct Place {
    vec2 uv;
    vec3 position;
  };

  // Barycentric weights of a point of the triangle at hand.
  Place place(const uvec3& t, const vec3& w) const {
    Place p{vec2(0), vec3(0)};
    for (int c = 0; c < 3; ++c) {
      p.uv += w[c] * mesh_.uv(t, c);
      p.position += w[c] * mesh_.positions[t[c]];
    }
    return p;
  }
  bool is_solid(const uvec3& t, const vec3& w) const {
    const Place p = place(t, w);
    return opacity_(p.uv, p.position) >= 0.5f;
  }

  void cut(const uvec3& t) { cut(t, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, 0); }
  void cut(const uvec3& t, const vec3& a, const vec3& b, const vec3& c, int level) {
    const vec3 ab = 0.5f * (a + b), bc = 0.5f * (b + c), ca = 0.5f * (c + a), middle = (a + b + c) / 3.0f;
    const bool solid = is_solid(t, middle);
    constexpr int always = 3;  // a pattern finer than a triangle would be missed by its corners
    bool uniform = level >= std::min(always, depth_);
    for (const vec3& w : {a, b, c, ab, bc, ca}) uniform = uniform && is_solid(t, w) == solid;
    if (level < depth_ && !uniform) {
      cut(t, a, ab, ca, level + 1);
      cut(t, ab, b, bc, level + 1);
      cut(t, ca, bc, c, level + 1);
      cut(t, ab, bc, ca, level + 1);
    } else if (solid) {
      add(t, a, b, c);
    }
  }
  void add(const uvec3& t, const vec3& a, const vec3& b, const vec3& c) {
    const auto first = static_cast<std::uint32_t>(result_.positions.size());
    for (const vec3& w : {a, b, c}) {
      const Place p = place(t, w);
      result_.positions.push_back(p.position);
      result_.uvs.push_back(p.uv);
      if (mesh_.normals.empty()) continue;
      vec3 n(0);
      for (int i = 0; i < 3; ++i) n += w[i] * mesh_.normals[t[i]];
      result_.normals.push_back(n);
    }
    result_.triangles.push_back(first + uvec3(0, 1, 2));
  }

  const TriangleMesh& mesh_;
  const Opacity& opacity_;
  TriangleMesh result_;
  int depth_ = 0;
};

}  // namespace

void cut_away(TriangleMesh& mesh, const Opacity& opacity) { mesh = Cutter(mesh, opacity).take(); }

}  // namespace etendue
