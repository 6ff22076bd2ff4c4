// The memory of a render is foreseen within a factor of two, and kept within --memory: by errors, never by another image.
#include "experiments/run/memory_forecast.h"
#include "framework/core/memory.h"
#include "framework/scene/builder.h"
#include "integrators/caches/cache_fill.h"
#include "integrators/photons/photons.h"
#include "integrators/registry.h"
#include "tests/scene_context.h"
#include "tests/unit/harness_process.h"
#include "tests/unit/io_helpers.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace etendue::testing {
namespace {

class MemoryForecasts : public ProgramTest {
 protected:
  nlohmann::json json_of(const std::vector<std::string>& words, int status = 0) {
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.status, status) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  }
};

TEST_F(MemoryForecasts, AreWithinAFactorOfTwo) {
  const std::pair<const char*, std::vector<const char*>> cases[] = {
      {"builtin:cornell-box", {"path", "bdpt", "photon-map", "sppm", "hash-cache"}},
      {"builtin:glass-caustic", {"vcm", "ppm", "irradiance-cache"}},
      {"builtin:mesh?triangles=200000", {"path"}}};
  for (const auto& [scene, methods] : cases) {
    const auto foreseen = json_of({"inspect", scene, "--json"})["memory"]["methods"];
    for (const char* method : methods) {
      const auto rendered = json_of({"render", scene, "-i", method, "--spp", "2", "--json", "--threads", "2"});
      const double factor = foreseen[method].get<double>() / rendered["peak_memory_bytes"].get<double>();
      RecordProperty(std::string(scene) + " " + method, std::to_string(factor));
      EXPECT_GT(factor, 0.5) << scene << " " << method;
      EXPECT_LT(factor, 2) << scene << " " << method;
    }
  }
}

TEST_F(MemoryForecasts, RefuseWhatTakesMoreThanIsAllowed) {
  const std::vector<std::string> words{
      "render", "builtin:cornell-box", "-i", "sppm", "-p", "photons=2M", "--resolution", "16x16", "--spp", "1", "--json"};
  std::vector<std::string> limited = words;
  limited.insert(limited.end(), {"--memory", "100MiB"});
  const Outcome refused = run(limited);
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("--memory: builtin:cornell-box needs about"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("photons 2"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("expected fewer photons than 2"), std::string::npos) << refused.err;
  limited.back() = "2GiB";
  EXPECT_EQ(json_of(limited)["image_hash"], json_of(words)["image_hash"]);
  limited.back() = "none at all";
  EXPECT_EQ(run(limited).status, 2);
}

TEST_F(MemoryForecasts, RefusePhotonsThatNoMemoryHolds) {
  const Method map{"photon-map", {{"photons", {std::int64_t{1'000'000'000}, {}}}}, {}};
  set_memory_limit(resident_memory_bytes() + (std::uint64_t{1} << 30));
  EXPECT_ERROR(require_room_for_photons({}, map, {8, 8}), "room for a tenth of 1 G photons needs about");
  set_memory_limit(0);
}

TEST_F(MemoryForecasts, RefuseAnExperimentBeforeItBegins) {
  write_file("some.toml",
             "title = \"t\"\nscenes = [\"builtin:cornell-box\"]\nseeds = 1\nbudget = { samples = 1 }\nresolution = [8, 8]\n"
             "integrators = [\"path\", { name = \"photon-map\", photons = \"5M\" }]\n");
  const Outcome refused = run({"run", "some.toml", "--memory", "200MiB"});
  EXPECT_EQ(refused.status, 2) << refused.err;
  EXPECT_NE(refused.err.find("photon-map"), std::string::npos) << refused.err;
}

TEST(MemoryLimit, FailsWhatGrowsBeyondIt) {
  EXPECT_NO_THROW(fail_over_memory(3));
  set_memory_limit(1);
  EXPECT_THROW(fail_over_memory(3), std::runtime_error);
  EXPECT_EQ(available_memory_bytes(), 0u);
  set_memory_limit(0);
}

// In a closed white room a light's path goes on for as many events as it may.
TEST(MemoryLimit, RefusesPhotonsThatGoOnForTooLong) {
  SceneBuilder b("white sphere");
  b.quadric(Sphere{{0, 0, 0}, 1}, b.material(Diffuse{Rgb(1)}));
  b.light(PointLight{{0, 0, 0}, Rgb(1)});
  b.camera({0, 0, 0.5f}, {0, 0, 0}, 50, {64, 64});
  SceneContext stage(b.finish(), {64, 64});
  const auto refusal = [&](const char* method, std::int64_t depth) {
    const auto integrator = find_integrator(method, {}).make({{"max_depth", {depth, {}}}});
    set_memory_limit(resident_memory_bytes() + (std::uint64_t{1} << 28));
    const std::string said = error_of([&] {
      integrator->prepare(stage.context);
      Film film(stage.context.resolution);
      integrator->iteration(stage.context, 0, film);
    });
    set_memory_limit(0);
    return said;
  };
  for (const char* method : {"sppm", "photon-map"}) {
    EXPECT_TRUE(contains(refusal(method, 60000), "the photons of a pass need about")) << method;
    EXPECT_EQ(refusal(method, 8), "") << method;
  }
}

// These are the bytes that docs/using.md states.
TEST(MemoryOfStores, IsWhatTheDocumentsSay) {
  EXPECT_EQ(2 * sizeof(vec3) + sizeof(Rgb) + sizeof(float) + sizeof(PhotonSide) + sizeof(std::uint16_t), 46u);
  EXPECT_EQ(sizeof(IrradianceRecord), 136u);
  EXPECT_EQ(sizeof(RecordHistory), 224u);
}

}  // namespace
}  // namespace etendue::testing
