// A scene's closed form as an image: the exact radiance, averaged over each pixel by the scene's filter.
#pragma once

#include "framework/image/film.h"
#include "framework/scene/scene.h"

namespace etendue {

// Gauss-Legendre with 8 x 8 nodes; where 4 x 4 nodes differ from them by more than 1e-6 of the value, the pixel is cut into
// four, four times at most. An open lens is integrated with 6 x 6 nodes more. CHECKs that the scene has a closed form.
Image integrate_closed_form(const Scene& scene, ivec2 resolution);

}  // namespace etendue
