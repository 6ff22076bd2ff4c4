// The noise of rendered references is subtracted here where errors are compared.
#pragma once

#include <algorithm>

namespace etendue {

// The rest of an error without that noise: a tenth of the noise at least, as its own estimate is not exact either.
inline double without_noise(double error, double noise) { return noise > 0 ? std::max(error - noise, 0.1 * noise) : error; }

inline constexpr const char* noise_taken_off =
    "The noise of rendered references is taken from errors before they are compared; what is left counts as a tenth of it at "
    "least.";

}  // namespace etendue
