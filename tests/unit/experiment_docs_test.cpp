// docs/experiment-file.md names every key that the parser takes, and no other.
#include "tests/places.h"
#include "tests/unit/experiment_text.h"
#include "tests/unit/harness_process.h"

#include <map>
#include <set>
#include <sstream>

namespace etendue {
namespace {

using Keys = std::set<std::string>;

// The first column of each section's table, by the section's heading.
std::map<std::string, Keys> documented_keys() {
  std::map<std::string, Keys> sections;
  std::istringstream lines(read_text_file(std::string(project_folder) + "docs/experiment-file.md"));
  std::string section;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("## ")) section = line.substr(3);
    if (line.starts_with("| `")) sections[section].insert(line.substr(3, line.find('`', 3) - 3));
  }
  return sections;
}

// The keys that the parser says it knows where it meets a key like no other.
Keys parsed_keys(const std::string& experiment) {
  const std::string what = config_error(experiment);
  constexpr std::string_view before = "unknown key 'zzzzzzzz'; available:";
  const auto at = what.find(before);
  EXPECT_NE(at, std::string::npos) << experiment << "\n" << what;
  if (at == std::string::npos) return {};
  std::istringstream words(what.substr(at + before.size()));
  Keys keys;
  for (std::string word; words >> word;) keys.insert(word);
  return keys;
}

TEST(ExperimentDocs, TheTutorialsExperimentIsRead) {
  const std::string page = read_text_file(std::string(project_folder) + "docs/tutorial.md"), fence = "```toml\n";
  const std::size_t begin = page.find(fence) + fence.size();
  EXPECT_EQ(config_error(page.substr(begin, page.find("```", begin) - begin)), "no error");
}

TEST(ExperimentDocs, NameEveryKeyOfTheParser) {
  const std::string z = "zzzzzzzz = 1", base = "scenes = [\"builtin:cornell-box\"]\nbudget = { samples = 1 }\n",
                    path = "[[integrators]]\nname = \"path\"\n",
                    claim = "[[claims]]\nid = 1\nclaim = \"c\"\nsource = \"s\"\nclaimed = \"c\"\n",
                    measure =
                        "[[claims.measures]]\nname = \"duplicates\"\nscenes = [\"builtin:cornell-box\"]\n"
                        "expect = { bvh = [1, 1] }\n",
                    row =
                        "integrators = [\"path\"]\nbudget = { samples = 1 }\n[[stress]]\nid = 1\nname = \"n\"\n"
                        "failure = \"f\"\nsource = \"s\"\nscene = \"builtin:edge\"\nx = \"x\"\nrange = [1, 2]\n"
                        "holds = { bias = [0, 0.5] }\n";
  const std::map<std::string, std::string> experiments{
      {"The file", base + z},
      {"budget", "scenes = [\"builtin:cornell-box\"]\nbudget = { samples = 1, " + z + " }\n"},
      {"reference", base + "reference = { samples = 16, " + z + " }\n"},
      {"structures", base + "structures = { " + z + " }\n"},
      {"outputs", base + "outputs = { " + z + " }\n"},
      {"regions", base + path + "[[regions]]\n" + z},
      {"predictions", base + path + "[[predictions]]\nmethod = \"path\"\n" + z},
      {"elsewhere", base + path +
                        "[[elsewhere]]\nscene = \"s\"\nprogram = \"p\"\nmethod = \"m\"\nmachine = \"m\"\ndate = \"d\"\n"
                        "source = \"s\"\ntime = 1\nerror = 1\n" +
                        z},
      {"dynamic", "scenes = [\"builtin:cornell-box\"]\n[dynamic]\n" + z},
      {"points", "scenes = [\"builtin:cornell-box\"]\n[points]\n" + z},
      {"records", "scenes = [\"builtin:cornell-box\"]\n[records]\n" + z},
      {"throughput", "scenes = [\"builtin:cornell-box\"]\n" + path + "[throughput]\n" + z},
      {"ledger", base + "[[ledger]]\ncomponent = \"c\"\non = { mis = \"auto\" }\noff = { mis = \"light\" }\n" + z},
      {"claims", claim + z + "\n" + measure},
      {"claims.measures", claim + measure + z},
      {"timing", "timing = { " + z + " }\n" + claim + measure},
      {"stress", row + z},
      {"stress.alternative", row + "alternative = { scene = \"builtin:edge\", methods = [\"path\"], " + z + " }\n"},
      {"stress.remedies", row + "[[stress.remedies]]\nof = \"path\"\nname = \"n\"\nchange = {}\n" + z},
      {"stress.rows", row + "rows = { of = \"path\", y = \"y\", values = [1, 2], " + z + " }\n"},
      {"sweep", "sweep = { " + z + " }\n" + row}};
  const std::map<std::string, Keys> documented = documented_keys();
  for (const auto& [section, keys] : documented) EXPECT_TRUE(experiments.contains(section)) << section;
  for (const auto& [section, experiment] : experiments) {
    ASSERT_TRUE(documented.contains(section)) << section;
    EXPECT_EQ(documented.at(section), parsed_keys(experiment)) << section;
  }
}

}  // namespace
}  // namespace etendue
