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

Image image_of(const IntegratorEntry& entry, const ParamMap& params, const Scene& scene) {
  testing::SceneContext at(scene, ivec2(24));
  const auto method = entry.make(params);
  Film film(ivec2(24));
  method->prepare(at.context);
  for (std::uint32_t i = 0; i < 32; ++i) method->iteration(at.context, i, film);
  return film.mean();
}

TEST(ExampleMethod, HasTheClosedFormsLight) {
  const Scene scene = load_scene("builtin:polygon-light");
  EXPECT_LT(relmse(image_of(plain_path_entry(), {}, scene), testing::exact_image(scene, ivec2(24))), 1e-3);
}

// What `path` does to many paths together is what the page says of one.
TEST(ExampleMethod, GivesTheBitsOfPath) {
  for (const char* name : {"builtin:cornell-box", "builtin:cornell-spheres", "builtin:veach-mis", "builtin:two-rooms"}) {
    const Scene scene = load_scene(name);
    const Image plain = image_of(plain_path_entry(), {}, scene);
    EXPECT_EQ(plain.pixels, image_of(path_entry(), {{"mis", {std::string("power"), {}}}}, scene).pixels) << name;
  }
}

}  // namespace
}  // namespace etendue
