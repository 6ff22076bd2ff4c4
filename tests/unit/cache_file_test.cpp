// Caches on disk: the same image as a fresh cache, other views, and files that must be refused.
#include "integrators/caches/records/cache_file.h"
#include "framework/core/sampler.h"
#include "integrators/registry.h"
#include "tests/scene_context.h"
#include "tests/unit/harness_process.h"

#include "framework/image/metrics.h"
#include "framework/io/load_scene.h"

#include <gtest/gtest.h>

#include <cstring>

namespace etendue {
namespace {

using testing::SceneContext;

constexpr ivec2 cached_size{24, 24};
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
                     int threads = 1, ivec2 resolution = cached_size, const std::string& name = "irradiance-cache") {
  SceneContext scope(scene, resolution);
  const auto integrator = find_integrator(name, {}).make(map);
  Film film(resolution);
  CacheRun result;
  with_threads(threads, [&] {
    if (!loaded.empty()) integrator->cache()->load(scope.context, loaded, here);
    integrator->prepare(scope.context);
    for (std::uint32_t i = 0; i < iterations; ++i) integrator->iteration(scope.context, i, film);
    result.cache = integrator->cache()->save(scope.context);
    result.records = integrator->cache()->record_shapes().size();
  });
  result.hash = film.hash();
  result.image = film.mean();
  return result;
}

Scene moved(Scene scene) {
  scene.camera.fov *= 0.9f;
  return scene;
}

// The text of the error; "" where nothing was thrown.
template <class Action>
std::string refusal(const Action& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

// A cache whose parameters decide what it holds.
struct SavedCase {
  const char *integrator, *scene;
  std::vector<std::pair<const char*, const char*>> given, unrefined;  // unrefined: empty where it always goes on
  const char *decides, *free;                                         // "key=value" of parameters
};

ParamMap params_of(const SavedCase& c, bool refines, const char* more = nullptr) {
  ParamMap map;
  for (const auto& [name, value] : c.given) map[name] = parse_param_value(value, {});
  if (!refines)
    for (const auto& [name, value] : c.unrefined) map[name] = parse_param_value(value, {});
  if (more == nullptr) return map;
  const std::string assignment = more;
  const auto equals = assignment.find('=');
  map[assignment.substr(0, equals)] = parse_param_value(assignment.substr(equals + 1), {});
  return map;
}

const SavedCase saved_cases[] = {
    {"irradiance-cache", "builtin:cornell-box", {{"samples", "32"}}, {{"refine", "false"}}, "samples=64", "accuracy=0.3"},
    {"irradiance-cache",
     "builtin:cornell-box",
     {{"samples", "32"}, {"metric", "occlusion-hessian"}},
     {{"refine", "false"}},
     "metric=tabellion",
     "structure=octree"},
    {"radiance-cache",
     "builtin:glossy-cornell-box?alpha=0.6",
     {{"samples", "32"}},
     {{"refine", "false"}},
     "order=4",
     "lobe_samples=2"},
    {"radiance-cache", "builtin:cornell-box", {{"samples", "32"}}, {{"refine", "false"}}, "left_out=0.01", "extra_samples=0"},
    {"photon-cache",
     "builtin:cornell-box",
     {{"samples", "32"}, {"photons", "4000"}},
     {{"refine", "false"}},
     "photons=5000",
     "record_structure=octree"},
    {"photon-cache",
     "builtin:cornell-box",
     {{"fill", "density"}, {"retrace", "false"}, {"photons", "4000"}, {"precompute", "0"}, {"follow_near", "false"}},
     {{"refine", "false"}},
     "k=40",
     "accuracy=0.3"},
    {"hash-cache", "builtin:cornell-box", {}, {}, "trace_on=0.5", "enough=10"},
};

void PrintTo(const SavedCase& c, std::ostream* out) { *out << c.integrator << " on " << c.scene; }

std::string name_of(const ::testing::TestParamInfo<SavedCase>& info) {
  std::string name = info.param.integrator;
  name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
  return name + std::to_string(info.index);
}

class SavedCaches : public ::testing::TestWithParam<SavedCase> {
 protected:
  CacheRun run(const Scene& of, bool refines, std::uint32_t iterations, const std::string& loaded = {}, int threads = 1,
               const char* more = nullptr) const {
    return render_with(of, params_of(GetParam(), refines, more), iterations, loaded, threads, cached_size,
                       GetParam().integrator);
  }
  const Scene scene_ = load_scene(GetParam().scene);
};
INSTANTIATE_TEST_SUITE_P(All, SavedCaches, ::testing::ValuesIn(saved_cases), name_of);

// The caches whose refinement can be switched off.
std::vector<SavedCase> unrefined_cases() {
  std::vector<SavedCase> cases(std::begin(saved_cases), std::end(saved_cases));
  std::erase_if(cases, [](const SavedCase& c) { return c.unrefined.empty(); });
  return cases;
}
class UnrefinedCaches : public SavedCaches {};
INSTANTIATE_TEST_SUITE_P(All, UnrefinedCaches, ::testing::ValuesIn(unrefined_cases()), name_of);

TEST_P(UnrefinedCaches, GiveTheSameImageAsFreshOnes) {
  const CacheRun fresh = run(scene_, false, 3), loaded = run(scene_, false, 3, fresh.cache, 2);
  EXPECT_EQ(fresh.hash, loaded.hash);
  EXPECT_EQ(fresh.cache, loaded.cache);
}

TEST_P(SavedCaches, GoOnWhereTheyStood) {
  const CacheRun half = run(scene_, true, 8);
  EXPECT_EQ(half.cache, run(scene_, true, 0, half.cache).cache);
  const CacheRun on = run(scene_, true, 4, half.cache), again = run(scene_, true, 4, half.cache, 3);
  EXPECT_EQ(on.hash, again.hash);
  EXPECT_EQ(on.cache, again.cache);
  // The hash cache's records are the cells that answer: fewer for a while when its earlier values lose half of their weight.
  const bool weighs_less = std::string(GetParam().integrator) == "hash-cache";
  EXPECT_GE(on.records, weighs_less ? 3 * half.records / 4 : half.records);
  // The run that goes on has camera samples of its own, so that the mean of both images has twice as many.
  EXPECT_NE(run(scene_, true, 8, half.cache).hash, half.hash);
}

// Their samples go on in the middle of the sequence, where those of negative weight may be all that a pixel gets.
TEST_P(SavedCaches, ThatGoOnAreRefusedUnderSignedFilters) {
  Scene filtered = scene_;
  filtered.filter = make_pixel_filter(named_filter("mitchell"));
  const std::string cache = run(scene_, true, 4).cache;
  EXPECT_NE(refusal([&] { run(filtered, true, 1, cache); }).find("another --pixel-filter"), std::string::npos);
  if (!GetParam().unrefined.empty()) {
    EXPECT_EQ(refusal([&] { run(filtered, false, 1, run(scene_, false, 4).cache); }), "");
  }
}

TEST_P(SavedCaches, ServeAnotherView) {
  const Scene other = moved(scene_);
  const bool refines = GetParam().unrefined.empty();
  const CacheRun first = run(scene_, refines, 8);
  const CacheRun reused = run(other, refines, 8, first.cache), fresh = run(other, refines, 8);
  EXPECT_LT(relmse(reused.image, fresh.image), refines ? 0.15 : 4e-2);  // most of it the camera samples' noise
  EXPECT_EQ(reused.hash, run(other, refines, 8, first.cache, 2).hash);
}

TEST_P(SavedCaches, OfAnotherSceneMethodOrParametersAreRefused) {
  const std::string cache = run(scene_, true, 1).cache;
  const auto refused = [&](const char* more) { return refusal([&] { run(scene_, true, 1, cache, 1, more); }); };
  Scene repainted = scene_;
  repainted.materials[0] = Diffuse{TexturedRgb{Rgb(0.123f)}};
  EXPECT_NE(refusal([&] { run(repainted, true, 1, cache); }).find("another scene"), std::string::npos);
  const std::string decides = GetParam().decides;
  EXPECT_NE(refused(GetParam().decides).find("made with " + decides.substr(0, decides.find('='))), std::string::npos);
  EXPECT_NE(refused("max_depth=3").find("made with max_depth"), std::string::npos);
  EXPECT_EQ(refused(GetParam().free), "");
  for (const SavedCase& other : saved_cases) {
    if (std::string(other.integrator) == GetParam().integrator) continue;
    const std::string reason =
        refusal([&] { render_with(scene_, params_of(other, true), 1, cache, 1, cached_size, other.integrator); });
    EXPECT_NE(reason.find(std::string("a cache of integrator '") + GetParam().integrator), std::string::npos) << reason;
  }
}

// Loads, and uses what was accepted in all ways.
std::string refused_or_used_by(const Scene& scene, const SavedCase& c, const std::string& bytes) {
  SceneContext scope(scene, ivec2(4));
  scope.context.states_error = true;
  const auto integrator = find_integrator(c.integrator, {}).make(params_of(c, true));
  const std::string reason = refusal([&] { integrator->cache()->load(scope.context, bytes, here); });
  if (!reason.empty()) return reason;
  Film film(ivec2(4));
  integrator->prepare(scope.context);
  integrator->iteration(scope.context, 0, film);
  integrator->cache()->standard_error();
  integrator->cache()->record_shapes();
  integrator->cache()->save(scope.context);
  return "";
}

// Loads without preparing.
std::string refused_by(const Scene& scene, const SavedCase& c, const std::string& bytes) {
  SceneContext scope(scene, cached_size);
  const auto integrator = find_integrator(c.integrator, {}).make(params_of(c, true));
  return refusal([&] { integrator->cache()->load(scope.context, bytes, here); });
}

TEST_P(SavedCaches, DamagedOrOfAnotherVersionAreRefused) {
  std::string cache = run(scene_, true, 1).cache;
  EXPECT_EQ(refused_by(scene_, GetParam(), cache), "");
  for (std::size_t part = 0; part < 16; ++part) {
    EXPECT_NE(refused_by(scene_, GetParam(), cache.substr(0, part * cache.size() / 16)), "") << part;
    std::string flipped = cache;
    flipped[part * cache.size() / 16] ^= 4;
    EXPECT_NE(refused_by(scene_, GetParam(), flipped), "") << part;
  }
  EXPECT_NE(refused_by(scene_, GetParam(), cache + "x").find("damaged"), std::string::npos);
  cache[8] = static_cast<char>(cache[8] + 1);
  EXPECT_NE(refused_by(scene_, GetParam(), cache).find("a cache of format"), std::string::npos);
}

// The file is of the same version, but from when the method kept something else, or will.
TEST_P(SavedCaches, OfAnotherFormatOfTheMethodAreRefused) {
  const std::string cache = run(scene_, true, 1).cache;
  const CacheFile file = open_cache_file(cache, here);
  for (const std::uint32_t format : {file.key.format - 1, file.key.format + 1}) {
    CacheKey key = file.key;
    key.format = format;
    const std::string reason = refused_by(scene_, GetParam(), make_cache_file(key, file.body));
    EXPECT_NE(reason.find("in its format " + std::to_string(format)), std::string::npos) << reason;
  }
}

// Lengths and values are checked even behind a checksum that holds.
TEST_P(SavedCaches, OfGarbageAreRefusedOrHarmless) {
  const std::string cache = render_with(scene_, params_of(GetParam(), true), 1, {}, 1, ivec2(4), GetParam().integrator).cache;
  const CacheFile file = open_cache_file(cache, here);
  const std::string body(file.body);
  EXPECT_EQ(refused_by(scene_, GetParam(), make_cache_file(file.key, body)), "");
  const std::size_t step = std::max<std::size_t>(1, body.size() / 200);
  for (std::size_t length = 0; length < body.size(); length += step)
    EXPECT_NE(refused_by(scene_, GetParam(), make_cache_file(file.key, body.substr(0, length))), "") << length;
  EXPECT_NE(refused_by(scene_, GetParam(), make_cache_file(file.key, body + "x")).find("left over"), std::string::npos);
  Sampler sampler(SamplerKind::independent, 3, Stream::test, 0, 0);
  int refused = 0;
  constexpr int trials = 300;
  for (int trial = 0; trial < trials; ++trial) {
    std::string garbled = body;
    for (int change = 0; change < 30; ++change) {
      const auto place = static_cast<std::size_t>(sampler.get_1d() * static_cast<float>(body.size()));
      garbled[std::min(place, body.size() - 1)] = static_cast<char>(256 * sampler.get_1d());
    }
    refused += refused_or_used_by(scene_, GetParam(), make_cache_file(file.key, garbled)) != "";
  }
  EXPECT_GT(refused, trials / 10);
}

TEST(SavedCache, OfMoreIterationsThanSamplesHaveNumbersForIsRefused) {
  const Scene scene = load_scene("builtin:cornell-box");
  const SavedCase& c = saved_cases[0];
  const std::string cache = render_with(scene, params_of(c, true), 1, {}, 1, ivec2(4), c.integrator).cache;
  const CacheFile file = open_cache_file(cache, here);
  const auto refused_after = [&](std::uint32_t rounds) {
    std::string body(file.body);
    std::memcpy(&body[2 * sizeof(std::uint64_t)], &rounds, sizeof rounds);
    return refused_by(scene, c, make_cache_file(file.key, body));
  };
  EXPECT_EQ(refused_after(1u << 20), "");
  EXPECT_NE(refused_after((1u << 20) + 1).find("more iterations than can be"), std::string::npos);
}

TEST(SavedCache, OfRecordsThatAreMadeAnewIsRefused) {
  const auto integrator =
      find_integrator("photon-cache", {}).make({{"fill", {std::string("density"), {}}}, {"retrace", {true, {}}}});
  EXPECT_FALSE(integrator->cache()->savable());
}

TEST(SavedCache, OfCellsIsTheOneThatWentOn) {
  const Scene scene = load_scene("builtin:cornell-box");
  const auto run = [&](std::uint32_t iterations, const std::string& loaded) {
    return render_with(scene, {}, iterations, loaded, 1, cached_size, "hash-cache").cache;
  };
  EXPECT_EQ(run(3, run(5, {})), run(8, {}));
}

// Its samples are those in the middle of a pixel's, of which signs may cancel.
// Such files hold sums in which all values weigh the same.
TEST(SavedCache, OfCellsThatForgetNothingIsRefused) {
  const Scene scene = load_scene("builtin:cornell-box");
  const SavedCase c{"hash-cache", "", {}, {}, nullptr, nullptr};
  const std::string cache = render_with(scene, {}, 3, {}, 1, ivec2(4), c.integrator).cache;
  CacheFile file = open_cache_file(cache, here);
  file.key.format = 1;
  EXPECT_NE(refused_by(scene, c, make_cache_file(file.key, file.body)).find("'hash-cache' in its format 1"), std::string::npos);
}

// Saved after its first image, whose records have a sixteenth of the rays.
TEST(SavedCache, OfFewRaysIsMadeAnewWithoutRefinement) {
  const Scene scene = load_scene("builtin:cornell-box");
  const CacheRun first = render_with(scene, params({{"refine", "true"}}), 1);
  const auto unrefined = params({{"refine", "false"}});
  EXPECT_EQ(render_with(scene, unrefined, 2, first.cache).hash, render_with(scene, unrefined, 2).hash);
}

TEST(SavedCache, OfAGivenNumberOfRecordsIsTheSame) {
  const Scene scene = load_scene("builtin:cornell-box");
  const auto map = params({{"refine", "false"}, {"records", "60"}});
  const CacheRun fresh = render_with(scene, map, 3), loaded = render_with(scene, map, 3, fresh.cache, 2);
  EXPECT_EQ(fresh.hash, loaded.hash);
  EXPECT_EQ(fresh.cache, loaded.cache);
}

TEST(SavedCache, OfAGivenNumberOfRecordsKeepsThatNumber) {
  const Scene scene = load_scene("builtin:cornell-box");
  const CacheRun few = render_with(scene, params({{"records", "6"}}), 40);
  EXPECT_LE(few.records, 6u);
  EXPECT_EQ(render_with(scene, params({{"records", "6"}}), 40, few.cache).records, few.records);
}

// Records of a file hold what reaches them with the map that was there when they were made, whatever this view would decide.
TEST(SavedCache, KeepsWhatWasDecidedOfCaustics) {
  const Scene scene = load_scene("builtin:thin-wall");
  for (const char* method : {"irradiance-cache", "radiance-cache", "hash-cache"}) {
    const auto with = [&](const char* map, const std::string& loaded = {}) {
      return render_with(scene, {{"caustic_map", {std::string(map), {}}}}, 2, loaded, 1, ivec2(12), method);
    };
    for (const char* made : {"on", "off"}) {
      const std::string cache = with(made).cache;
      EXPECT_EQ(with("auto", cache).hash, with(made, cache).hash) << method << ' ' << made;
    }
    const char* decided = method == std::string("hash-cache") ? "on" : "off";
    EXPECT_EQ(with("auto", with("auto").cache).hash, with(decided, with(decided).cache).hash) << method;
    EXPECT_THROW(with("off", with("on").cache), Error) << method;
  }
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

TEST(CacheFile, CutShortOrWithAFlippedBitIsRefused) {
  CacheKey key{"irradiance-cache", 77, "scene", {{"a", "1"}, {"b", "2"}}, 5};
  const std::string whole = make_cache_file(key, "records");
  const CacheFile file = open_cache_file(whole, here);
  EXPECT_EQ(file.body, "records");
  EXPECT_EQ(file.key.params, key.params);
  EXPECT_EQ(file.key.format, key.format);
  for (std::size_t length = 0; length < whole.size(); ++length)
    EXPECT_NE(refusal([&] { open_cache_file(std::string_view(whole).substr(0, length), here); }), "") << length;
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    std::string flipped = whole;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << bit % 8));
    EXPECT_NE(refusal([&] { open_cache_file(flipped, here); }), "") << bit;
  }
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
  for (const char* integrator : {"irradiance-cache", "radiance-cache", "photon-cache", "hash-cache"}) {
    std::vector<std::string> words = start;
    for (const char* word : {"-i", integrator, "--aov", "records", "--aov", "standard-error", "-o", "a.png"})
      words.emplace_back(word);
    EXPECT_EQ(ProgramTest::run(words).status, 0);
    EXPECT_TRUE(std::filesystem::remove(directory_ / "a.records.png"));
    EXPECT_TRUE(std::filesystem::remove(directory_ / "a.standard-error.png"));
  }
  std::vector<std::string> words = start;
  for (const char* word : {"-i", "path", "--aov", "records", "-o", "b.png"}) words.emplace_back(word);
  const Outcome refused = ProgramTest::run(words);
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("irradiance-cache, hash-cache, radiance-cache, photon-cache"), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(directory_ / "b.png"));
}

}  // namespace
}  // namespace etendue
