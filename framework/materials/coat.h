// A smooth dielectric coat over a diffuse base: what passes it and what it holds back.
#pragma once

#include "framework/core/elementary.h"
#include "framework/core/lanes.h"

namespace etendue {

// `eta` is the coat's index over that of what is outside, at least 1. Light that crosses the coat straight through is dimmed by
// e^-depth, and obliquely by e^(-depth / cosine); nothing scatters there.
class Coat {
 public:
  Coat(float eta, float depth = 0);  // NOLINT(google-explicit-constructor): clear, it is an index
  float eta() const { return eta_; }
  float depth() const { return depth_; }

  // Shares of diffuse light, which comes evenly from the whole hemisphere: of that from outside, what reaches the base; of that
  // from the base, what comes back to it after a reflection inside, and what leaves.
  float entering() const { return entering_; }
  float internal_reflectance() const { return internal_; }
  float leaving() const { return leaving_; }

  // What is left after a way through the coat, in thicknesses: 1 / cosine for each crossing.
  template <class F>
  F passing(F way) const {
    F share = 1.0f;
    if (depth_ > 0) for_lanes(Mask<F>(true), [&](int i) { set_lane(share, i, math::exp(-depth_ * lane(way, i))); });
    return share;
  }

 private:
  float eta_, depth_;
  float entering_, internal_, leaving_;
};

}  // namespace etendue
