// Do photons lie evenly in a disc? Their moments tell.
//
// Where light is even, photons in a disc of radius R are uniform in it: whatever powers w and distances d they have, their
// angles a are uniform and independent, and x = d^2 / R^2 is uniform between 0 and 1. Then each of the sums
//
//   s1 = sum w d e^(i a)       a slope or a border makes it large
//   s2 = sum w d^2 e^(2 i a)   a ridge, a slit
//   s0 = sum w (x - 1/2)       a peak, a hole
//
// has the mean 0 and a known variance, and
//
//   Q = 2 |s1|^2 / sum |w|^2 d^2 + 2 |s2|^2 / sum |w|^2 d^4 + 12 |s0|^2 / sum |w|^2
//
// a mean of 5; of many photons of one colour it is chi-squared of five degrees of freedom. Over colours squares are added up,
// so that a border between colours of one luminance counts, too.
//
// An estimate of density from the photons may be taken where Q is small without being biased by that choice: with a kernel of
// radial symmetry it depends on w and d alone, of which the angles in s1 and s2 are independent; and s0 is as likely as -s0 at
// any R, so that its square prefers neither what is too bright nor what is too dark.
#pragma once

#include "framework/core/vec.h"

namespace etendue {

class DiscMoments {
 public:
  // Takes a disc's normal and squared radius. With a radius of 0 there is no number.
  DiscMoments(const vec3& normal, float radius_squared)
      : frame_(Frame::from_normal(normal)), per_radius_(1 / std::sqrt(radius_squared)) {}

  // `power` in any unit; `offset` from the disc's middle, of the given squared length.
  void add(Rgb power, const vec3& offset, float distance_squared) {
    // In a unit near the first photon's, a power of two, lest squares leave the range of floats.
    if (unit_ == 0 && max_component(power) > 0) {
      int exponent;
      std::frexp(max_component(power), &exponent);
      unit_ = std::ldexp(1.0f, std::clamp(-exponent, -126, 126));
    }
    power *= unit_;
    // In radii, lest squares of lengths in small scenes be rounded to zero.
    const float x = glm::dot(offset, frame_.tangent) * per_radius_, y = glm::dot(offset, frame_.bitangent) * per_radius_;
    const float power_squared = glm::dot(power, power), flat_squared = x * x + y * y;
    radial_ += power * (distance_squared * per_radius_ * per_radius_ - 0.5f);
    first_x_ += power * x;
    first_y_ += power * y;
    second_x_ += power * (x * x - y * y);
    second_y_ += power * (2 * x * y);
    squares_ += power_squared;
    first_squares_ += power_squared * flat_squared;
    second_squares_ += power_squared * flat_squared * flat_squared;
  }

  // Q; not a number where photons have no power.
  float unevenness() const {
    const float first = length_squared(first_x_) + length_squared(first_y_);
    const float second = length_squared(second_x_) + length_squared(second_y_);
    return 2 * first / first_squares_ + 2 * second / second_squares_ + 12 * length_squared(radial_) / squares_;
  }

 private:
  Frame frame_;
  float per_radius_;
  Rgb radial_{0}, first_x_{0}, first_y_{0}, second_x_{0}, second_y_{0};
  float unit_ = 0;
  float squares_ = 0, first_squares_ = 0, second_squares_ = 0;
};

}  // namespace etendue
