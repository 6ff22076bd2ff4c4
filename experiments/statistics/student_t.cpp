#include "experiments/statistics/statistics.h"
#include "framework/core/check.h"

#include <boost/math/distributions/students_t.hpp>

namespace etendue {

double student_t_quantile(double p, double degrees) {
  CHECK(p > 0 && p < 1 && degrees > 0);
  if (p == 0.5) return 0;
  const boost::math::students_t distribution(degrees);
  // By the tail, which keeps its digits where the distribution function is close to 1.
  return p < 0.5 ? boost::math::quantile(distribution, p) : boost::math::quantile(complement(distribution, 1 - p));
}

}  // namespace etendue
