// The progressive photon mappers against closed forms.
#include "framework/scene/builder.h"
#include "framework/structure_names.h"
#include "tests/block_agreement.h"
#include "tests/faceted_ball.h"
#include "tests/image_checks.h"
#include "tests/lit_sheet.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::bias_over_seeds;
using testing::exact_image;
using testing::render;
using testing::RenderOptions;

constexpr const char* methods[] = {"ppm", "sppm", "ppm-memoryless", "appm", "cppm"};

RenderOptions options_for(std::int64_t photons, std::uint32_t iterations, ParamMap more = {}) {
  RenderOptions options;
  options.params = std::move(more);
  options.params["photons"] = {photons, {}};
  options.iterations = iterations;
  return options;
}

const ParamMap by_photons{{"direct", {std::string("photons"), {}}}};

TEST(ProgressivePhotons, MatchClosedFormsWithinTheirDeclaredBias) {
  for (const char* name : {"builtin:lambert-sphere", "builtin:lambert-sphere-off-centre", "builtin:furnace"})
    for (const char* method : methods)
      for (const ParamMap& params : {ParamMap{}, by_photons}) {
        RenderOptions options = options_for(2000, 4, params);
        options.resolution = {12, 12};
        const auto b = bias_over_seeds(load_scene(name), method, options, 10);
        EXPECT_LT(std::abs(b.mean), b.bound + 4 * b.deviation) << name << " " << method;
        // No edge; only direct light off the centre is uneven.
        if (!params.empty() && name == std::string("builtin:lambert-sphere-off-centre")) continue;
        EXPECT_LT(std::abs(b.mean), 0.003 + 4 * b.deviation) << name << " " << method;
      }
}

TEST(ProgressivePhotons, SphereHasNoKernelBiasAtAnyRadius) {
  // A ball of radius r cuts pi r^2 out of a sphere, evenly in d^2.
  const Scene scene = load_scene("builtin:lambert-sphere");
  for (const char* method : methods)
    for (const double radius : {0.2, 1.0}) {
      RenderOptions options = options_for(2000, 8, by_photons);
      options.params["radius"] = {radius, {}};
      options.resolution = {16, 16};
      const auto b = bias_over_seeds(scene, method, options, 6);
      EXPECT_LT(std::abs(b.mean), 0.001 + 5 * b.deviation) << method << " " << radius;
    }
}

// A disc of 100 m about each point of a box that measures less than 4 m: nearly all light would be lost.
TEST(ProgressivePhotons, KernelsWiderThanTheSceneAreRefused) {
  const Scene box = load_scene("builtin:cornell-box");
  const auto with_radius = [&](const char* method, double radius, bool fixed) {
    RenderOptions options = options_for(0, 1, {{"radius", {radius, {}}}});
    options.resolution = {4, 4};
    options.params.erase("photons");
    if (fixed) options.params["k"] = {std::int64_t{0}, {}};
    render(box, method, options);
  };
  for (const char* method : {"ppm", "sppm", "ppm-memoryless", "appm", "cppm", "vcm"}) {
    EXPECT_THROW(with_radius(method, 100, false), Error) << method;
    EXPECT_NO_THROW(with_radius(method, 0.5, false)) << method;
  }
  for (const char* method : {"photon-map", "photon-cache"}) {
    EXPECT_THROW(with_radius(method, 100, true), Error) << method;
    EXPECT_NO_THROW(with_radius(method, 100, false)) << method << ": a bound of the search for the k nearest";
  }
}

// A white floor under a sheet of tinted glass, uneven in many planes, that lies on it and does not refract: of a sky of
// radiance 1 the floor has 0.9, and 0.81 is seen. What measures discs begins above the glass, beneath which photons end their
// way.
TEST(ProgressivePhotons, SeeAFloorCloseBeneathTintedGlass) {
  SceneBuilder b("floor under glass");
  b.mesh(quad({-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}), b.material(Diffuse{Rgb(1)}));
  MeshData sheet;
  constexpr unsigned cells = 20;
  for (unsigned i = 0; i <= cells; ++i)
    for (unsigned k = 0; k <= cells; ++k)
      sheet.positions.emplace_back(0.2f * static_cast<float>(i) - 2, 0.2f * static_cast<float>(k) - 2,
                                   0.01f + 0.001f * static_cast<float>((7 * i + 13 * k) % 5));
  for (unsigned i = 0; i < cells; ++i)
    for (unsigned k = 0; k < cells; ++k) {
      const unsigned at = i * (cells + 1) + k, next = at + cells + 1;
      sheet.triangles.emplace_back(at, next, next + 1);
      sheet.triangles.emplace_back(at, next + 1, at + 1);
    }
  b.mesh(sheet, b.material(Dielectric{.eta = 1, .transmit_tint = Rgb(0.9f)}));
  b.light(EnvironmentLight{.scale = Rgb(1), .size = ivec2(0), .texels = {}, .light_to_world = {}});
  b.camera({0, 0, 3}, {0, 0, 0}, 20, {12, 12});
  const Scene scene = b.finish();
  for (const char* method : {"sppm", "appm", "cppm"}) {
    RenderOptions options = options_for(4000, 8, {{"radius", {0.2, {}}}});
    options.resolution = {12, 12};
    EXPECT_NEAR(testing::block_means(render(scene, method, options).image, 12).front().y, 0.81, 0.02) << method;
  }
}

// Photons on one facet, seen from the next one, count by the light that made them as dense as they are there: by the cosine at
// the point that gathers, by 5 % too much. The facets' own differences, over which a kernel blurs, are 1 %.
TEST(ProgressivePhotons, FacetsThatAreShadedRoundAreNotTooBright) {
  const Scene scene = testing::faceted_ball();
  const Image reference = render(scene, "path", {.params = {}, .iterations = 512}).image;
  for (const char* method : methods) {
    RenderOptions options = options_for(20000, 16, by_photons);
    options.params["radius"] = {0.3, {}};
    const auto b = bias_over_seeds(scene, method, options, 6, reference);
    EXPECT_LT(std::abs(b.mean), 0.03) << method << ": " << b.mean;
    EXPECT_LT(b.deviation, 0.006) << method;
  }
}

TEST(ProgressivePhotons, MeasuredDiscsLoseNoLightAtEdges) {
  // Even light to the border of a surface two metres wide.
  const Scene scene = load_scene("builtin:edge");
  for (const char* method : methods)
    for (const char* edges : {"disc", "measured"}) {
      RenderOptions options = options_for(3000, 8, by_photons);
      options.params["radius"] = {0.4, {}};
      options.params["edges"] = {std::string(edges), {}};
      options.resolution = {24, 24};
      const double bias = etendue::bias(render(scene, method, options).image, exact_image(scene, options.resolution));
      if (edges == std::string("disc"))
        EXPECT_LT(bias, -0.06) << method;
      else
        EXPECT_NEAR(bias, 0, 0.015) << method;
    }
}

TEST(ProgressivePhotons, SheetsKeepTheirLightBesideWallsOnEitherSide) {
  for (const float height : {0.6f, -0.6f}) {
    SCOPED_TRACE(height);
    RenderOptions options = options_for(40000, 8, by_photons);
    options.params["radius"] = {0.3, {}};
    options.resolution = testing::sheet_resolution;
    testing::expect_even_sheet(render(testing::sheet_beside_wall(height, false), "sppm", options).image);
  }
}

// Discs on a dark plate are cut at its outline; those on the bright floor, in the same pixels, are whole.
TEST(ProgressivePhotons, DarkEdgesDoNotBrightenWhatIsSeenBesideThem) {
  for (const float albedo : {0.0f, 0.02f}) {
    SceneBuilder b("dark plate");
    b.mesh(quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}), b.material(Diffuse{Rgb(0.7f)}));
    b.mesh(quad({-0.3f, 0.6f, 0.3f}, {0.3f, 0.6f, 0.3f}, {0.3f, 0.6f, -0.3f}, {-0.3f, 0.6f, -0.3f}),
           b.material(Diffuse{Rgb(albedo)}));
    b.light(DirectionalLight{{0, -1, 0}, Rgb(4)});
    b.max_depth(1);
    b.camera({0, 4, 1.5f}, {0, 0, 0}, 26, {24, 24});
    const Scene scene = b.finish();
    const auto mean = [&](const char* edges) {
      RenderOptions options = options_for(3000, 8, by_photons);
      options.params["radius"] = {0.2, {}};
      options.params["edges"] = {std::string(edges), {}};
      options.resolution = {24, 24};
      return testing::block_means(render(scene, "sppm", options).image, 24).front().y;
    };
    EXPECT_NEAR(mean("measured") / mean("disc"), 1, 0.002) << albedo;
  }
}

TEST(ProgressivePhotons, PhotonsThatWallsHideAreRefused) {
  // Two rooms on one floor, a wall of 4 cm between them; kernels narrower than that leak nothing.
  const Scene scene = load_scene("builtin:keyhole");
  const auto mean = [&](const char* name, const decltype(ParamValue::value)& value) {
    RenderOptions options = options_for(8000, 16, {{name, {value, {}}}});
    options.resolution = {48, 48};
    const Image image = render(scene, "sppm", options).image;
    return testing::block_means(image, 48).front().y;  // of the whole image
  };
  const double narrow = mean("radius", 0.03), leaking = mean("side_test", false), clear = mean("side_test", true);
  EXPECT_GT(leaking, 1.15 * narrow);
  EXPECT_LT(std::abs(clear - narrow), 0.4 * (leaking - narrow));
}

TEST(ProgressivePhotons, ErrorFallsPassByPass) {
  // Light off the centre, all by photons: blur and noise both.
  const Scene scene = load_scene("builtin:lambert-sphere-off-centre");
  for (const char* method : methods) {
    RenderOptions options = options_for(4000, 4, by_photons);
    const Image exact = exact_image(scene, options.resolution);
    const double after_4 = relmse(render(scene, method, options).image, exact);
    options.iterations = 64;
    const double after_64 = relmse(render(scene, method, options).image, exact);
    EXPECT_LT(after_64, after_4 / 3) << method;  // 16^(-2/3) = 0.16 in theory; fixed points keep their aliasing
    EXPECT_LT(after_64, 2e-2) << method;
  }
}

// Even light under water; a plate's shadow.
TEST(ProgressivePhotons, FirstKernelsAreWideWhereAPilotFindsPhotonsEven) {
  for (const auto& [name, neighbours] : {std::pair("builtin:water", 50), std::pair("builtin:hidden-occluder", 20)}) {
    const Scene scene = load_scene(name);
    const auto hash_of = [&](std::int64_t given) {
      RenderOptions options = options_for(0, 1, {{"neighbours", {given, {}}}});
      return render(scene, "sppm", options).hash;
    };
    EXPECT_EQ(hash_of(0), hash_of(neighbours)) << name;
    EXPECT_NE(hash_of(0), hash_of(70 - neighbours)) << name;
  }
}

TEST(ProgressivePhotons, DepthLimitTruncatesTheSeries) {
  const Scene scene = load_scene("builtin:lambert-sphere");
  for (const char* method : methods)
    for (const ParamMap& params : {ParamMap{}, by_photons})
      for (int depth = 1; depth <= 3; ++depth) {
        RenderOptions options = options_for(10000, 4, params);
        options.params["max_depth"] = {std::int64_t{depth}, {}};
        const Image image = render(scene, method, options).image;
        double mean = 0;
        for (const dvec3& p : image.pixels) mean += p.x / static_cast<double>(image.pixels.size());
        EXPECT_NEAR(mean * std::numbers::pi / (1 - std::pow(0.5, depth)), 1, 0.02) << depth << " " << method;
      }
}

TEST(ProgressivePhotons, WhiteFurnaceStaysWhite) {
  // Glass, mirror, plastic and white; direct light off the white parts, caustics by the others.
  for (const char* method : methods) {
    RenderOptions options = options_for(10000, 8);
    const auto b = bias_over_seeds(load_scene("builtin:white-furnace"), method, options, 4);
    EXPECT_LT(std::abs(b.mean), 0.01 + 4 * b.deviation) << method;
  }
}

TEST(ProgressivePhotons, SameBitsAtAnyThreadCount) {
  for (const char* name : {"builtin:cornell-spheres", "builtin:glossy-cornell-box"}) {
    const Scene scene = load_scene(name);
    for (const char* method : methods) testing::expect_same_bits_at_any_thread_count(scene, method, options_for(10000, 3));
  }
}

TEST(ProgressivePhotons, EveryParameterChangesTheImage) {
  const Scene rough = load_scene("builtin:veach-mis");
  const Scene spheres = load_scene("builtin:cornell-spheres");
  using Value = decltype(ParamValue::value);
  const auto made = [&](const Scene& scene, const char* method, const char* name, const Value& value) {
    RenderOptions options = options_for(2000, 6);
    options.resolution = {12, 12};
    options.params[name] = {value, {}};
    return render(scene, method, options);
  };
  const std::pair<const char*, Value> changes[] = {
      {"photons", std::int64_t{3000}},
      {"neighbours", std::int64_t{9}},
      {"radius", 0.05},
      {"direct", "photons"},
      {"kernel", "box"},
      {"side_test", false},
      {"edges", "disc"},
      {"further_paths", 20.0},
      {"max_depth", std::int64_t{2}},
      {"sampler", "independent"},
  };
  for (const char* method : methods) {
    const auto plain = made(spheres, method, "photons", std::int64_t{2000});
    for (const auto& [name, value] : changes)
      EXPECT_NE(made(spheres, method, name, value).hash, plain.hash) << method << " " << name;
    EXPECT_NE(made(rough, method, "carry_below", 0.01).hash, made(rough, method, "carry_below", 0.25).hash) << method;
    EXPECT_NE(made(rough, method, "lobe_tails", "followed").hash, made(rough, method, "lobe_tails", "gathered").hash) << method;
    for (const char* structure : point_structure_names)  // the order of photons, and so of sums, is theirs
      EXPECT_LT(relmse(made(spheres, method, "structure", structure).image, plain.image), 1e-8) << method << structure;
  }
  const auto by_pixels = [&](double photons) {
    RenderOptions options = options_for(0, 1, {{"photons_per_pixel", {photons, {}}}});
    options.resolution = {12, 12};
    return render(spheres, "sppm", options).hash;
  };
  EXPECT_EQ(by_pixels(1), by_pixels(2)) << "20000 at least";
  EXPECT_NE(by_pixels(1), by_pixels(200));
  for (const char* method : {"ppm", "sppm", "ppm-memoryless"})
    EXPECT_NE(made(spheres, method, "alpha", 0.5).hash, made(spheres, method, "alpha", 0.9).hash) << method;
  EXPECT_NE(made(spheres, "cppm", "hypothesis", "odd").hash, made(spheres, "cppm", "hypothesis", "even").hash);
  const auto with_beta = [&](double beta) {
    RenderOptions options = options_for(4000, 24, {{"beta", {beta, {}}}});
    options.resolution = {12, 12};
    return render(spheres, "cppm", options).hash;
  };
  EXPECT_NE(with_beta(1), with_beta(4)) << "felt from the second refusal on";
  EXPECT_NE(made(spheres, "ppm", "points", std::int64_t{1}).hash, made(spheres, "ppm", "points", std::int64_t{2}).hash);
}

}  // namespace
}  // namespace etendue
