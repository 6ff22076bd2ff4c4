// The method that chooses: what it chooses, that the choice repeats, and that the image is the chosen method's to the bit.
#include "experiments/config/method.h"
#include "integrators/choice/choose.h"
#include "tests/render_scene.h"
#include "tests/scene_context.h"
#include "tests/unit/harness_process.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace etendue::testing {
namespace {

struct Choice {
  MethodChoice method;
  PilotFindings findings;
};

Choice choice_in(const std::string& scene, const Effort& effort, int threads = 2, BiasAllowed bias = BiasAllowed::any) {
  Scene loaded = load_scene(scene);
  const ivec2 resolution = loaded.resolution;
  SceneContext stage(std::move(loaded), resolution, 1);
  stage.context.effort = effort;
  Choice choice;
  with_threads(threads, [&] {
    choice.findings = run_pilot(stage.context);
    choice.method = choose_method(stage.context, choice.findings, bias);
  });
  return choice;
}

std::string name_in(const std::string& scene, const Effort& effort) { return choice_in(scene, effort).method.name; }

TEST(Pilot, FindsTheSameAtAnyNumberOfThreads) {
  for (const char* scene : {"builtin:glass-caustic", "builtin:two-rooms"}) {
    const PilotFindings one = choice_in(scene, {4}, 1).findings, three = choice_in(scene, {4}, 3).findings;
    for (const auto field : {&PilotFindings::path_error, &PilotFindings::direct_error, &PilotFindings::rays_per_path,
                             &PilotFindings::caustic_light, &PilotFindings::caustic_hits, &PilotFindings::caustic_contrast,
                             &PilotFindings::records, &PilotFindings::photons_seen, &PilotFindings::rays})
      EXPECT_EQ(one.*field, three.*field) << scene;
  }
}

TEST(Pilot, TellsScenesApart) {
  const PilotFindings direct = choice_in("builtin:polygon-light", {4}).findings;
  EXPECT_EQ(direct.direct_light, 1);
  EXPECT_EQ(direct.caustic_light, 0);
  EXPECT_NEAR(direct.direct_error / direct.path_error, 1, 0.3);
  const PilotFindings water = choice_in("builtin:water", {4}).findings;
  EXPECT_EQ(water.caustic_light, 1);
  EXPECT_EQ(water.path_error, 0);  // black: no path finds the light
  const PilotFindings box = choice_in("builtin:cornell-box", {4}).findings;
  EXPECT_GT(box.path_error, 2 * box.direct_error);
  EXPECT_GT(box.records, 100);
  EXPECT_LT(box.rays, 250'000);  // of 8 million in a second
}

TEST(AutoChoice, IsUnbiasedWhereThatIsAskedFor) {
  for (const char* scene : {"builtin:cornell-box", "builtin:glass-caustic", "builtin:water", "builtin:two-rooms"})
    for (const double seconds : {1.0, 16.0}) {
      const MethodChoice any = choice_in(scene, {seconds}).method;
      EXPECT_FALSE(any.why.empty());
      const auto expected = [&](BiasAllowed bias) {
        const MethodChoice choice = choice_in(scene, {seconds}, 2, bias).method;
        return find_integrator(choice.name, {}).make(choice.params)->expectation().bias;
      };
      EXPECT_NE(expected(BiasAllowed::vanishing), Bias::biased) << scene;
      EXPECT_EQ(expected(BiasAllowed::none), Bias::unbiased) << scene;
    }
}

TEST(AutoEffort, IsCountedInRays) {
  PilotFindings findings;
  findings.rays_per_path = 5;
  findings.path_error = 2;
  EXPECT_EQ(rays_a_pixel({}, {10, 10}, findings), 5 * 64);
  EXPECT_EQ(rays_a_pixel({0, 8}, {10, 10}, findings), 5 * 8);
  EXPECT_EQ(rays_a_pixel({2}, {100, 100}, findings), 2 * rays_per_second / 1e4);
  EXPECT_EQ(rays_a_pixel({2, 8}, {100, 100}, findings), 5 * 8);
  EXPECT_DOUBLE_EQ(rays_a_pixel({0, 0, 0.01}, {10, 10}, findings), 0.1 * 5 * 2 / 0.01);
}

class AutoRender : public ProgramTest {};

TEST_F(AutoRender, IsTheChosenMethodToTheBitAtAnyNumberOfThreads) {
  const std::vector<std::string> shared{"render", "builtin:cornell-spheres", "--resolution", "24x24", "--spp", "3", "--json"};
  const auto render = [&](std::vector<std::string> more) {
    more.insert(more.begin(), shared.begin(), shared.end());
    const Outcome outcome = run(more);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const auto one = render({"-i", "auto", "--threads", "1", "-o", "auto.exr"});
  const auto three = render({"-i", "auto", "--threads", "3"});
  EXPECT_EQ(one["image_hash"], three["image_hash"]);
  EXPECT_EQ(one["chosen"], three["chosen"]);
  EXPECT_FALSE(one["chosen"]["why"].get<std::string>().empty());
  const std::vector<std::string> words = words_of(one["chosen"]["integrator"].get<std::string>());
  std::vector<std::string> itself{"-i", words.front()};
  for (std::size_t i = 1; i < words.size(); ++i) itself.insert(itself.end(), {"-p", words[i]});
  EXPECT_EQ(render(itself)["image_hash"], one["image_hash"]);
  const Outcome again = run({"render", "--from", "auto.exr", "-o", "again.exr"});
  EXPECT_EQ(again.status, 0) << again.err;
}

}  // namespace
}  // namespace etendue::testing
