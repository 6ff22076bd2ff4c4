// Weights for vertex connection and merging that account for correlation ([Grittmann2021]).
//
// All merges at one camera vertex share the camera's part of their paths, so that n photons there are not n independent paths:
// where the camera's part is the improbable one, either all or none of them contribute. The balance heuristic, which counts
// them as n samples, then takes weight from strategies that would sample the path with less variance. The correlation-aware
// heuristic scales the density of a merge at vertex i by
//
//   rho_i = c_i / (c_i + l_i - c_i l_i)
//
// c_i and l_i the products over the camera's and the light's part, up to i, of min(1, density per area times A): how probable
// either part is to come within an area A of each of its vertices. rho is 1 where the camera's part is sure to be there (at the
// first vertex, through mirrors) or where the light's is improbable, and c_i / l_i where it is the other way round. A is the
// disc that a cone of one degree about the camera ray cuts out at the first vertex, as in the authors' implementation. All
// strategies of a path see the same factors, so that the weights sum to one.
//
// rho depends on both parts at once, so partial sums ([Georgiev2012b]) do not suffice: each part keeps the densities of its
// vertices, and a weight costs time in proportion to the path's length. Deviation: light from the environment counts with its
// density over area and direction together, as theirs does; delta lobes, which have no density, with 1.
#pragma once

#include "framework/core/vec.h"

#include <span>
#include <vector>

namespace etendue {

// A vertex of a part, in the order in which it was traced.
struct TrailVertex {
  float own = 0;                   // per area, with which its part found it
  float back = 0;                  // cos / distance^2 of the vertex before: per solid angle to per area
  float forward = 0, reverse = 0;  // per solid angle, of the way that the part goes on and of the same backwards
  float cos_out = 0;
  bool specular = false;  // goes on by a delta lobe; forward and reverse tell their ratio alone

  void leave(float cosine, float pdf_forward, float pdf_reverse, bool delta) {
    cos_out = cosine, forward = pdf_forward, reverse = pdf_reverse, specular = delta;
  }
  TrailVertex next(float distance_squared, float cos_in) const {
    return {forward * cos_in / distance_squared, cos_out / distance_squared};
  }
};

// The start of a path, in the unit of its first vertex's `own`.
struct TrailLight {
  float direct = 0;  // with which a next event finds the light from the first vertex
  float hit = 0;     // with which the camera's part meets it; 0: cannot. Left open where the light's part is known
  int areas = 1;     // that the density of the first vertex is over: 2 at area lights, their own among them
};

// The part from a light that ends at one of its vertices, or from the camera.
using Trail = std::span<const TrailVertex>;

class PathDensities {
 public:
  // Densities where the ends of both parts are joined. Per area they are those of finding the end of the light's part from the
  // camera's, and the other way round; per solid angle, those of going on backwards along either part.
  struct Joint {
    float camera_finds = 0, light_finds = 0;
    float light_reverse = 0, camera_reverse = 0;
    bool camera_specular = false;  // the camera's part meets the light by a delta lobe of its last vertex
  };

  // `light_paths`: splats and merges tried; `merge_area` pi r^2, or 0.
  void count_strategies(float light_paths, float merge_area) {
    light_paths_ = light_paths;
    merge_area_ = merge_area;
  }

  // The parts end at vertices next to each other; either may be empty.
  void connect(const TrailLight& light, Trail from_light, Trail from_camera, const Joint& joint, float first_distance_squared);
  // The parts end at the same vertex; camera_finds and light_finds are known.
  void merge(const TrailLight& light, Trail from_light, Trail from_camera, const Joint& joint, float first_distance_squared);

  // Weights of the strategies, of which a path of k vertices has: hit; connection(s), s vertices from the light (0: next event,
  // k: splat); merge_at(i), vertices counted from the light, from 1.
  float hit() const { return share(hit_density()); }
  float connection(std::size_t from_light) const { return share(connection_density(from_light)); }
  float merge_at(std::size_t i) const { return share(merge_density(i)); }

 private:
  struct Vertex {
    double light, camera;  // per area, over the larger of the two
    double scale;          // that larger one
    bool specular;
    double light_part, camera_part;      // products up to and with this vertex
    double light_nearby, camera_nearby;  // likewise, of min(1, density A)
  };

  void add_light_part(const TrailLight& light, Trail from_light, const Joint& joint);
  void add_camera_part(Trail from_camera, std::size_t count, const Joint& joint);
  void add(float light, float camera, bool specular);
  void multiply(float first_distance_squared);
  double light_part(std::size_t s) const { return s == 0 ? 1 : vertices_[s - 1].light_part; }
  double camera_part(std::size_t first) const { return first >= vertices_.size() ? 1 : vertices_[first].camera_part; }
  double hit_density() const { return light_.hit * camera_part(0); }
  double connection_density(std::size_t s) const;
  double merge_density(std::size_t i) const;
  float share(double density) const { return sum_ > 0 ? static_cast<float>(density / sum_) : 0; }

  float light_paths_ = 1, merge_area_ = 0;
  TrailLight light_;
  std::vector<Vertex> vertices_;  // from the light's side
  double sum_ = 0;
};

}  // namespace etendue
