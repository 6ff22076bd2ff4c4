// Path guiding makes the path tracer's image: unbiased, so that no bias is allowed.
#include "tests/block_agreement.h"

namespace etendue {
namespace {

using testing::params_of;

void expect_agreement(const char* scene, int block, ParamMap params) {
  ParamMap plain = params;
  params["split"] = {std::int64_t{1000}, {}};  // small images have few records
  testing::expect_agreement(load_scene(scene), {.resolution = {24, 24}, .block = block, .comparisons = 4},
                            {"path", plain, 128, 0}, {{"guided", params, 62, 0}});
}

TEST(GuidedAgreement, CornellBox) { expect_agreement("builtin:cornell-box", 6, {}); }

TEST(GuidedAgreement, CornellBoxCutAtTwoEvents) { expect_agreement("builtin:cornell-box", 6, params_of({{"max_depth", "2"}})); }

TEST(GuidedAgreement, CornellSpheres) { expect_agreement("builtin:cornell-spheres", 12, {}); }

TEST(GuidedAgreement, TwoRooms) { expect_agreement("builtin:two-rooms", 12, {}); }

}  // namespace
}  // namespace etendue
