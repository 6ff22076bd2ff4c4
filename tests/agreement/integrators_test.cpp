// Integrators that share nothing but scene, BSDFs and light sampling must make the same image as the path tracer.
#include "tests/block_agreement.h"

namespace etendue {
namespace {

using testing::AgreementMethod;
using testing::params_of;

void expect_agreement(const char* scene_name, int block, const AgreementMethod& reference,
                      const std::vector<AgreementMethod>& methods) {
  testing::expect_agreement(load_scene(scene_name), {.resolution = {24, 24}, .block = block, .comparisons = 4}, reference,
                            methods);
}

TEST(IntegratorAgreement, CornellBox) {
  expect_agreement("builtin:cornell-box", 6, {"path", {}, 128, 0},
                   {{"light-trace", {}, 128, 0},
                    {"photon-map", params_of({{"photons", "20000"}, {"final_gather", "4"}, {"retrace", "true"}}), 4, 0.03},
                    {"photon-map", params_of({{"photons", "20000"}, {"retrace", "true"}}), 4, 0.06},
                    {"sppm", {}, 16, 0.04},
                    {"ppm-memoryless", {}, 16, 0.04},
                    {"appm", {}, 16, 0.04},
                    {"cppm", {}, 16, 0.04},
                    {"irradiance-cache", params_of({{"samples", "256"}}), 32, 0.03},
                    {"photon-cache", params_of({{"photons", "50000"}}), 32, 0.03},
                    {"photon-cache", params_of({{"photons", "50000"}, {"fill", "density"}}), 8, 0.06}});
}

TEST(IntegratorAgreement, CornellBoxCutAtTwoEvents) {
  const auto cut = [](std::initializer_list<std::pair<const char*, const char*>> list) {
    ParamMap params = params_of(list);
    params["max_depth"] = {std::int64_t{2}, {}};
    return params;
  };
  expect_agreement("builtin:cornell-box", 6, {"path", cut({}), 128, 0},
                   {{"light-trace", cut({}), 128, 0},
                    {"photon-map", cut({{"photons", "20000"}, {"final_gather", "4"}, {"retrace", "true"}}), 4, 0.03},
                    {"irradiance-cache", cut({{"samples", "256"}}), 32, 0.03},
                    {"photon-cache", cut({{"photons", "50000"}}), 32, 0.03}});
}

// A floor of rough metal, its lobe partly followed and partly gathered.
TEST(IntegratorAgreement, GlossyFloorCutAtThreeEvents) {
  const auto cut = [](std::initializer_list<std::pair<const char*, const char*>> list) {
    ParamMap params = params_of(list);
    params["max_depth"] = {std::int64_t{3}, {}};
    return params;
  };
  expect_agreement("builtin:glossy-cornell-box", 12, {"path", cut({}), 64, 0},
                   {{"sppm", cut({{"lobe_tails", "gathered"}}), 8, 0.03}, {"cppm", cut({{"direct", "photons"}}), 8, 0.03}});
}

// Mirror and glass: light tracing cannot see into them, so it sits out.
TEST(IntegratorAgreement, CornellSpheres) {
  expect_agreement(
      "builtin:cornell-spheres", 12, {"path", {}, 128, 0},
      {{"photon-map",
        params_of({{"photons", "20000"}, {"caustic_photons", "20000"}, {"final_gather", "4"}, {"retrace", "true"}}), 4, 0.05},
       {"sppm", {}, 16, 0.05},
       {"irradiance-cache", params_of({{"samples", "256"}}), 64, 0.05},
       {"photon-cache", params_of({{"photons", "50000"}, {"caustic_photons", "20000"}}), 32, 0.05}});
}

}  // namespace
}  // namespace etendue
