// The method of docs/adding-a-method.md does what the page says, as the page has it.
#include "tests/unit/example_method.h"
#include "tests/places.h"
#include "tests/render_scene.h"
#include "tests/scene_context.h"
#include "tests/unit/harness_process.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

TEST(ExampleMethod, StandsInTheDocsAsItIsCompiled) {
  const std::string page = read_text_file(std::string(project_folder) + "docs/adding-a-method.md");
  for (const char* file : {"tests/unit/example_method.h", "framework/materials/diffuse.h"}) {
    const std::string code = read_text_file(std::string(project_folder) + file);
    EXPECT_NE(page.find("```cpp\n" + code + "```"), std::string::npos) << file;
  }
}

TEST(ExampleMethod, HasDirectLightOfTheClosedForm) {
  const Scene scene = load_scene("builtin:polygon-light");
  testing::SceneContext at(scene, ivec2(24));
  const auto method = direct_entry().make({{"light_samples", {std::int64_t{4}, {}}}});
  Film film(ivec2(24));
  method->prepare(at.context);
  for (std::uint32_t i = 0; i < 32; ++i) method->iteration(at.context, i, film);
  EXPECT_LT(relmse(film.mean(), testing::exact_image(scene, ivec2(24))), 1e-3);
}

}  // namespace
}  // namespace etendue
