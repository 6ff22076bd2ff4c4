// The builder of docs/adding-a-method.md finds what brute force finds, as the page has it.
#include "tests/oracle/example_builder.h"
#include "tests/oracle/ray_cases.h"
#include "tests/places.h"

#include <gtest/gtest.h>
#include <fstream>
#include <iterator>

namespace etendue::testing {
namespace {

std::string project_text(const char* name) {
  std::ifstream file(std::string(project_folder) + name);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(ExampleBuilder, StandsInTheDocsAsItIsCompiled) {
  const std::string code = project_text("tests/oracle/example_builder.h");
  ASSERT_FALSE(code.empty());
  EXPECT_NE(project_text("docs/adding-a-method.md").find("```cpp\n" + code + "```"), std::string::npos);
}

TEST(ExampleBuilder, FindsWhatBruteForceFindsInEveryLayout) {
  const RayEntry entry = in_order_entry();
  for (const RayCase& ray_case : ray_cases()) {
    const Scene& scene = ray_case.scene;
    const auto brute = find_ray_structure("brute", {}).make(scene, {});
    for (const char* layout : {"binary", "bvh4"}) {
      const auto structure = entry.make(scene, {{"layout", {std::string(layout), {}}}});
      for (const Ray& ray : general_rays(scene, 100, 1)) {
        ASSERT_EQ(brute->closest(ray).t, structure->closest(ray).t) << ray_case.name << ", " << layout;
        ASSERT_EQ(brute->occluded(ray), structure->occluded(ray)) << ray_case.name << ", " << layout;
      }
    }
  }
}

}  // namespace
}  // namespace etendue::testing
