// docs/methods.md has a section for each integrator, which names none but its parameters; docs/metrics.md has each metric, and
// docs/gallery.md a picture of each built-in scene.
#include "framework/image/metrics.h"
#include "framework/io/load_scene.h"
#include "integrators/registry.h"
#include "tests/places.h"
#include "tests/unit/harness_process.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>
#include <sstream>

namespace etendue {
namespace {

using NameSet = std::set<std::string>;

std::string document(const std::string& name) { return read_text_file(std::string(project_folder) + "docs/" + name); }

// The names that stand between backticks.
NameSet quoted_names(const std::string& text) {
  NameSet names;
  for (std::size_t begin = text.find('`'); begin != std::string::npos; begin = text.find('`', begin)) {
    const std::size_t end = text.find('`', ++begin);
    if (end == std::string::npos) break;
    names.insert(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return names;
}

// The paragraph of parameters in each section, by the name in its heading.
std::map<std::string, std::string> parameter_paragraphs() {
  std::map<std::string, std::string> paragraphs;
  std::istringstream lines(document("methods.md"));
  std::string section;
  bool within = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("## `")) paragraphs[section = line.substr(4, line.size() - 5)];
    if (line.empty() || line.starts_with("**")) within = line.starts_with("**Parameters.**");
    if (within) paragraphs[section] += line + "\n";
  }
  return paragraphs;
}

TEST(MethodDocs, HaveASectionForEachIntegrator) {
  NameSet documented, present;
  for (const auto& [name, paragraph] : parameter_paragraphs()) documented.insert(name);
  for (const IntegratorEntry& entry : integrators()) present.insert(entry.name);
  EXPECT_EQ(documented, present);
}

TEST(MethodDocs, NameParametersThatExist) {
  for (const auto& [name, paragraph] : parameter_paragraphs()) {
    NameSet known;
    for (const IntegratorEntry& entry : integrators()) known.insert(entry.name);  // "as of `ppm`"
    for (const ParamInfo& parameter : find_integrator(name, {}).params) known.insert(parameter.name);
    const NameSet named = quoted_names(paragraph);
    EXPECT_FALSE(named.empty()) << name;
    for (const std::string& parameter : named) EXPECT_TRUE(known.contains(parameter)) << name << ": " << parameter;
  }
}

TEST(MetricDocs, HaveARowForEachMetric) {
  NameSet documented, present;
  std::istringstream lines(document("metrics.md"));
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("| `")) documented.insert(line.substr(3, line.find('`', 3) - 3));
  for (const Metric& metric : metrics()) present.emplace(metric.name);
  EXPECT_EQ(documented, present);
}

TEST(Gallery, ShowsEachBuiltInScene) {
  const std::string page = document("gallery.md"), script = document("pictures.sh");
  for (const BuiltinScene& scene : builtin_scenes()) {
    const std::string picture = "images/gallery/" + scene.name + ".png";
    EXPECT_NE(page.find("](" + picture + ")"), std::string::npos) << scene.name;
    EXPECT_NE(page.find("`" + scene.name + "`: "), std::string::npos) << scene.name;
    EXPECT_NE(script.find("\n" + scene.name + " "), std::string::npos) << scene.name;
    EXPECT_TRUE(std::filesystem::exists(std::string(project_folder) + "docs/" + picture)) << picture;
  }
}

}  // namespace
}  // namespace etendue
