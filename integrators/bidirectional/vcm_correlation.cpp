#include "integrators/bidirectional/vcm_correlation.h"

namespace etendue {

void PathDensities::connect(const TrailLight& light, Trail from_light, Trail from_camera, const Joint& joint,
                            float first_distance_squared) {
  add_light_part(light, from_light, joint);
  add_camera_part(from_camera, from_camera.size(), joint);
  multiply(first_distance_squared);
}

void PathDensities::merge(const TrailLight& light, Trail from_light, Trail from_camera, const Joint& joint,
                          float first_distance_squared) {
  Joint same = joint;
  same.camera_finds = from_camera.back().own;
  add_light_part(light, from_light, same);
  add_camera_part(from_camera, from_camera.size() - 1, joint);
  multiply(first_distance_squared);
}

void PathDensities::add_light_part(const TrailLight& light, Trail from_light, const Joint& joint) {
  vertices_.clear();
  light_ = light;
  const auto reverse = [&](std::size_t i) {
    return (i + 1 == from_light.size() ? joint.light_reverse : from_light[i].reverse) * from_light[i].back;
  };
  if (!from_light.empty() && light.hit != 0) light_.hit = reverse(0);
  for (std::size_t i = 0; i < from_light.size(); ++i) {
    const bool last = i + 1 == from_light.size();
    add(from_light[i].own, last ? joint.camera_finds : reverse(i + 1), !last && from_light[i].specular);
  }
}

// The first `count` vertices of the camera's part, backwards.
void PathDensities::add_camera_part(Trail from_camera, std::size_t count, const Joint& joint) {
  for (std::size_t i = count; i-- > 0;) {
    const bool last = i + 1 == from_camera.size();
    float light = joint.light_finds;
    if (!last) {
      const TrailVertex& next = from_camera[i + 1];
      light = (i + 2 == from_camera.size() ? joint.camera_reverse : next.reverse) * next.back;
    }
    add(light, from_camera[i].own, last ? joint.camera_specular : from_camera[i].specular);
  }
}

// Every strategy has each vertex either from the light or from the camera, and a merge one of them from both: so densities over
// the larger of the two keep all ratios, and no product leaves the range of a double.
void PathDensities::add(float light, float camera, bool specular) {
  const double scale = std::max({light, camera, std::numeric_limits<float>::min()});
  vertices_.push_back({light / scale, camera / scale, scale, specular, 1, 1, 1, 1});
}

void PathDensities::multiply(float first_distance_squared) {
  constexpr double tangent = 0.017455064928217585;  // of one degree
  const double area = static_cast<double>(pi) * tangent * tangent * first_distance_squared;
  const std::size_t k = vertices_.size();
  double part = 1, nearby = 1;
  for (std::size_t i = 0; i < k; ++i) {
    Vertex& v = vertices_[i];
    v.light_part = part *= v.light;
    if (i == 0 || !vertices_[i - 1].specular)
      nearby *= std::min(1.0, v.light * v.scale * (i == 0 && light_.areas == 2 ? area * area : area));
    v.light_nearby = nearby;
  }
  part = nearby = 1;
  for (std::size_t i = k; i-- > 0;) {
    Vertex& v = vertices_[i];
    v.camera_part = part *= v.camera;
    if (i + 1 == k || !vertices_[i + 1].specular) nearby *= std::min(1.0, v.camera * v.scale * area);
    v.camera_nearby = nearby;
  }
  sum_ = hit_density();
  for (std::size_t s = 0; s <= k; ++s) sum_ += connection_density(s);
  for (std::size_t i = 1; i <= k; ++i) sum_ += merge_density(i);
}

double PathDensities::connection_density(std::size_t s) const {
  const std::size_t k = vertices_.size();
  if ((s > 0 && vertices_[s - 1].specular) || (s < k && vertices_[s].specular)) return 0;
  if (s == 0) return light_.direct * camera_part(0);
  return light_part(s) * camera_part(s) * (s == k ? light_paths_ : 1);
}

double PathDensities::merge_density(std::size_t i) const {
  const Vertex& v = vertices_[i - 1];
  if (v.specular) return 0;
  const double c = v.camera_nearby, l = v.light_nearby;
  const bool first = i == vertices_.size();  // that the camera sees: its merges share nothing
  const double rho = first || !(c + l > 0) ? 1 : c / (c + l - c * l);
  return light_paths_ * merge_area_ * rho * v.light_part * v.camera_part * v.scale;
}

}  // namespace etendue
