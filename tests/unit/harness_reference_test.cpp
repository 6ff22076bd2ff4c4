// References of errors: closed forms over pixels, the agreement of two estimators, and the cache.
#include "experiments/run/closed_form.h"
#include "experiments/run/reference.h"
#include "experiments/statistics/agreement.h"
#include "framework/core/rng.h"
#include "framework/image/metrics.h"
#include "framework/io/image/exr.h"
#include "framework/io/load_scene.h"
#include "framework/scene/pixel_filter.h"
#include "tests/unit/silent_observer.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <filesystem>
#include <fstream>

namespace etendue {
namespace {

// 16 batches of noise around `level`, shifted in one corner.
BatchStatistics noisy_batches(std::uint64_t seed, double level, double corner_shift) {
  BatchStatistics statistics({32, 32});
  for (int batch = 0; batch < reference_batches; ++batch) {
    Image image({32, 32});
    Pcg32 rng(seed, static_cast<std::uint64_t>(batch));
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x)
        for (int c = 0; c < 3; ++c) image.at(x, y)[c] = level + rng.next_float() - 0.5 + (x < 4 && y < 4 ? corner_shift : 0);
    statistics.add(image);
  }
  return statistics;
}

TEST(Agreement, EqualMeansAgreeForEverySeedTried) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Agreement agreement = compare_means(noisy_batches(seed, 1, 0), noisy_batches(1000 + seed, 1, 0));
    EXPECT_EQ(agreement.verdict, Agreement::Verdict::agree) << agreement.text;
  }
}

TEST(Agreement, ShiftOfOneBlockIsFoundAndNamed) {
  const Agreement agreement = compare_means(noisy_batches(1, 1, 0), noisy_batches(2, 1, 0.2));
  EXPECT_EQ(agreement.verdict, Agreement::Verdict::disagree) << agreement.text;
  EXPECT_NE(agreement.text.find("block (0, 0)"), std::string::npos) << agreement.text;
  EXPECT_TRUE(agreement.first_lacks);
  EXPECT_FALSE(compare_means(noisy_batches(1, 1, 0.2), noisy_batches(2, 1, 0)).first_lacks);
  EXPECT_FALSE(compare_means(noisy_batches(1, 1, 0), noisy_batches(2, 1, 0)).first_lacks);
}

TEST(Agreement, ShiftOfTheWholeImageIsFound) {
  EXPECT_EQ(compare_means(noisy_batches(1, 1, 0), noisy_batches(2, 1.02, 0)).verdict, Agreement::Verdict::disagree);
}

TEST(Agreement, ConstantsAgreeWithinTheMarginOnly) {
  const auto constant = [](double level) {
    BatchStatistics statistics({8, 8});
    for (int i = 0; i < reference_batches; ++i) {
      Image image({8, 8});
      for (dvec3& pixel : image.pixels) pixel = dvec3(level);
      statistics.add(image);
    }
    return statistics;
  };
  EXPECT_EQ(compare_means(constant(1), constant(1.0001)).verdict, Agreement::Verdict::agree);
  EXPECT_EQ(compare_means(constant(1), constant(1.01)).verdict, Agreement::Verdict::disagree);
}

TEST(Agreement, MeanVarianceIsThatOfTheMean) {
  // Uniform noise of width 1 has variance 1/12, its mean over 16 batches 1/192.
  const BatchStatistics noisy = noisy_batches(3, 1, 0);
  EXPECT_NEAR(noisy.mean_variance(), 1.0 / 192, 0.1 / 192);
  EXPECT_NEAR(noisy.relative_variance(noisy.mean()) * (1 + relmse_epsilon), 1.0 / 192, 0.1 / 192);
}

TEST(ClosedForm, IsIntegratedOverEachPixel) {
  Scene scene = load_scene("builtin:lambert-sphere");
  // Radiance linear in the direction's x: its mean over a pixel of a narrow view is its value at the centre.
  scene.camera.fov = 0.01f;
  scene.closed_form = {"linear", [](const Ray& ray) { return dvec3(ray.direction.x, 1, 0); }};
  const Image image = integrate_closed_form(scene, {4, 4});
  const Ray centre = scene.camera.ray({4, 4}, {2.5f, 1.5f}, {0.5f, 0.5f});
  EXPECT_NEAR(image.at(2, 1).x, centre.direction.x, 1e-6);
  EXPECT_NEAR(image.at(2, 1).y, 1, 1e-14);
  // A step: half of the film is lit, and the step lies inside a pixel.
  const float step = scene.camera.ray({5, 5}, {2.25f, 2.5f}, {0.5f, 0.5f}).direction.x;
  const float right = scene.camera.ray({5, 5}, {4.5f, 2.5f}, {0.5f, 0.5f}).direction.x;
  scene.closed_form = {"step", [=](const Ray& ray) { return dvec3((ray.direction.x > step) == (right > step) ? 1 : 0); }};
  EXPECT_NEAR(integrate_closed_form(scene, {5, 5}).at(2, 2).x, 0.75, 0.01);
}

TEST(ClosedForm, WithoutAFiniteValueIsNoReference) {
  Scene scene = load_scene("builtin:lambert-sphere");
  scene.closed_form = {"a root", [](const Ray& ray) { return dvec3(std::sqrt(static_cast<double>(ray.direction.x))); }};
  const SceneNeeds needs = scene_needs(scene);
  const Reference made = make_reference({scene, needs, "room", {4, 4}, {}}, ReferenceCache::standard(""));
  EXPECT_NE(made.failure.find("no reference of room: its closed form has no finite value in"), std::string::npos)
      << made.failure;
  EXPECT_TRUE(made.rendered.image.pixels.empty());
}

class ReferenceFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = (std::filesystem::temp_directory_path() / ("etendue-reference-" + std::to_string(getpid()) + "-" +
                                                            ::testing::UnitTest::GetInstance()->current_test_info()->name()))
                     .string();
    std::filesystem::remove_all(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  Reference make(const ReferenceChoice& choice, ivec2 resolution, const char* name = "builtin:cornell-box") {
    const Scene scene = load_scene(name);
    return make_reference({scene, scene_needs(scene), name, resolution, choice, 2}, ReferenceCache({directory_}));
  }

  std::string directory_;
};

// The narration tells the samples that each of the sixteen batches has, one at least.
TEST_F(ReferenceFiles, NarrationTellsTheSamplesThatAreRendered) {
  struct : SilentObserver {
    std::string lines;
    void narrate(const std::string& line) override { lines += line + '\n'; }
  } observer;
  const Scene scene = load_scene("builtin:cornell-box");
  const ReferenceChoice choice{ReferenceChoice::Kind::samples, 4, {}, {}};
  make_reference({scene, scene_needs(scene), "box", {8, 8}, choice, 1, &observer}, ReferenceCache({directory_}));
  EXPECT_NE(observer.lines.find("16 samples per pixel of path"), std::string::npos) << observer.lines;
  EXPECT_EQ(observer.lines.find(" 4 samples per pixel of"), std::string::npos) << observer.lines;
  EXPECT_EQ(observer.lines.find(" 1 samples per pixel of"), std::string::npos) << observer.lines;
}

TEST_F(ReferenceFiles, RenderedOnceThenCachedWithItsChecks) {
  const ReferenceChoice choice{ReferenceChoice::Kind::samples, 32, {}, {}};
  const Reference first = make(choice, {16, 16});
  EXPECT_EQ(first.failure, "");
  EXPECT_GT(first.rendered.mse_floor, 0);
  EXPECT_GT(first.rendered.relmse_floor, 0);
  EXPECT_NE(first.rendered.checks.find("agree"), std::string::npos);
  const Reference second = make(choice, {16, 16});
  EXPECT_EQ(second.rendered.mse_floor, first.rendered.mse_floor);
  EXPECT_EQ(second.rendered.relmse_floor, first.rendered.relmse_floor);
  EXPECT_EQ(second.rendered.checks, first.rendered.checks);
  EXPECT_EQ(second.rendered.image.pixels, first.rendered.image.pixels);  // to the bit

  // A quarter of the size is served from the same file; averaging 16 pixels leaves a sixteenth of the variance.
  const Reference small = make({ReferenceChoice::Kind::samples, 500, {}, {}}, {4, 4});
  EXPECT_NEAR(small.rendered.mse_floor, first.rendered.mse_floor / 16, 1e-12);
  double mean = 0;
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) mean += first.rendered.image.at(x, y).x / 16;
  EXPECT_NEAR(small.rendered.image.at(0, 0).x, mean, 1e-6);
}

// Bidirectional paths trace more rays for more noise there: they check alone.
TEST_F(ReferenceFiles, TheMoreEfficientEstimatorHasTheSamples) {
  const Scene scene = load_scene("builtin:cornell-box");
  const SceneNeeds needs = scene_needs(scene);
  const ReferenceRequest request{scene, needs, "box", {16, 16}, {}, 1};
  const RenderedReference rendered = render_reference(request, 64).rendered;
  EXPECT_NE(rendered.source.find("of path (64 samples per pixel) and"), std::string::npos) << rendered.source;
  EXPECT_TRUE(rendered.source.ends_with("of bdpt sampler=independent (16)")) << rendered.source;
  ReferenceRequest threads = request;
  threads.threads = 3;
  EXPECT_EQ(render_reference(threads, 64).rendered.image.pixels, rendered.image.pixels);
}

TEST_F(ReferenceFiles, CachedOneOfFewerSamplesIsNotServed) {
  make({ReferenceChoice::Kind::samples, 32, {}, {}}, {16, 16});
  const ReferenceCache cache({directory_});
  const Scene scene = load_scene("builtin:cornell-box");
  const auto found = cache.find(scene, {16, 16}, 32);
  ASSERT_TRUE(found);
  EXPECT_GE(found->samples, 32u);
  EXPECT_FALSE(cache.find(scene, {16, 16}, found->samples + 1));
}

TEST_F(ReferenceFiles, LargerOneOfAFilteredSceneIsNotServed) {
  Scene scene = load_scene("builtin:cornell-box");
  const ReferenceCache cache({directory_});
  for (const char* filter : {"box", "gaussian"}) {
    scene.filter = make_pixel_filter(named_filter(filter));
    ASSERT_TRUE(cache.store(scene, {Image({16, 16}), 0, 32, "a test", "agree"}));
    EXPECT_TRUE(cache.find(scene, {16, 16}, 32)) << filter;
    EXPECT_EQ(cache.find(scene, {4, 4}, 32).has_value(), !scene.filter) << filter;
  }
}

TEST_F(ReferenceFiles, ClosedFormComesFirst) {
  const Reference reference = make({}, {8, 8}, "builtin:furnace");
  EXPECT_TRUE(reference.rendered.source.starts_with("closed form"));
  EXPECT_EQ(reference.rendered.mse_floor, 0);
}

TEST_F(ReferenceFiles, ExactWithoutClosedFormIsAnError) {
  EXPECT_THROW(make({ReferenceChoice::Kind::exact, 0, {}, {"x.toml", 3, 1}}, {8, 8}), Error);
}

TEST_F(ReferenceFiles, GivenFileMustFit) {
  std::filesystem::create_directories(directory_);
  const std::string file = directory_ + "/given.exr";
  Image image({8, 8});
  image.at(0, 0) = dvec3(4);
  write_exr(file, image);
  const ReferenceChoice choice{ReferenceChoice::Kind::file, 0, {file}, {}};
  EXPECT_EQ(make(choice, {8, 8}).rendered.image.at(0, 0).x, 4);
  EXPECT_EQ(make(choice, {4, 4}).rendered.image.at(0, 0).x, 1);
  EXPECT_THROW(make(choice, {6, 6}), Error);
  Scene filtered = load_scene("builtin:cornell-box");
  filtered.filter = make_pixel_filter(named_filter("gaussian"));
  const auto make_filtered = [&](ivec2 resolution) {
    return make_reference({filtered, scene_needs(filtered), "filtered", resolution, choice, 1}, ReferenceCache({directory_}));
  };
  EXPECT_EQ(make_filtered({8, 8}).rendered.image.at(0, 0).x, 4);
  EXPECT_THROW(make_filtered({4, 4}), Error) << "a mean is a box filter's";
  image.at(1, 0).y = std::numeric_limits<double>::quiet_NaN();
  write_exr(file, image);
  EXPECT_THROW(make(choice, {8, 8}), Error) << "no error is measured against what is no number";
}

TEST_F(ReferenceFiles, DamagedCacheFileIsIgnored) {
  const Scene scene = load_scene("builtin:cornell-box");
  std::filesystem::create_directories(directory_);
  std::ofstream(directory_ + "/" + ReferenceCache::key(scene, {8, 8}) + ".exr") << "not an image";
  EXPECT_FALSE(ReferenceCache({directory_}).find(scene, {8, 8}, 0).has_value());
}

TEST_F(ReferenceFiles, EveryFlippedBitIsNoticed) {
  RenderedReference made{Image({3, 2}), 0.25, 64, "by hand", "agree"};
  for (dvec3& pixel : made.image.pixels) pixel = dvec3(0.1f, 0.7f, 3);
  std::filesystem::create_directories(directory_);
  const std::string file = directory_ + "/r.exr";
  write_exr(file, made.image, reference_attributes(made));
  std::string bytes;
  {
    std::ifstream in(file, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  EXPECT_EQ(read_reference(file).checks, "agree");
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string flipped = bytes;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
    std::ofstream(file, std::ios::binary) << flipped;
    try {
      // Bits of no consequence (of the header's view of the screen) may differ; what is read may not.
      const RenderedReference read = read_reference(file);
      if (read.checks.empty()) continue;
      EXPECT_TRUE(read.image.pixels == made.image.pixels && read.mse_floor == made.mse_floor &&
                  read.relmse_floor == made.relmse_floor && read.samples == made.samples && read.source == made.source &&
                  read.checks == made.checks)
          << "bit " << bit;
    } catch (const Error&) {
    }
  }
}

TEST(Estimators, AreTwoAndSuitTheScene) {
  constexpr const char* scenes[] = {"builtin:cornell-spheres", "builtin:veach-mis", "builtin:mirror"};
  for (const char* name : scenes) {
    const Scene scene = load_scene(name);
    const EstimatorPair pair = choose_estimators(scene, scene_needs(scene), {16, 16});
    const bool caustics_of_a_point = scene.name == "builtin:mirror";
    EXPECT_EQ(pair.first.label(), caustics_of_a_point ? "bdpt" : "path") << name;
    EXPECT_NE(pair.second.label(), pair.first.label()) << name;
    EXPECT_EQ(pair.second_checks_only, caustics_of_a_point) << name;
    EXPECT_EQ(choose_estimators(scene, scene_needs(scene), {16, 16}, true).second_checks_only, name != scenes[1])
        << name << ", of which a pilot says that it hides light";
  }
}

// A lamp that no path meets behind glass, and its light on the floor, which is seen by way of glass as well: both path tracers
// leave the image black, and agree.
TEST_F(ReferenceFiles, WhatBothPathTracersMissIsToldOf) {
  const ReferenceChoice choice{ReferenceChoice::Kind::samples, 64, {}, {}};
  const Reference black = make(choice, {16, 16}, "builtin:veiled-lamp?seen=through,radius=0.0005");
  const bool unproven = black.rendered.checks.find(undecided) != std::string::npos;
  EXPECT_TRUE(unproven || !black.failure.empty()) << black.rendered.checks;
  const Image exact = integrate_closed_form(load_scene("builtin:veiled-lamp?seen=through,radius=0.0005"), {16, 16});
  if (unproven) {
    EXPECT_GT(black.rendered.relmse_floor, 0.5 * relmse(black.rendered.image, exact));
  }
}

// A point light's caustic has a reference where it is seen directly, and none where a mirror shows it.
TEST_F(ReferenceFiles, CausticsOfPointLightsAreJudgedByMerging) {
  const ReferenceChoice choice{ReferenceChoice::Kind::samples, 16, {}, {}};
  const Reference seen = make(choice, {16, 16}, "builtin:mirror");
  EXPECT_EQ(seen.failure, "");
  const Scene scene = load_scene("builtin:mirror");
  EXPECT_NEAR(bias(seen.rendered.image, integrate_closed_form(scene, {16, 16})), 0, 0.03);
  const Reference hidden = make(choice, {16, 16}, "builtin:mirror?view=mirror");
  EXPECT_NE(hidden.failure.find("only merging finds"), std::string::npos) << hidden.failure;
  // A radius that finds less of it is not asked, since it is the check that is brighter.
  EXPECT_NE(hidden.failure.find("bdpt and vcm paths=65536 sampler=independent disagree"), std::string::npos) << hidden.failure;
}

}  // namespace
}  // namespace etendue
