// Brute force: tests every ball in every query. The reference for the other ball structures.
#pragma once

#include "accel/records/ball.h"

namespace etendue {

class BallBruteForce {
 public:
  void insert(const vec3& centre, float radius, std::uint32_t id) {
    if (is_ball(centre, radius)) balls_.push_back({centre, radius, id});
  }
  void covering(const vec3& p, Neighbours& out) const {
    out.clear();
    for (const Ball& ball : balls_) add_if_covering(ball, p, out);
    sort_by_id(out);
  }
  std::uint64_t bytes() const { return balls_.size() * sizeof(Ball); }

 private:
  std::vector<Ball> balls_;
};

static_assert(BallStructure<BallBruteForce>);

}  // namespace etendue
