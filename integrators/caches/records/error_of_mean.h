// The standard error of a weighted mean of records. It has three parts: the records' own variances, or their scatter where that
// is larger (gradients have noise too, and each record has its own interpolation error); noise that all share, which more
// records do not lower; and the second-order error of interpolation common to all, taken as e^2 / 2 of each value, e being the
// record's first-order error ([Ward1988]).
#pragma once

#include <algorithm>
#include <cmath>

namespace etendue {

class ErrorOfMean {
 public:
  // `variance`: of the record's own noise; `shared_variance`: of that which it has in common with the others.
  void add(float weight, float said, float variance, float shared_variance, float error) {
    const double w = weight;
    weights_ += w;
    squared_weights_ += w * w;
    said_ += w * said;
    squares_ += w * said * said;
    noise_ += w * w * variance;
    shared_ += w * std::sqrt(static_cast<double>(shared_variance));
    remainder_ += w * 0.5 * error * error * said;
  }

  float standard_error() const {
    if (!(weights_ > 0)) return 0;
    const double mean = said_ / weights_, spread = std::max(0.0, squares_ / weights_ - mean * mean);
    const double share = squared_weights_ / (weights_ * weights_);  // 1 / n of n equal weights
    // With weights worth less than two records the spread is no estimate; it must not be scaled up.
    const double scatter = spread * share / std::max(1 - share, 0.5);
    const double noise = noise_ / (weights_ * weights_), shared = shared_ / weights_, remainder = remainder_ / weights_;
    return static_cast<float>(std::sqrt(std::max(noise, scatter) + shared * shared + remainder * remainder));
  }

 private:
  double weights_ = 0, squared_weights_ = 0, said_ = 0, squares_ = 0, noise_ = 0, shared_ = 0, remainder_ = 0;
};

}  // namespace etendue
