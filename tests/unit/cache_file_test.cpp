// Caches on disk: the same image as a fresh cache, other views, and files that must be refused.
#include "integrators/cache_file.h"
#include "framework/core/sampler.h"
#include "integrators/irradiance_cache_file.h"
#include "integrators/registry.h"
#include "tests/scene_context.h"
#include "tests/unit/harness_process.h"

#include "framework/image/metrics.h"
#include "framework/io/load_scene.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using testing::SceneContext;

constexpr ivec2 size{24, 24};
const Location here{"test.cache"};

ParamMap params(std::initializer_list<std::pair<const char*, const char*>> given) {
  ParamMap map;
  map["samples"] = parse_param_value("32", {});
  for (const auto& [name, value] : given) map[name] = parse_param_value(value, {});
  return map;
}

struct CacheRun {
  std::uint64_t hash = 0;
  std::uint64_t records = 0;
  Image image;
  std::string cache;  // as saved in the end
};

CacheRun render_with(const Scene& scene, const ParamMap& map, std::uint32_t iterations, const std::string& loaded = {},
                     int threads = 1, ivec2 resolution = size, const std::string& name = "irradiance-cache") {
  SceneContext scope(scene, resolution);
  const auto integrator = find_integrator(name, {}).make(map);
  Film film(resolution);
  CacheRun result;
  with_threads(threads, [&] {
    if (!loaded.empty()) integrator->savable_cache()->load(scope.context, loaded, here);
    integrator->prepare(scope.context);
    for (std::uint32_t i = 0; i < iterations; ++i) integrator->iteration(scope.context, i, film);
    result.cache = integrator->savable_cache()->save(scope.context);
    result.records = integrator->record_discs()->size();
  });
  result.hash = film.hash();
  result.image = film.mean();
  return result;
}

Scene moved(Scene scene) {
  scene.camera.fov *= 0.9f;
  return scene;
}

// What the error says; "" where nothing was thrown.
template <class Action>
std::string refusal(const Action& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(SavedCache, GivesTheSameImageAsAFreshOne) {
  const Scene scene = load_scene("builtin:cornell-box");
  for (const auto& map : {params({{"refine", "false"}}), params({{"refine", "false"}, {"records", "60"}}),
                          params({{"refine", "false"}, {"metric", "occlusion-hessian"}, {"fill", "records"}})}) {
    const CacheRun fresh = render_with(scene, map, 3);
    const CacheRun loaded = render_with(scene, map, 3, fresh.cache, 2);
    EXPECT_EQ(fresh.hash, loaded.hash);
    EXPECT_EQ(fresh.cache, loaded.cache);
  }
}

TEST(SavedCache, GoesOnWhereItsRefinementStood) {
  const Scene scene = load_scene("builtin:cornell-box");
  const CacheRun half = render_with(scene, params({}), 8);
  EXPECT_EQ(half.cache, render_with(scene, params({}), 0, half.cache).cache);
  const CacheRun on = render_with(scene, params({}), 4, half.cache), again = render_with(scene, params({}), 4, half.cache, 3);
  EXPECT_EQ(on.hash, again.hash);
  EXPECT_EQ(on.cache, again.cache);
  EXPECT_GE(on.records, half.records);
  // With camera samples of its own: the means of both are of twice as many.
  EXPECT_GT(mse(render_with(scene, params({}), 8, half.cache).image, half.image), 1e-3);
}

TEST(SavedCache, HoldsRadianceToo) {
  const Scene scene = load_scene("builtin:glossy-cornell-box?alpha=0.6"), other = moved(scene);
  const auto run = [](const Scene& of, std::initializer_list<std::pair<const char*, const char*>> given,
                      std::uint32_t iterations, const std::string& loaded = {}, int threads = 1) {
    return render_with(of, params(given), iterations, loaded, threads, size, "radiance-cache");
  };
  const CacheRun fresh = run(scene, {{"refine", "false"}}, 3), loaded = run(scene, {{"refine", "false"}}, 3, fresh.cache, 2);
  EXPECT_EQ(fresh.hash, loaded.hash);
  EXPECT_EQ(fresh.cache, loaded.cache);
  const CacheRun half = run(scene, {}, 8), on = run(scene, {}, 4, half.cache), again = run(scene, {}, 4, half.cache, 3);
  EXPECT_EQ(on.hash, again.hash);
  EXPECT_EQ(on.cache, again.cache);
  EXPECT_GE(on.records, half.records);
  const CacheRun reused = run(other, {{"refine", "false"}}, 8, fresh.cache);
  EXPECT_LT(relmse(reused.image, run(other, {{"refine", "false"}}, 8).image), 2e-2);
  EXPECT_NE(refusal([&] {
              run(scene, {{"order", "4"}}, 1, half.cache);
            }).find("made with order=5, not with 4"),
            std::string::npos);
  EXPECT_NE(refusal([&] { render_with(scene, params({}), 1, half.cache); }).find("radiance-cache"), std::string::npos);
  const Scene diffuse = load_scene("builtin:cornell-box");  // with nothing rough in it
  const CacheRun plain = run(diffuse, {{"refine", "false"}}, 2);
  EXPECT_EQ(plain.hash, run(diffuse, {{"refine", "false"}}, 2, plain.cache).hash);
}

TEST(SavedCache, OfAGivenNumberOfRecordsKeepsThatNumber) {
  const Scene scene = load_scene("builtin:cornell-box");
  const CacheRun few = render_with(scene, params({{"records", "6"}}), 40);
  EXPECT_LE(few.records, 6u);
  EXPECT_EQ(render_with(scene, params({{"records", "6"}}), 40, few.cache).records, few.records);
}

TEST(SavedCache, HasNoHolesAtACoarserAccuracy) {
  const Scene scene = load_scene("builtin:cornell-box");
  const CacheRun fine = render_with(scene, params({{"refine", "false"}, {"accuracy", "0.1"}}), 4);
  EXPECT_EQ(render_with(scene, params({{"refine", "false"}, {"accuracy", "0.4"}}), 4, fine.cache).hash, fine.hash);
}

TEST(SavedCache, ServesAnotherView) {
  const Scene scene = load_scene("builtin:cornell-box"), other = moved(scene);
  const CacheRun first = render_with(scene, params({{"refine", "false"}}), 1);
  const CacheRun reused = render_with(other, params({{"refine", "false"}}), 16, first.cache);
  const CacheRun fresh = render_with(other, params({{"refine", "false"}}), 16);
  EXPECT_GE(reused.records, first.records);
  EXPECT_LT(reused.records - first.records, fresh.records / 4);  // little is new to this view
  EXPECT_LT(relmse(reused.image, fresh.image), 1.5e-2);
  EXPECT_EQ(reused.hash, render_with(other, params({{"refine", "false"}}), 16, first.cache, 2).hash);
  // A finer image of the same view, and a finer accuracy, need more records.
  EXPECT_GT(render_with(scene, params({{"refine", "false"}, {"accuracy", "0.1"}}), 1, first.cache).records, first.records);
}

TEST(SavedCache, OfAnotherSceneOrOtherParametersIsRefused) {
  const Scene scene = load_scene("builtin:cornell-box");
  const std::string cache = render_with(scene, params({}), 1).cache;
  Scene repainted = scene;
  repainted.materials[0] = Diffuse{TexturedRgb{Rgb(0.123f)}};
  EXPECT_NE(refusal([&] { render_with(repainted, params({}), 1, cache); }).find("another scene"), std::string::npos);
  EXPECT_NE(refusal([&] {
              render_with(scene, params({{"samples", "64"}}), 1, cache);
            }).find("made with samples=32, not with 64"),
            std::string::npos);
  EXPECT_NE(refusal([&] { render_with(scene, params({{"max_depth", "3"}}), 1, cache); }).find("max_depth"), std::string::npos);
  EXPECT_EQ(refusal([&] { render_with(scene, params({{"structure", "brute"}, {"accuracy", "0.3"}}), 1, cache); }), "");
}

TEST(CacheFile, CutShortOrWithAFlippedBitIsRefused) {
  CacheKey key{"irradiance-cache", 77, "scene", {{"a", "1"}, {"b", "2"}}};
  const std::string whole = make_cache_file(key, "records");
  const CacheFile file = open_cache_file(whole, here);
  EXPECT_EQ(file.body, "records");
  EXPECT_EQ(file.key.params, key.params);
  for (std::size_t length = 0; length < whole.size(); ++length)
    EXPECT_NE(refusal([&] { open_cache_file(std::string_view(whole).substr(0, length), here); }), "") << length;
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    std::string flipped = whole;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
    EXPECT_NE(refusal([&] { open_cache_file(flipped, here); }), "") << bit;
  }
}

TEST(CacheFile, RecordsThatAreGarbageAreRefusedOrHarmless) {
  // Behind a checksum that holds: lengths and values are checked all the same.
  const std::string cache = render_with(load_scene("builtin:cornell-box"), params({{"records", "6"}}), 1).cache;
  const std::string body(open_cache_file(cache, here).body);
  EXPECT_EQ(refusal([&] { read_irradiance_cache(body, false, here); }), "");
  for (std::size_t length = 0; length < body.size(); ++length)
    EXPECT_NE(refusal([&] { read_irradiance_cache(std::string_view(body).substr(0, length), false, here); }), "") << length;
  Sampler sampler(SamplerKind::independent, 3, Stream::test, 0, 0);
  int refused = 0;
  constexpr int trials = 20000;
  for (int trial = 0; trial < trials; ++trial) {
    std::string garbled = body;
    for (int change = 0; change < 3; ++change) {
      const auto place = static_cast<std::size_t>(sampler.get_1d() * static_cast<float>(body.size()));
      garbled[std::min(place, body.size() - 1)] = static_cast<char>(256 * sampler.get_1d());
    }
    refused += refusal([&] { read_irradiance_cache(garbled, trial % 2 == 0, here); }) != "";
  }
  EXPECT_GT(refused, trials / 100);
  std::string huge = body;
  for (std::size_t i = 32; i < 40; ++i) huge[i] = '\xff';  // the count of the first level's records
  EXPECT_NE(refusal([&] { read_irradiance_cache(huge, false, here); }).find("elements"), std::string::npos);
}

class CacheProgram : public ProgramTest {};

TEST_F(CacheProgram, SavesAndLoads) {
  const std::vector<std::string> render{"render", "builtin:cornell-box", "--resolution", "16x16", "--spp", "2", "--threads",
                                        "1"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), render.begin(), render.end());
    return ProgramTest::run(more);
  };
  ASSERT_EQ(with({"-i", "irradiance-cache", "-p", "refine=false", "-p", "samples=16", "--save-cache", "a.cache", "-o", "a.png"})
                .status,
            0);
  ASSERT_EQ(with({"--load-cache", "a.cache", "-o", "b.png"}).status, 0);
  EXPECT_EQ(read_text_file(directory_ / "a.png"), read_text_file(directory_ / "b.png"));

  Outcome refused = with({"--load-cache", "a.cache", "-p", "samples=32", "-o", "c.png"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("a.cache: made with samples=16, not with 32"), std::string::npos) << refused.err;
  refused = with({"-i", "path", "--save-cache", "c.cache"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("irradiance-cache"), std::string::npos) << refused.err;
  std::filesystem::resize_file(directory_ / "a.cache", 300);
  refused = with({"--load-cache", "a.cache"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("damaged"), std::string::npos) << refused.err;
  EXPECT_EQ(with({"--load-cache", "none.cache"}).status, 2);
  EXPECT_FALSE(std::filesystem::exists(directory_ / "c.png"));
}

TEST_F(CacheProgram, ShowsItsRecords) {
  const std::vector<std::string> start{"render", "builtin:cornell-box", "--resolution", "16x16", "--spp", "1", "--threads",
                                       "1"};
  for (const char* integrator : {"irradiance-cache", "radiance-cache"}) {
    std::vector<std::string> words = start;
    for (const char* word : {"-i", integrator, "-p", "samples=16", "--aov", "records", "-o", "a.png"}) words.emplace_back(word);
    EXPECT_EQ(ProgramTest::run(words).status, 0);
    EXPECT_TRUE(std::filesystem::remove(directory_ / "a.records.png"));
  }
  std::vector<std::string> words = start;
  for (const char* word : {"-i", "path", "--aov", "records", "-o", "b.png"}) words.emplace_back(word);
  const Outcome refused = ProgramTest::run(words);
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("irradiance-cache, radiance-cache"), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(directory_ / "b.png"));
}

}  // namespace
}  // namespace etendue
