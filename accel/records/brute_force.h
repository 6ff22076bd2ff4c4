// Brute force: tests every sphere in every query. It is the reference for the other record structures.
#pragma once

#include "accel/records/record_sphere.h"

namespace etendue {

class RecordBruteForce {
 public:
  void insert(const vec3& centre, float radius, std::uint32_t id) {
    if (is_record_sphere(centre, radius)) spheres_.push_back({centre, radius, id});
  }
  void covering(const vec3& p, Neighbours& out) const {
    out.clear();
    for (const RecordSphere& sphere : spheres_) add_if_covering(sphere, p, out);
    sort_by_id(out);
  }
  std::uint64_t bytes() const { return spheres_.size() * sizeof(RecordSphere); }

 private:
  std::vector<RecordSphere> spheres_;
};

static_assert(RecordStructure<RecordBruteForce>);

}  // namespace etendue
