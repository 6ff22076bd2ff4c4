#include "experiments/run/closed_form.h"

#include "framework/core/check.h"
#include "framework/core/parallel.h"

#include <array>
#include <span>

namespace etendue {

namespace {

struct Node {
  double x, weight;  // on [0, 1]
};

// From the positive half of the nodes on [-1, 1].
template <std::size_t Half>
constexpr std::array<Node, 2 * Half> gauss_legendre(const std::array<Node, Half>& half) {
  std::array<Node, 2 * Half> nodes{};
  for (std::size_t i = 0; i < Half; ++i) {
    nodes[2 * i] = {0.5 - 0.5 * half[i].x, 0.5 * half[i].weight};
    nodes[2 * i + 1] = {0.5 + 0.5 * half[i].x, 0.5 * half[i].weight};
  }
  return nodes;
}

constexpr auto four_nodes =
    gauss_legendre<2>({{{0.3399810435848563, 0.6521451548625461}, {0.8611363115940526, 0.3478548451374538}}});
constexpr auto six_nodes = gauss_legendre<3>({{{0.2386191860831969, 0.4679139345726910},
                                               {0.6612093864662645, 0.3607615730481386},
                                               {0.9324695142031521, 0.1713244923791704}}});
constexpr auto eight_nodes = gauss_legendre<4>({{{0.1834346424956498, 0.3626837833783620},
                                                 {0.5255324099163290, 0.3137066458778873},
                                                 {0.7966664774136267, 0.2223810344533745},
                                                 {0.9602898564975363, 0.1012285362903763}}});
constexpr std::array<Node, 1> lens_centre{{{0.5, 1.0}}};

constexpr double tolerance = 1e-6;
constexpr int most_cuts = 4;

class PixelIntegral {
 public:
  PixelIntegral(const Scene& scene, ivec2 resolution)
      : scene_(scene),
        resolution_(resolution),
        lens_(scene.camera.lens_radius > 0 ? std::span<const Node>(six_nodes) : std::span<const Node>(lens_centre)) {}

  // The mean over a square of the film.
  dvec3 mean(const dvec2& corner, double side, int cuts) const {
    const dvec3 coarse = quadrature(corner, side, four_nodes);
    const dvec3 fine = quadrature(corner, side, eight_nodes);
    const dvec3 difference = glm::abs(fine - coarse), limit = tolerance * glm::abs(fine);
    if (cuts == most_cuts || (difference.x <= limit.x && difference.y <= limit.y && difference.z <= limit.z)) return fine;
    const double half = side / 2;
    dvec3 sum(0);
    for (const dvec2& quarter : {dvec2(0, 0), dvec2(half, 0), dvec2(0, half), dvec2(half, half)})
      sum += mean(corner + quarter, half, cuts + 1);
    return sum / 4.0;
  }

 private:
  dvec3 quadrature(const dvec2& corner, double side, std::span<const Node> nodes) const {
    dvec3 sum(0);
    for (const Node& y : nodes)
      for (const Node& x : nodes) sum += x.weight * y.weight * lens_mean(corner + side * dvec2(x.x, y.x));
    return sum;
  }

  dvec3 lens_mean(const dvec2& film) const {
    dvec3 sum(0);
    for (const Node& v : lens_)
      for (const Node& u : lens_)
        sum += u.weight * v.weight * scene_.closed_form->radiance(scene_.camera.ray(resolution_, vec2(film), vec2(u.x, v.x)));
    return sum;
  }

  const Scene& scene_;
  ivec2 resolution_;
  std::span<const Node> lens_;
};

}  // namespace

Image integrate_closed_form(const Scene& scene, ivec2 resolution) {
  CHECK(scene.closed_form.has_value());
  const PixelIntegral integral(scene, resolution);
  Image image(resolution);
  parallel_pixels(resolution, [&](ivec2 pixel) { image.at(pixel.x, pixel.y) = integral.mean(dvec2(pixel), 1, 0); });
  return image;
}

}  // namespace etendue
