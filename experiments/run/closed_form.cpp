#include "experiments/run/closed_form.h"

#include "framework/core/check.h"
#include "framework/core/parallel.h"

#include <boost/math/quadrature/gauss.hpp>

#include <span>
#include <vector>

namespace etendue {

namespace {

struct Node {
  double x, weight;  // on [0, 1]
};

// Gauss-Legendre; the library has the positive half of the nodes on [-1, 1].
template <unsigned count>
std::vector<Node> gauss_legendre() {
  using Rule = boost::math::quadrature::gauss<double, count>;
  std::vector<Node> nodes;
  for (std::size_t i = 0; i < Rule::abscissa().size(); ++i)
    for (const double sign : {-1.0, 1.0}) nodes.push_back({0.5 + sign * 0.5 * Rule::abscissa()[i], 0.5 * Rule::weights()[i]});
  return nodes;
}

const std::vector<Node> four_nodes = gauss_legendre<4>(), six_nodes = gauss_legendre<6>(), eight_nodes = gauss_legendre<8>();
const std::vector<Node> lens_centre{{0.5, 1.0}};

constexpr double tolerance = 1e-6;
constexpr int most_cuts = 4;

class PixelIntegral {
 public:
  PixelIntegral(const Scene& scene, ivec2 resolution)
      : scene_(scene), resolution_(resolution), lens_(scene.camera.lens_radius > 0 ? six_nodes : lens_centre) {}

  // The light that counts for a pixel.
  dvec3 operator()(ivec2 pixel) {
    const dvec2 begin(pixel);
    if (!scene_.filter) return mean(begin, dvec2(1), 0);
    centre_ = begin + 0.5;
    const dvec2 radius(scene_.filter->shape().radius), cells = glm::ceil(2.0 * radius), side = 2.0 * radius / cells;
    dvec3 sum(0);
    for (double y = 0; y < cells.y; ++y)
      for (double x = 0; x < cells.x; ++x) sum += mean(centre_ - radius + side * dvec2(x, y), side, 0);
    return side.x * side.y * sum;
  }

 private:
  // The mean over a rectangle of the film.
  dvec3 mean(const dvec2& corner, const dvec2& side, int cuts) const {
    const dvec3 coarse = quadrature(corner, side, four_nodes);
    const dvec3 fine = quadrature(corner, side, eight_nodes);
    const dvec3 difference = glm::abs(fine - coarse), limit = tolerance * glm::abs(fine);
    if (cuts == most_cuts || (difference.x <= limit.x && difference.y <= limit.y && difference.z <= limit.z)) return fine;
    const dvec2 half = side / 2.0;
    dvec3 sum(0);
    for (const dvec2& quarter : {dvec2(0, 0), dvec2(half.x, 0), dvec2(0, half.y), half})
      sum += mean(corner + quarter, half, cuts + 1);
    return sum / 4.0;
  }

  dvec3 quadrature(const dvec2& corner, const dvec2& side, std::span<const Node> nodes) const {
    dvec3 sum(0);
    for (const Node& y : nodes)
      for (const Node& x : nodes) sum += x.weight * y.weight * weighted(corner + side * dvec2(x.x, y.x));
    return sum;
  }

  dvec3 weighted(const dvec2& film) const {
    if (!scene_.filter) return lens_mean(film);
    return static_cast<double>(scene_.filter->density(vec2(film - centre_))) * lens_mean(film);
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
  dvec2 centre_{0};  // of the pixel, on the film
};

}  // namespace

Image integrate_closed_form(const Scene& scene, ivec2 resolution) {
  CHECK(scene.closed_form.has_value());
  Image image(resolution);
  parallel_pixels(resolution, [&](ivec2 pixel) { image.at(pixel.x, pixel.y) = PixelIntegral(scene, resolution)(pixel); });
  return image;
}

}  // namespace etendue
