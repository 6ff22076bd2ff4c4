// Pixel filters in images: an edge is blurred as the filter's integral says, and what is even stays even, whatever the method.
#include "experiments/kinds/timing.h"
#include "experiments/run/closed_form.h"
#include "framework/scene/builder.h"
#include "tests/block_agreement.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::render;
using testing::RenderOptions;

const FilterShape gaussian{.kind = FilterKind::gaussian, .radius = vec2(2), .sigma = 0.6f};
const FilterShape mitchell{.kind = FilterKind::mitchell, .radius = vec2(2)};
const FilterShape lanczos{.kind = FilterKind::sinc, .radius = vec2(3), .tau = 3};
const FilterShape triangle{.kind = FilterKind::triangle, .radius = {1, 2}};

constexpr int width = 12;
constexpr float edge = 5.3f;  // pixels from the left

// A white half plane under an even sky of directional light, seen straight on: 1 / pi left of the edge, black to its right.
Scene half_plane(const FilterShape& filter) {
  SceneBuilder b("edge");
  b.mesh(quad({-50, -50, 0}, {edge - width / 2, -50, 0}, {edge - width / 2, 50, 0}, {-50, 50, 0}), b.material(Diffuse{Rgb(1)}));
  b.light(DirectionalLight{{0, 0, -1}, Rgb(1)});
  b.camera({0, 0, 5}, {0, 0, 0}, 40, {width, width});
  b.max_depth(1);
  Scene scene = b.finish();
  scene.camera.half_width = width / 2;
  scene.filter = make_pixel_filter(filter);
  return scene;
}

double exact_column(const FilterShape& filter, int column) {
  constexpr int steps = 4000;
  double left = 0, all = 0;
  for (int i = 0; i < steps; ++i) {
    const double x = filter.radius.x * (2 * (i + 0.5) / steps - 1), value = filter.at(x, 0);
    all += value;
    if (column + 0.5 + x < edge) left += value;
  }
  return left / all * inv_pi;
}

void expect_blurred_edge(const FilterShape& filter, const char* method, std::uint32_t iterations, double tolerance,
                         const ParamMap& params = {}) {
  RenderOptions options;
  options.resolution = {width, width};
  options.iterations = iterations;
  options.params = params;
  const testing::Rendered rendered = render(half_plane(filter), method, options);
  EXPECT_EQ(rendered.non_finite, 0u);
  for (int x = 0; x < width; ++x) {
    double mean = 0;
    for (int y = 0; y < width; ++y) mean += rendered.image.at(x, y).y / width;
    EXPECT_NEAR(mean, exact_column(filter, x), tolerance * inv_pi) << method << " " << filter.text() << " column " << x;
  }
}

TEST(FilteredImages, AnEdgeIsBlurredByTheFiltersIntegral) {
  for (const FilterShape& filter : {gaussian, mitchell, lanczos, triangle}) expect_blurred_edge(filter, "path", 256, 0.01);
}

TEST(FilteredImages, MethodsBlurAlike) {
  for (const FilterShape& filter : {gaussian, mitchell}) {
    for (const char* method : {"bdpt", "photon-map", "guided", "hash-cache", "irradiance-cache"})
      expect_blurred_edge(filter, method, 96, 0.03);
    expect_blurred_edge(filter, "sppm", 96, 0.03, testing::params_of({{"photons", "100"}}));
  }
}

// Splats are spread over the pixels that their place counts for; beyond the image's rim, too.
TEST(FilteredImages, SplatsAreSpreadByTheFilter) {
  for (const FilterShape& filter : {gaussian, lanczos})
    expect_blurred_edge(filter, "light-trace", 48, 0.08, testing::params_of({{"paths", "20000"}}));
}

TEST(FilteredImages, AnEvenSkyIsEven) {
  SceneBuilder b("sky");
  b.light(EnvironmentLight{.scale = Rgb(0.75f), .size = {}, .texels = {}, .light_to_world = {}});
  b.camera({0, 0, 5}, {0, 0, 0}, 40, {8, 8});
  Scene scene = b.finish();
  for (const FilterShape& filter : {gaussian, mitchell, lanczos, triangle}) {
    scene.filter = make_pixel_filter(filter);
    for (const char* method : {"path", "photon-map", "sppm", "bdpt", "guided", "hash-cache", "photon-cache"}) {
      RenderOptions options;
      options.resolution = {8, 8};
      options.iterations = 8;
      for (const dvec3& pixel : render(scene, method, options).image.pixels)
        EXPECT_NEAR(pixel.y, 0.75, 1e-6) << method << " " << filter.text();
    }
  }
}

// After two and three iterations, when pixels take other numbers of samples, none may have lost its direct light.
TEST(FilteredImages, CachesKeepDirectLightUnderSignedFilters) {
  SceneBuilder b("floor");
  b.mesh(quad({-5, 0, 5}, {5, 0, 5}, {5, 0, -5}, {-5, 0, -5}), b.material(Diffuse{Rgb(0.5f)}));
  b.light(PointLight{{0, 4, 0}, Rgb(10)});
  b.camera({0, 3, 0.1f}, {0, 0, 0}, 40, {8, 8});
  Scene scene = b.finish();
  for (const FilterShape& filter : {mitchell, lanczos}) {
    scene.filter = make_pixel_filter(filter);
    for (const char* method : {"irradiance-cache", "radiance-cache", "photon-cache", "hash-cache"})
      for (const std::uint32_t iterations : {2u, 3u}) {
        RenderOptions options;
        options.resolution = {8, 8};
        options.iterations = iterations;
        for (const dvec3& pixel : render(scene, method, options).image.pixels)
          EXPECT_NEAR(pixel.y, 0.0995, 0.025) << method << " " << filter.text();  // 0.5 / pi 10 / 4^2, less to the sides
      }
  }
}

// A ceiling that the sun does not reach, over a floor that it does: what cells answer is all the light there is.
TEST(FilteredImages, CachesKeepIndirectLightUnderSignedFilters) {
  SceneBuilder b("floor and ceiling");
  const std::uint32_t grey = b.material(Diffuse{Rgb(0.5f)});
  b.mesh(quad({-50, 0, 50}, {50, 0, 50}, {50, 0, -50}, {-50, 0, -50}), grey);
  b.mesh(quad({-2, 4, -2}, {2, 4, -2}, {2, 4, 2}, {-2, 4, 2}), grey);
  b.light(DirectionalLight{glm::normalize(vec3(1, -1, 0)), Rgb(1)});
  b.camera({0, 1, 0}, {0, 4, 0.1f}, 40, {8, 8});
  b.max_depth(2);
  Scene scene = b.finish();
  for (const FilterShape& filter : {mitchell, lanczos}) {
    scene.filter = make_pixel_filter(filter);
    for (const std::uint32_t iterations : {3u, 5u}) {
      RenderOptions options;
      options.resolution = {8, 8};
      options.iterations = iterations;
      for (const dvec3& pixel : render(scene, "hash-cache", options).image.pixels) EXPECT_GT(pixel.y, 0.015) << filter.text();
    }
  }
}

// Blocks of two samples of opposite signs weigh nothing.
TEST(FilteredImages, GuidedPathsAreNotCombinedByFewSignedSamples) {
  Scene scene = load_scene("builtin:cornell-box");
  scene.filter = make_pixel_filter(mitchell);
  RenderOptions options;
  options.resolution = {8, 8};
  options.params = testing::params_of({{"combination", "last"}});
  EXPECT_THROW(render(scene, "guided", options), Error);
}

// The reference of a scene with a closed form is filtered as its images are.
TEST(FilteredImages, ClosedFormsAreFilteredAlike) {
  Scene scene = load_scene("builtin:sphere-light");
  for (const FilterShape& filter : {gaussian, mitchell}) {
    scene.filter = make_pixel_filter(filter);
    RenderOptions options;
    options.resolution = {12, 12};
    options.iterations = 256;
    const Image exact = integrate_closed_form(scene, options.resolution), image = render(scene, "path", options).image;
    for (std::size_t i = 0; i < exact.pixels.size(); ++i)
      EXPECT_NEAR(image.pixels[i].y, exact.pixels[i].y, 0.04 * exact.pixels[i].y + 4e-3) << filter.text() << " " << i;
  }
}

TEST(FilteredImages, InstructionSetsGiveTheSameBits) {
  const auto hash = [](Isa isa) {
    const WithIsa with(isa);
    RenderOptions options;
    options.iterations = 2;
    Scene scene = load_scene("builtin:cornell-box");
    scene.filter = make_pixel_filter(mitchell);
    return render(scene, "path", options).hash;
  };
  for (const Isa isa : supported_isas()) EXPECT_EQ(hash(isa), hash(Isa::scalar));
}

}  // namespace
}  // namespace etendue
