// A figure that was measured several times.
#pragma once

namespace etendue {

// The median of repetitions and their quartiles; 0: not measured.
struct Measured {
  double median = 0, low = 0, high = 0;
};

}  // namespace etendue
