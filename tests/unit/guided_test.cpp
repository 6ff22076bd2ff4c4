// The pieces of path guiding: directional quadtree, spatio-directional tree, blocks of samples.
#include "experiments/statistics/statistics.h"
#include "framework/core/parallel.h"
#include "framework/core/sampler.h"
#include "framework/core/sampling.h"
#include "integrators/guiding/image_blocks.h"
#include "integrators/guiding/sd_tree.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

// Flux that falls off around a direction, with a share spread evenly; refined three times, as blocks do.
DirectionTree lobed_tree() {
  Sampler sampler(SamplerKind::sobol, 3, Stream::test, 0, 0);
  DirectionTree tree;
  const vec3 axis = glm::normalize(vec3(0.3f, -0.5f, 0.6f));
  for (int round = 0; round < 4; ++round) {
    for (std::uint32_t i = 0; i < 20000; ++i) {
      Sampler s(SamplerKind::sobol, 3, Stream::test, static_cast<std::uint64_t>(round), i);
      const vec3 direction = sample_unit_sphere(s.get_2d());
      tree.add(square_from_direction(direction), 0.05f + std::pow(std::max(0.0f, glm::dot(direction, axis)), 40.0f));
    }
    if (round < 3) tree = tree.refined(0.01f);
  }
  return tree;
}

TEST(DirectionTree, SquareAndSphereAreInverse) {
  for (std::uint32_t i = 0; i < 1000; ++i) {
    Sampler sampler(SamplerKind::sobol, 1, Stream::test, 0, i);
    const vec2 square = sampler.get_2d();
    const vec3 direction = direction_from_square(square);
    EXPECT_NEAR(glm::length(direction), 1, 1e-5);
    // phi loses its digits towards the poles.
    EXPECT_LT(glm::length(square_from_direction(direction) - square) * safe_sqrt(1 - direction.z * direction.z), 1e-5) << i;
  }
}

TEST(DirectionTree, DensityIntegratesToOne) {
  const DirectionTree learnt = lobed_tree();
  EXPECT_GT(learnt.size(), 20u);
  const DirectionDensity tree(learnt);
  double sum = 0;
  constexpr int n = 512;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) sum += tree.density((vec2(x, y) + 0.5f) / float(n)) / double(n * n);
  EXPECT_NEAR(sum, 1, 1e-4);
  EXPECT_EQ(DirectionDensity().density({0.3f, 0.7f}), 1);
}

TEST(DirectionTree, SamplesFollowTheDensity) {
  const DirectionDensity tree(lobed_tree());
  constexpr int n = 16, samples = 200000;
  std::vector<double> seen(n * n, 0), expected(n * n, 0);
  for (std::uint32_t i = 0; i < samples; ++i) {
    Sampler sampler(SamplerKind::independent, 7, Stream::test, i, 0);
    const auto [square, density] = tree.sample(sampler.get_2d());
    ASSERT_TRUE(square.x >= 0 && square.x < 1 && square.y >= 0 && square.y < 1);
    EXPECT_NEAR(density / tree.density(square), 1, 1e-4);
    ++seen[static_cast<std::size_t>(square.y * n) * n + static_cast<std::size_t>(square.x * n)];
  }
  constexpr int fine = 32;
  for (int y = 0; y < n * fine; ++y)
    for (int x = 0; x < n * fine; ++x)
      expected[static_cast<std::size_t>(y / fine) * n + x / fine] +=
          samples * double(tree.density((vec2(x, y) + 0.5f) / float(n * fine))) / (n * fine * n * fine);
  double chi_squared = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    ASSERT_GT(expected[i], 5);
    chi_squared += (seen[i] - expected[i]) * (seen[i] - expected[i]) / expected[i];
  }
  // Chi-square of 255 degrees of freedom: mean 255, deviation sqrt(510); beyond 3.7 deviations once in ten thousand.
  EXPECT_LT(chi_squared, 255 + 3.7 * std::sqrt(510.0));
}

TEST(DirectionTree, RefinesWhereTheFluxIsAndEmptiesWhatItCopies) {
  DirectionTree tree;
  for (int i = 0; i < 100; ++i) tree.add({0.1f, 0.1f}, 1);
  DirectionTree refined = tree.refined(0.01f);
  EXPECT_EQ(refined.flux(), 0);
  EXPECT_GT(refined.size(), 4u);
  refined.add({0.1f, 0.1f}, 1);
  refined.add({0.9f, 0.9f}, 1);
  const DirectionDensity density(refined);
  EXPECT_GT(density.density({0.1f, 0.1f}), 8);
  EXPECT_NEAR(density.density({0.6f, 0.6f}), 2, 1e-6) << "an undivided quadrant with half of the flux";
  EXPECT_EQ(density.density({0.1f, 0.9f}), 0);
  EXPECT_EQ(tree.refined(1.0f).size(), 1u) << "no quadrant has more than all";
}

// An event at a diffuse surface that scatters evenly, all of its light found by the path itself.
GuideRecord record_of(std::uint32_t leaf, const vec2& square, float cosine, float radiance, float pdf, float pdf_bsdf,
                      float pdf_guide) {
  return {.leaf = leaf,
          .square = square,
          .cosine = cosine,
          .radiance = radiance,
          .gathered = radiance,
          .scattered = 1,
          .albedo = 0.5f,
          .pdf = pdf,
          .pdf_bsdf = pdf_bsdf,
          .pdf_guide = pdf_guide};
}

// The guide that a place learns in two blocks of the same records.
const Guide& learnt(SdTree& tree, const std::vector<std::vector<GuideRecord>>& records, std::uint32_t leaf) {
  for (int block = 0; block < 2; ++block) {
    tree.learn(records);
    tree.refine(1);
  }
  return tree.guide(leaf);
}

// Records of light from above in the left half of a box, from below in the right one.
std::vector<std::vector<GuideRecord>> records_of_a_box(const SdTree& tree, std::size_t count) {
  std::vector<std::vector<GuideRecord>> records(8);
  for (std::uint32_t i = 0; i < count; ++i) {
    Sampler sampler(SamplerKind::independent, 5, Stream::test, i, 0);
    const vec2 a = sampler.get_2d(), b = sampler.get_2d();
    const vec3 position(a.x * 2 - 1, a.y * 2 - 1, sampler.get_1d() * 2 - 1);
    const vec3 direction = sample_unit_sphere(b);
    const bool lit = (position.x < 0) == (direction.z > 0.5f) && std::abs(direction.z) > 0.5f;
    const float uniform = 1 / (4 * pi);
    const vec3 normal(1, 0, 0);
    const vec2 square = square_from_direction(direction);
    const std::uint32_t leaf = tree.leaf_to_teach(tree.leaf(position, normal), position, normal, square);
    records[i % 8].push_back(record_of(leaf, square, std::abs(direction.x), lit ? 1 : 0, uniform, uniform, uniform));
  }
  return records;
}

TEST(SdTree, LearnsWhatDiffersFromPlaceToPlace) {
  const Bounds bounds{vec3(-1), vec3(1)};
  SdTree tree(bounds, {.split = 2000});
  const auto at = [&](const vec3& position, const vec3& normal) -> const Guide& {
    return tree.guide(tree.leaf(position, normal));
  };
  EXPECT_EQ(at(vec3(0), {1, 0, 0}).bsdf_share(true), 1) << "nothing learnt yet";
  for (int block = 0; block < 3; ++block) {
    tree.learn(records_of_a_box(tree, 40000));
    tree.refine(1);
  }
  EXPECT_GT(tree.leaves(), 8u);
  const auto& left = at({-0.5f, 0.2f, 0.3f}, {0.9f, 0.1f, 0.1f}).directions();
  const auto& right = at({0.5f, 0.2f, 0.3f}, {0.9f, 0.1f, 0.1f}).directions();
  const float even = 1 / (4 * pi);
  EXPECT_GT(left.pdf_solid_angle({0.6f, 0, 0.8f}), 2 * even);
  EXPECT_LT(left.pdf_solid_angle({0.6f, 0, -0.8f}), 0.1f * even);
  EXPECT_GT(right.pdf_solid_angle({0.6f, 0, -0.8f}), 2 * even);
  EXPECT_LT(at({0.5f, 0, 0}, {1, 0, 0}).bsdf_share(true), 1);
  EXPECT_EQ(at({0.5f, 0, 0}, {-1, 0, 0}).bsdf_share(true), 1) << "no record looks that way";
  EXPECT_EQ(tree.leaf({7, 7, 7}, {1, 0, 0}), tree.leaf({1, 1, 1}, {1, 0, 0})) << "beyond the box: the nearest place";
  // A quarter of the sphere scatters 1 each over 4 pi, per albedo of 0.5.
  EXPECT_NEAR(at({0.5f, 0, 0}, {1, 0, 0}).indirect(), 0.25f * 4 * pi / 0.5f, 0.6f);
}

TEST(SdTree, DependsOnNoThread) {
  float first = 0;
  std::size_t leaves = 0;
  for (const int threads : {1, 2, 3}) {
    SdTree tree({vec3(-1), vec3(1)}, {.split = 500, .stochastic = true});
    with_threads(threads, [&] {
      for (int block = 0; block < 3; ++block) {
        tree.learn(records_of_a_box(tree, 20000));
        tree.refine(1);
      }
    });
    float sum = 0;
    for (std::uint32_t i = 0; i < 500; ++i) {
      Sampler sampler(SamplerKind::sobol, 1, Stream::test, 0, i);
      const vec3 position = sample_unit_sphere(sampler.get_2d());
      const Guide& guide = tree.guide(tree.leaf(position, {1, 0, 0}));
      sum += guide.directions().density(sampler.get_2d()) + guide.bsdf_share(true) + guide.indirect();
    }
    if (threads == 1) {
      first = sum;
      leaves = tree.leaves();
    }
    EXPECT_EQ(sum, first) << threads;
    EXPECT_EQ(tree.leaves(), leaves) << threads;
  }
}

// Where the guide's density is the integrand's and the BSDF's is not, the learnt share is the least, and the other way round.
TEST(SdTree, LearnsWhomToTrust) {
  for (const bool guide_is_right : {true, false}) {
    SdTree tree({vec3(-1), vec3(1)}, {.split = 1e9f});
    const std::uint32_t leaf = tree.leaf(vec3(0), {0, 0, 1});
    std::vector<std::vector<GuideRecord>> records(1);
    const float even = 1 / (4 * pi);
    for (std::uint32_t i = 0; i < 2000; ++i) {
      Sampler sampler(SamplerKind::sobol, 1, Stream::test, 0, i);
      const vec3 direction = sample_unit_sphere(sampler.get_2d());
      const float right = direction.z > 0 ? 2 * even : 0;
      records[0].push_back(record_of(leaf, square_from_direction(direction), std::abs(direction.z), right / even, even,
                                     guide_is_right ? even : right, guide_is_right ? right : even));
    }
    EXPECT_EQ(learnt(tree, records, leaf).bsdf_share(true), guide_is_right ? bsdf_shares.front() : bsdf_shares.back());
  }
}

// Nine tenths of the light in a sixteenth of the sphere, where the guide looks; a tenth in a 256th, where it never does. With
// the BSDF even over the sphere, the second moment at share s is 12.96 / (16 - 15 s) + 2.56 / s, least near 0.66.
TEST(SdTree, LearnsToGuardAgainstWhatTheGuideDoesNotKnow) {
  SdTree tree({vec3(-1), vec3(1)}, {.split = 1e9f});
  const std::uint32_t leaf = tree.leaf(vec3(0), {0, 0, 1});
  std::vector<std::vector<GuideRecord>> records(1);
  const float even = 1 / (4 * pi), known = 1 / 16.0f, unknown = known + 1 / 256.0f;
  constexpr int count = 1 << 12;
  for (int i = 0; i < count; ++i) {
    // Half of the directions are from each.
    const float u = (static_cast<float>(i / 2) + 0.5f) / (count / 2.0f), x = i % 2 == 0 ? u : u * known;
    const float pdf_guide = x < known ? even / known : 0, pdf = 0.5f * (even + pdf_guide);
    const float radiance = x < known ? 0.9f * 16 : x < unknown ? 0.1f * 256 : 0;
    records[0].push_back(record_of(leaf, {x, 0.5f}, 1, radiance, pdf, even, pdf_guide));
  }
  EXPECT_EQ(learnt(tree, records, leaf).bsdf_share(true), 0.7f);
}

TEST(SdTree, LeavesOutWhatIsNotFinite) {
  SdTree clean({vec3(-1), vec3(1)}, {.split = 1e9f}), spoilt = clean;
  const std::uint32_t leaf = clean.leaf(vec3(0), {1, 0, 0});
  auto records = records_of_a_box(clean, 1000);
  const Guide& expected = learnt(clean, records, leaf);
  for (const float faulty : {infinity, std::numeric_limits<float>::quiet_NaN()}) {
    GuideRecord bright = records[0].front(), strange = bright;
    bright.radiance = bright.gathered = strange.scattered = faulty;
    records[0].push_back(bright);
    records[0].push_back(strange);
  }
  const Guide& guide = learnt(spoilt, records, leaf);
  EXPECT_EQ(guide.indirect(), expected.indirect());
  EXPECT_EQ(guide.bsdf_share(true), expected.bsdf_share(true));
  EXPECT_EQ(guide.directions().density({0.9f, 0.5f}), expected.directions().density({0.9f, 0.5f}));
}

TEST(ImageBlocks, BlocksAreTwoFourEightSamples) {
  std::vector<std::uint32_t> begins;
  for (std::uint32_t i = 0; i < 40; ++i)
    if (ImageBlocks::begins_block(i)) begins.push_back(i);
  EXPECT_EQ(begins, (std::vector<std::uint32_t>{0, 2, 6, 14, 30}));
  EXPECT_EQ(ImageBlocks::block_of(5), 1u);
  EXPECT_EQ(ImageBlocks::block_of(6), 2u);
  EXPECT_EQ(ImageBlocks::block_samples(2), 8u);
}

// Samples around 1 whose deviation falls tenfold after the first blocks.
double error_of(BlockCombination combination) {
  const ivec2 size(32);
  ImageBlocks blocks(size, combination);
  Film film(size);
  for (std::uint32_t i = 0; i < 30; ++i) {
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        Sampler sampler(SamplerKind::independent, 11, Stream::test, static_cast<std::uint64_t>(y * size.x + x), i);
        const float deviation = i < 14 ? 1.0f : 0.1f;
        blocks.add({x, y}, Rgb(1 + deviation * (sampler.get_1d() < 0.5f ? -1.0f : 1.0f)));
      }
    blocks.end_sample(i, film);
  }
  double sum = 0;
  for (const dvec3& p : film.mean().pixels) sum += (p.x - 1) * (p.x - 1) / double(size.x * size.y);
  return sum;
}

TEST(ImageBlocks, WeighsBlocksByTheInverseOfTheirVariance) {
  // 16 samples of variance 0.01 after 14 of variance 1: 1 / (14 / 1 + 16 / 0.01), and (14 + 0.16) / 30^2 for the mean.
  EXPECT_NEAR(error_of(BlockCombination::inverse_variance) / (1 / 1614.0), 1, 0.15);
  EXPECT_NEAR(error_of(BlockCombination::mean) / (14.16 / 900), 1, 0.15);
}

// Light that one sample in 64 finds counts in full on average, whichever blocks found it. Weights from a pixel's own samples
// lose 22 % of it.
TEST(ImageBlocks, LosesNoRareLight) {
  const ivec2 size(8);
  double sum = 0;
  constexpr int images = 1000;
  for (std::uint64_t image = 0; image < images; ++image) {
    ImageBlocks blocks(size, BlockCombination::inverse_variance);
    Film film(size);
    for (std::uint32_t i = 0; i < 14; ++i) {
      for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
          Sampler sampler(SamplerKind::independent, image, Stream::test, static_cast<std::uint64_t>(y * size.x + x), i);
          blocks.add({x, y}, Rgb(sampler.get_1d() < 1 / 64.0f ? 64.0f : 0.0f));
        }
      blocks.end_sample(i, film);
    }
    for (const dvec3& p : film.mean().pixels) sum += p.x / (images * size.x * size.y);
  }
  EXPECT_NEAR(sum, 1, 0.05);  // of a standard error of 0.01
}

TEST(ImageBlocks, LastKeepsTheRunningBlockOnly) {
  const ivec2 size(1);
  ImageBlocks blocks(size, BlockCombination::last);
  Film film(size);
  for (std::uint32_t i = 0; i < 5; ++i) {
    blocks.add({0, 0}, Rgb(float(i)));
    blocks.end_sample(i, film);
    EXPECT_EQ(film.mean().at(0, 0).x, (std::array{0.0, 0.5, 2.0, 2.5, 3.0}[i])) << i;
  }
}

}  // namespace
}  // namespace etendue
