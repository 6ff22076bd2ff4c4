// experiment.toml: every slip is an error at its line and column; overrides and --quick take the place of what the file says.
#include "tests/unit/experiment_text.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace etendue {
namespace {

constexpr const char* valid =
    "title = \"A question\"\n"
    "scenes = [\"builtin:lambert-sphere\", \"builtin:cornell-box\"]\n"
    "accels = [\"binned-sah\", { name = \"median\", leaf_size = 2 }]\n"
    "seeds = 3\n"
    "budget = { time = \"1.5min\", checkpoints = \"sqrt2\" }\n"
    "[[integrators]]\n"
    "name = \"path\"\n"
    "max_depth = 7\n"
    "[[integrators]]\n"
    "name = \"photon-map\"\n"
    "photons = \"20k\"\n"
    "[quick]\n"
    "seeds = [5]\n"
    "budget = { samples = 2 }\n";

ExperimentConfig parse(const std::string& text, const ConfigOptions& options = {}) {
  return parse_experiment(text, "x.toml", options);
}

std::string config_with(const std::string& from, const std::string& to) { return replaced(valid, from, to); }

TEST(ExperimentConfig, ValidFileIsReadInFull) {
  const ExperimentConfig config = parse(valid);
  EXPECT_EQ(config.title, "A question");
  ASSERT_EQ(config.scenes.size(), 2u);
  EXPECT_EQ(config.scenes[1].path, "builtin:cornell-box");
  ASSERT_EQ(config.accels.size(), 2u);
  EXPECT_EQ(config.accels[1].label(), "median leaf_size=2");
  ASSERT_EQ(config.integrators.size(), 2u);
  EXPECT_EQ(config.integrators[1].label(), "photon-map photons=20000");
  EXPECT_EQ(config.seeds, (std::vector<std::uint64_t>{1, 2, 3}));
  EXPECT_DOUBLE_EQ(config.budget.time_s.value(), 90);
  EXPECT_FALSE(config.budget.samples.has_value());
  EXPECT_NEAR(config.budget.checkpoints.factor, 1.41421356, 1e-6);
  EXPECT_EQ(config.metrics, (std::vector<std::string>{"mse", "relmse", "trimmed_relmse", "smape", "bias"}));  // FLIP costs time
}

TEST(ExperimentConfig, ArraysOfValuesMakeEveryCombinationOnce) {
  const auto labels = [](const ExperimentConfig& config) {
    std::vector<std::string> all;
    for (const Method& method : config.integrators) all.push_back(method.label());
    return all;
  };
  const std::string text = config_with("max_depth = 7", "mis = [\"bsdf\", \"light\"]\nmax_depth = [7, \"1k\"]");
  EXPECT_EQ(labels(parse(text)),
            (std::vector<std::string>{"path max_depth=7 mis=bsdf", "path max_depth=7 mis=light", "path max_depth=1000 mis=bsdf",
                                      "path max_depth=1000 mis=light", "photon-map photons=20000"}));
  EXPECT_EQ(labels(parse(valid, {false, {"integrators.photon-map.photons=[10, 20]"}})),
            (std::vector<std::string>{"path max_depth=7", "photon-map photons=10", "photon-map photons=20"}));
  const ExperimentConfig accels = parse(config_with("leaf_size = 2", "leaf_size = [2, 4]"));
  ASSERT_EQ(accels.accels.size(), 3u);
  EXPECT_EQ(accels.accels[2].label(), "median leaf_size=4");

  expect_error(config_with("max_depth = 7", "max_depth = []"), "x.toml:8:13", "integrators.max_depth is empty");
  expect_error(config_with("max_depth = 7", "max_depth = [7, -7]"), "x.toml:8:17", "out of range");
  expect_error(config_with("max_depth = 7", "max_depth = [7, [8]]"), "x.toml:8:17",
               "an array; expected a boolean, a number or text");
  expect_error(config_with("max_depth = 7", "max_depth = [7, 7]"), "x.toml:8:17",
               "integrators: max_depth of path lists 7 twice");
  expect_error(config_with("max_depth = 7", "mis = [\"bsdf\", \"light\"]\nmax_depth = [3, 7, \"3\"]"), "x.toml:9:20",
               "max_depth of path lists 3 twice");
  expect_error(config_with("leaf_size = 2", "leaf_size = [2, 2]"), "x.toml:3:60", "accels: leaf_size of median lists 2 twice");
  expect_error(config_with("max_depth = 7", "max_depth = {}"), "x.toml:8:13", "or an array of these");
  std::string many = "[1";
  for (int i = 2; i <= 200; ++i) many += fmt::format(", {}", i);
  many += "]";
  expect_error(config_with("max_depth = 7", "max_depth = " + many + "\nroulette_depth = " + many), "x.toml:9:18",
               "makes 40000 combinations of the arrays so far; expected 10000 at most");
}

TEST(ExperimentConfig, QuickReplacesWholeKeys) {
  const ExperimentConfig config = parse(valid, {true, {}});
  EXPECT_EQ(config.seeds, (std::vector<std::uint64_t>{5}));
  EXPECT_EQ(config.budget.samples.value(), 2u);
  EXPECT_FALSE(config.budget.time_s.has_value());
  EXPECT_NE(config.hash, parse(valid).hash);
}

TEST(ExperimentConfig, QuickHasADefault) {
  std::string text = valid;
  text.erase(text.find("[quick]"));
  const ExperimentConfig config = parse(text, {true, {}});
  EXPECT_EQ(config.seeds.size(), 1u);
  EXPECT_LT(config.budget.time_s.value(), 1);
  EXPECT_EQ(config.resolution.value(), ivec2(64, 64));
}

TEST(ExperimentConfig, OverridesAreTypedAndDescend) {
  const ExperimentConfig config = parse(valid, {false,
                                                {"budget.time=5s", "seeds=[7, 9]", "integrators.photon-map.photons=1M",
                                                 "integrators.0.mis=bsdf", "accels.0.leaf_size=8", "title=x = y"}});
  EXPECT_DOUBLE_EQ(config.budget.time_s.value(), 5);
  EXPECT_EQ(config.seeds, (std::vector<std::uint64_t>{7, 9}));
  EXPECT_EQ(config.integrators[1].label(), "photon-map photons=1000000");
  EXPECT_EQ(config.integrators[0].label(), "path max_depth=7 mis=bsdf");
  EXPECT_EQ(config.accels[0].label(), "binned-sah leaf_size=8");
  EXPECT_EQ(config.title, "x = y");
}

TEST(ExperimentConfig, BadOverridesAreErrorsToo) {
  const auto error = [](const std::string& assignment) { return config_error(valid, {false, {assignment}}); };
  EXPECT_NE(error("budget.tmie=5s").find("did you mean 'time'"), std::string::npos) << error("budget.tmie=5s");
  EXPECT_TRUE(error("budget.tmie=5s").starts_with("-o budget.tmie=5s: "));
  EXPECT_NE(error("seeds").find("expected key=value"), std::string::npos);
  EXPECT_NE(error("integrators.5.photons=1").find("out of range"), std::string::npos);
  EXPECT_NE(error("integrators.pth.mis=bsdf").find("did you mean 'path'"), std::string::npos);
  const auto of_two = [](const std::string& assignment) {
    return config_error(replaced(valid, "photon-map", "path"), {false, {assignment}});
  };
  EXPECT_NE(of_two("integrators.path.max_depth=2").find("2 elements are named 'path'; expected the index"), std::string::npos)
      << of_two("integrators.path.max_depth=2");
  EXPECT_EQ(of_two("integrators.0.max_depth=2").find("are named"), std::string::npos);
  EXPECT_NE(error("seeds.x=1").find("a table or an array"), std::string::npos);
  EXPECT_NE(error("a..b=1").find("empty part"), std::string::npos);
  EXPECT_NE(error("quick.seeds=1").find("expected the key itself"), std::string::npos);
  EXPECT_NE(error("budget.time=5parsec").find("unit"), std::string::npos);
}

TEST(ExperimentConfig, SlipsAreErrorsAtTheirPlace) {
  expect_error(config_with("seeds", "sedes"), "x.toml:4:1", "did you mean 'seeds'");
  expect_error(config_with("max_depth = 7", "max_depth = 7\nresolution = [8, 8]"), "x.toml:9:1", "is a key of the file");
  expect_error(config_with("time =", "tme ="), "x.toml:5:12", "did you mean 'time'");
  expect_error(config_with("1.5min", "1.5mn"), "x.toml:5:19", "units: s, ms, min, h");
  expect_error(config_with("\"1.5min\"", "true"), "x.toml:5:19", "a boolean; expected a time");
  expect_error(config_with("seeds = 3", "seeds = \"x\""), "x.toml:4:9", "expected a count");
  expect_error(config_with("seeds = 3", "seeds = 0"), "x.toml:4:9", "expected 1 ..");
  expect_error(config_with("seeds = 3", "seeds = [1, 1]"), "x.toml:4:13", "twice");
  expect_error(config_with("sqrt2", "cubic"), "x.toml:5:43", "linear:N");
  expect_error(config_with("builtin:cornell-box", "builtin:cornel-box"), "x.toml:2:37", "did you mean 'builtin:cornell-box'");
  expect_error(config_with("builtin:cornell-box", "no/such.pbrt"), "x.toml:2:37", "no scene");
  expect_error(config_with("\"path\"", "\"pth\""), "x.toml:7:8", "did you mean 'path'");
  expect_error(config_with("max_depth", "mx_depth"), "x.toml:8:1", "did you mean 'max_depth'");
  expect_error(config_with("max_depth = 7", "max_depth = -7"), "x.toml:8:13", "out of range");
  expect_error(config_with("20k", "20q"), "x.toml:11:11", "unit");
  expect_error(config_with("leaf_size = 2", "leaf_size = 1979-05-27"), "x.toml:3:56", "date");
  expect_error(config_with("\"binned-sah\"", "\"binned\""), "x.toml:3:11", "did you mean 'binned-sah'");
  expect_error(config_with("name = \"photon-map\"", "nam = \"photon-map\""), "x.toml:9:1", "without a name");
  expect_error(config_with("title =", "title"), "x.toml:1:7", "not TOML");
  std::string deep = "a";
  for (int i = 0; i < 50000; ++i) deep += ".a";  // each part would be a table in the one before it
  for (const std::string& text : {"\n" + deep + " = 1", "\nx = {" + deep + " = 1}", "\n[" + deep + "]"})
    expect_error(text, "x.toml:2:1", "a key has more than 32 parts");
  const std::string dots(500, '.');
  EXPECT_NO_THROW(parse_experiment(config_with("title =", "# " + dots + "\ntitle ="), "x.toml"));
  EXPECT_NO_THROW(parse_experiment(config_with("A question", "A question" + dots), "x.toml"));
  expect_error(config_with("A question", "A\\u0000"), "x.toml:1:9", "U+0000");
  expect_error(config_with("1.5min", "1e300h"), "x.toml:5:19", "1e9 s at most");
}

TEST(ExperimentConfig, SlipInQuickIsFoundWithoutQuick) {
  expect_error(config_with("seeds = [5]", "sedes = [5]"), "x.toml:13:1", "did you mean 'seeds'");
}

TEST(ExperimentConfig, MeaninglessCombinationsAreErrors) {
  EXPECT_NE(config_error("").find("no scenes"), std::string::npos);
  EXPECT_NE(config_error("scenes = [\"builtin:furnace\"]").find("no integrators"), std::string::npos);
  EXPECT_NE(config_error("scenes = [\"builtin:furnace\"]\nintegrators = [\"path\"]").find("no budget"), std::string::npos);
  expect_error("scenes = \"builtin:furnace\"\nintegrators = [\"path\"]\nbudget = { error = 0.1 }", "x.toml:3:20", "beside it");
  expect_error("scenes = \"builtin:furnace\"\nintegrators = [\"path\", \"path\"]\nbudget = { samples = 1 }", "x.toml:2:24",
               "twice");
  expect_error(config_with("seeds = 3", "reference = \"exacct\""), "x.toml:4:13", "did you mean 'exact'");
  expect_error(config_with("seeds = 3", "reference = { samples = 2 }"), "x.toml:4:25", "16 ..");
  expect_error(config_with("seeds = 3", "metrics = [\"flp\"]"), "x.toml:4:12", "did you mean 'flip'");
  expect_error(config_with("seeds = 3", "resolution = [64]"), "x.toml:4:14", "[width, height]");
}

TEST(ExperimentConfig, HashIsOfWhatChangesAResult) {
  const std::string hash = parse(valid).hash;
  EXPECT_EQ(parse(std::string("# a comment\n") + valid).hash, hash);
  EXPECT_EQ(parse(config_with("A question", "Another title")).hash, hash);
  EXPECT_EQ(parse(config_with("seeds = 3", "seeds = 3\nthreads = 2")).hash, hash);
  EXPECT_NE(parse(config_with("seeds = 3", "seeds = 4")).hash, hash);
  EXPECT_NE(parse(config_with("max_depth = 7", "max_depth = 8")).hash, hash);
}

TEST(ExperimentConfig, FiguresFromElsewhereChangeNoResult) {
  const std::string base = "scenes = [\"builtin:cornell-box\"]\nbudget = { samples = 1 }\n[[integrators]]\nname = \"path\"\n";
  const std::string figure =
      "[[elsewhere]]\nscene = \"box\"\nprogram = \"p\"\nmethod = \"m\"\nmachine = \"m\"\ndate = \"d\"\nsource = \"s\"\n"
      "time = \"2s\"\nerror = 0.5\n";
  const ExperimentConfig config = parse_experiment(base + figure, "x.toml");
  ASSERT_EQ(config.elsewhere.size(), 1u);
  EXPECT_EQ(config.elsewhere[0].time_s, 2);
  EXPECT_TRUE(config.elsewhere[0].of_scene("scenes/box.pbrt"));
  EXPECT_FALSE(config.elsewhere[0].of_scene("scenes/boxes.pbrt"));
  EXPECT_EQ(config.hash, parse_experiment(base, "x.toml").hash);
  EXPECT_NE(config_error(base + figure + "metric = \"relmsee\"\n").find("did you mean 'relmse'?"), std::string::npos);
}

}  // namespace
}  // namespace etendue
