// Regions and rates from the experiment to the report.
#include "experiments/report/rates.h"
#include "experiments/log/json_line.h"
#include "framework/image/metrics.h"
#include "framework/io/image/exr.h"
#include "tests/unit/experiment_text.h"
#include "tests/unit/harness_process.h"
#include "tests/unit/report_helpers.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using namespace report_test;

constexpr const char* rates_base =
    "scenes = [\"builtin:lambert-sphere\", \"builtin:furnace\"]\n"
    "integrators = [\"path\", { name = \"photon-map\", k = 20 }]\n"
    "budget = { samples = 64 }\n"
    "[[regions]]\n"
    "name = \"left\"\n"
    "scene = \"builtin:furnace\"\n"
    "from = [0, 0.25]\n"
    "to = [0.5, 0.75]\n"
    "[[predictions]]\n"
    "method = \"photon-map k=20\"\n"
    "region = \"left\"\n"
    "from = 4\n"
    "expect = { exponent = \"-2/3\" }\n"
    "source = \"theory\"\n";

std::string rates_with(const std::string& from, const std::string& to) { return replaced(rates_base, from, to); }

TEST(Regions, HoldThePixelsWhoseCentresLieInside) {
  const ExperimentConfig config = parse_experiment(rates_base, "x.toml");
  const auto regions = make_regions(config.regions, "builtin:furnace", {4, 4});
  ASSERT_EQ(regions.size(), 1u);
  EXPECT_EQ(regions[0].pixels, (std::vector<std::size_t>{4, 5, 8, 9}));
  EXPECT_TRUE(make_regions(config.regions, "builtin:lambert-sphere", {4, 4}).empty());
}

TEST(Regions, PolygonIsInsideByTheEvenOddRule) {
  const auto config =
      parse_experiment(rates_with("from = [0, 0.25]\nto = [0.5, 0.75]", "polygon = [[0, 0], [1, 0], [0, 1]]"), "x.toml");
  EXPECT_EQ(make_regions(config.regions, "builtin:furnace", {3, 3})[0].pixels, (std::vector<std::size_t>{0, 1, 3}));
}

TEST(Regions, MetricOfARegionIsThatOfItsPixels) {
  Image image({4, 4}), reference({4, 4});
  for (std::size_t i = 0; i < 16; ++i) image.pixels[i] = dvec3(static_cast<double>(i));
  EXPECT_DOUBLE_EQ(mse(crop(image, {"r", {1, 2}}), crop(reference, {"r", {1, 2}})), 2.5);
}

TEST(Regions, SlipsAreErrorsAtTheirPlace) {
  expect_error(rates_with("to = [0.5, 0.75]\n", ""), "x.toml:4:1", "from and to, or polygon");
  expect_error(rates_with("to = [0.5", "to = [1.5"), "x.toml:8:7", "1.5");
  expect_error(rates_with("to = [0.5, 0.75]", "to = [0.5, 0.25]"), "x.toml:8:6", "lower right");
  expect_error(rates_with("scene = \"builtin:furnace\"", "scene = \"builtin:furnce\""), "x.toml:6:9",
               "did you mean 'builtin:furnace'");
  expect_error(rates_with("name = \"left\"\n", ""), "x.toml:4:1", "without a name");
  expect_error(rates_with("from = [0, 0.25]\nto = [0.5, 0.75]", "polygon = [[0, 0], [1, 1]]"), "x.toml:7:11", "three or more");
  expect_error(rates_with("[[predictions]]", "[[regions]]\nname = \"left\"\nfrom = [0, 0]\nto = [1, 1]\n[[predictions]]"),
               "x.toml:9:1", "twice");
  const auto config = parse_experiment(rates_with("to = [0.5, 0.75]", "to = [0.5, 0.26]"), "x.toml");
  EXPECT_THROW(make_regions(config.regions, "builtin:furnace", {8, 8}), Error);
}

TEST(Rates, LawIsReadInFull) {
  const Prediction law = parse_experiment(rates_base, "x.toml").predictions.at(0);
  EXPECT_EQ(law.method, "photon-map k=20");
  EXPECT_EQ(law.region, "left");
  EXPECT_EQ(law.metric, "mse");
  ASSERT_TRUE(law.expected);
  EXPECT_TRUE(law.expected->is_value());
  EXPECT_NEAR(law.expected->low, -2.0 / 3, 1e-15);
  EXPECT_EQ(law.expected->text, "-2/3");
  EXPECT_EQ(law.from, 4);
  EXPECT_FALSE(law.across);
}

TEST(Rates, SlipsAreErrorsAtTheirPlace) {
  expect_error(rates_with("method = \"photon-map k=20\"", "method = \"photon-mop\""), "x.toml:10:10", "photon-map k=20");
  expect_error(rates_with("k=20", "k=21"), "x.toml:10:10", "unknown method");
  expect_error(rates_with("region = \"left\"", "region = \"lft\""), "x.toml:11:10", "did you mean 'left'");
  expect_error(rates_with("region = \"left\"", "region = \"left\"\nscene = \"builtin:lambert-sphere\""), "x.toml:11:10",
               "no region");
  expect_error(rates_with("expect = { exponent = \"-2/3\" }\n", ""), "x.toml:9:1", "nothing is expected");
  expect_error(rates_with("-2/3", "-2/0"), "x.toml:13:23", "fraction");
  expect_error(rates_with("{ exponent =", "{ exponnent ="), "x.toml:13:12", "did you mean 'exponent'");
  expect_error(rates_with("source = \"theory\"\n", ""), "x.toml:13:10", "without a source");
  expect_error(rates_with("from = 4", "from = 4\nto = 3"), "x.toml:13:6", "from < to");
  expect_error(rates_with("from = 4", "x = \"recrods\""), "x.toml:12:5", "did you mean 'records'");
  expect_error(rates_with("from = 4", "metric = \"bias\""), "x.toml:12:10", "did you mean 'bias2'");
  expect_error(rates_with("from = 4", "points = \"configurations\""), "x.toml:10:10", "three or more");
  expect_error(rates_with("budget", "metrics = [\"relmse\"]\nbudget"), "x.toml:10:1", "mse is not among");
  expect_error("scenes = [\"builtin:mesh\"]\n[dynamic]\n[[predictions]]\nx = \"time\"\n", "x.toml:3:3", "of no use");
}

TEST(Rates, LawsDoNotChangeTheExperimentsHashRegionsDo) {
  const std::string hash = parse_experiment(rates_base, "x.toml").hash;
  EXPECT_EQ(parse_experiment(rates_with("from = 4", "from = 8"), "x.toml").hash, hash);
  EXPECT_NE(parse_experiment(rates_with("0.75", "0.8"), "x.toml").hash, hash);
}

TEST(Rates, MethodsAreSelectedByNameAndParameters) {
  EXPECT_TRUE(selects("photon-map", "photon-map k=20 photons=1000"));
  EXPECT_TRUE(selects("photon-map photons=1000", "photon-map k=20 photons=1000"));
  EXPECT_TRUE(selects("x a=0.20", "x a=0.2"));
  EXPECT_FALSE(selects("photon-map k=2", "photon-map k=20"));
  EXPECT_FALSE(selects("photon", "photon-map"));
  EXPECT_FALSE(selects("", "photon-map"));
}

TEST(Rates, RecordAndRegionsSurviveTheLog) {
  const ExperimentConfig config = parse_experiment(rates_base, "x.toml");
  const StatedRecord record{config.predictions, config.regions},
      back = read_record<StatedRecord>(Json::parse(to_json_line(record)));
  EXPECT_EQ(to_json_line(back), to_json_line(record));

  const std::filesystem::path path = std::filesystem::temp_directory_path() / "etendue-rates-log.jsonl";
  RunLog log = small_log();
  CheckpointRecord with_regions = log.checkpoints.front();
  with_regions.regions["left"]["mse"] = 0.25;
  std::string old_line = to_json_line(log.checkpoints.front());
  EXPECT_EQ(old_line.find("regions"), std::string::npos) << "a log without regions is as it was";
  std::ofstream(path) << sealed(to_json_line(record)) << "\n"
                      << sealed(old_line) << "\n"
                      << sealed(to_json_line(with_regions)) << "\n"
                      << sealed(to_json_line(log.cells.front())) << "\n";
  const RunLog read = read_log(path.string());
  EXPECT_EQ(read.stated.predictions, back.predictions);
  ASSERT_EQ(read.checkpoints.size(), 2u);
  EXPECT_TRUE(read.checkpoints[0].regions.empty());
  EXPECT_EQ(read.checkpoints[1].regions.at("left").at("mse"), 0.25);
  EXPECT_EQ(merge_logs({read, read}).stated.predictions.size(), 1u);
  std::filesystem::remove(path);
}

Prediction law(const std::string& method, double exponent, const std::string& text) {
  Prediction law;
  law.method = method;
  law.expected = {exponent, exponent, text};
  law.source = "theory";
  return law;
}

TEST(Rates, LogOfKnownExponentsIsJudgedByThem) {
  RunLog log = small_log();
  log.stated.predictions = {law("path", -1, "-1"), law("sppm", -0.5, "-1/2"), law("nobody", -1, "-1")};
  log.stated.predictions[0].from = 4;
  const ReportData data = arrange(log);
  const auto rates = fit_rates(data);
  ASSERT_EQ(rates.size(), 2u);
  ASSERT_TRUE(rates[0].fit);
  EXPECT_NEAR(rates[0].fit->exponent, -1, 1e-9);
  EXPECT_EQ(rates[0].fit->points, 6u);
  EXPECT_EQ(rates[0].points.size(), 8u) << "drawn are all";
  EXPECT_NEAR(rates[1].fit->exponent, -2.0 / 3, 1e-9);
  const Predictions predictions = exponent_predictions(rates);
  EXPECT_EQ(predictions.rows[0].verdict, Verdict::confirmed);
  EXPECT_EQ(predictions.rows[1].verdict, Verdict::refuted);
  const std::string finding = predictions_finding(predictions);
  EXPECT_NE(finding.find("2 predictions: 1 confirmed, 1 refuted. Not confirmed: sppm in builtin:room: -0.667"),
            std::string::npos)
      << finding;
  const std::string table = to_markdown(predictions_table(predictions));
  EXPECT_NE(table.find("-1/2"), std::string::npos);
  EXPECT_NE(table.find("†"), std::string::npos) << "three seeds are few";
  EXPECT_NE(table.find("Of 2 intervals of 95 %"), std::string::npos) << table;
  EXPECT_TRUE(columns_of_figures_sort(predictions_table(predictions)));
  for (const Figure& figure : rate_figures(rates)) {
    EXPECT_TRUE(well_formed(to_svg(figure)));
    EXPECT_EQ(to_svg(figure).find("nan"), std::string::npos);
  }
}

// Two laws of nearly one slope, on curves that nearly coincide.
TEST(Rates, TrianglesOfTheoryLieApart) {
  RunLog log = small_log();
  add_cells(log, "builtin:room", {"ppm", "sah", 0.1, 0.11, -0.6}, 3);
  log.stated.predictions = {law("sppm", -2.0 / 3, "-2/3"), law("ppm", -0.6, "-3/5")};
  const std::vector<Figure> figures = rate_figures(fit_rates(arrange(log)));
  ASSERT_EQ(figures.size(), 1u);
  std::vector<Interval> heights;
  for (const ChartSeries& series : figures[0].panels.at(0).series)
    if (series.draw == ChartSeries::Draw::context) heights.push_back({series.points[1].y, series.points[0].y});
  ASSERT_EQ(heights.size(), 2u);
  EXPECT_LT(std::min(heights[0].high, heights[1].high), std::max(heights[0].low, heights[1].low));
}

// Below the reference's own noise an error comes out negative: noise decides which points are left.
TEST(Rates, FitsThatLeavePointsOutAreUndecided) {
  RunLog log = small_log();
  log.references[0] = reference("builtin:room", 0.005);  // the MSE ends at 0.5 / 128
  log.stated.predictions = {law("path", -1, "-1")};
  const auto rates = fit_rates(arrange(log));
  ASSERT_TRUE(rates.at(0).fit);
  const Predictions predictions = exponent_predictions(rates);
  EXPECT_EQ(predictions.rows.at(0).verdict, Verdict::undecided);
  EXPECT_NE(to_markdown(predictions_table(predictions)).find("7 of 8"), std::string::npos);
}

TEST(Rates, ReferencesOfUnknownNoiseLeaveExponentsUndecided) {
  RunLog log = small_log();
  log.references[0].source = "given.exr";
  log.references[0].checks = "none: given by the experiment, its variance unknown";
  log.stated.predictions = {law("path", -1, "-1")};
  const Predictions predictions = exponent_predictions(fit_rates(arrange(log)));
  EXPECT_EQ(predictions.rows.at(0).verdict, Verdict::undecided);
  EXPECT_NE(to_markdown(predictions_table(predictions)).find("where nobody knows it"), std::string::npos);
}

TEST(Rates, ConfigurationsArePointsOfOneFit) {
  RunLog log;
  for (const int records : {100, 200, 400, 800}) {
    const std::string name = "irradiance-cache accuracy=" + std::to_string(records) + " gradients=both";
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      add_cell(log, "room", {name, "sah", 0.1, 1, -1, 1}, seed);
      CheckpointRecord& last = log.checkpoints.back();
      last.counters["records"] = static_cast<std::uint64_t>(records) + seed;
      last.metrics["mse"] = std::pow(static_cast<double>(records), -2) * (1 + 0.01 * static_cast<double>(seed));
    }
  }
  log.stated.predictions = {law("irradiance-cache gradients=both", -1, "-1")};
  log.stated.predictions[0].metric = "rmse";
  log.stated.predictions[0].x = "records";
  log.stated.predictions[0].across = true;
  const ReportData data = arrange(log);
  const auto rates = fit_rates(data);
  ASSERT_EQ(rates.size(), 1u);
  ASSERT_TRUE(rates[0].fit) << rates[0].problem;
  EXPECT_EQ(rates[0].points.size(), 4u);
  EXPECT_EQ(rates[0].seeds, 5u);
  EXPECT_NEAR(rates[0].fit->exponent, -1, 0.02) << "a few records more than in their names";
}

TEST(Rates, WhatCannotBeFittedSaysWhy) {
  RunLog log = small_log();
  log.stated.predictions = {law("path", -1, "-1"), law("path", -1, "-1"), law("path", -1, "-1")};
  log.stated.predictions[0].from = 1e6;
  log.stated.predictions[1].metric = "bias2";
  log.stated.predictions[2].region = "edge";
  log.stated.regions.push_back({"edge", "", {{0, 0}, {1, 0}, {1, 1}}, {}});
  const ReportData data = arrange(log);
  const auto rates = fit_rates(data);
  ASSERT_EQ(rates.size(), 3u);
  EXPECT_NE(rates[0].problem.find("0 of 8 points"), std::string::npos);
  EXPECT_NE(rates[1].problem.find("image"), std::string::npos);
  EXPECT_NE(rates[2].problem.find("'edge' was not logged"), std::string::npos);
  const std::string table = to_markdown(predictions_table(exponent_predictions(rates)));
  EXPECT_NE(table.find("was not logged"), std::string::npos);
  EXPECT_EQ(table.find("Of 3 intervals"), std::string::npos) << "there is none";
}

class RatesRun : public ProgramTest {};

TEST_F(RatesRun, ExperimentEndsInATableAndChartsOfRates) {
  write_file(
      "small.toml",
      "scenes = [\"builtin:polygon-light\"]\nseeds = 3\nbudget = { samples = 32 }\nresolution = [12, 12]\n"
      "metrics = [\"mse\"]\n[[integrators]]\nname = \"path\"\nsampler = \"independent\"\n"
      "[[regions]]\nname = \"middle\"\nfrom = [0.25, 0.25]\nto = [0.75, 0.75]\n"
      "[[predictions]]\nmethod = \"path\"\nregion = \"middle\"\nexpect = { exponent = -1 }\nsource = \"independent samples\"\n"
      "[[predictions]]\nmethod = \"path\"\nregion = \"middle\"\nmetric = \"variance\"\nexpect = { exponent = -1 }\nsource = "
      "\"same\"\n");
  const Outcome outcome = run({"run", "small.toml", "--threads", "1"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("2 predictions: "), std::string::npos) << outcome.out;
  const auto out = directory_ / "out/small";
  EXPECT_NE(read_text_file(out / "tables/predictions.csv").find("variance over iterations"), std::string::npos);
  EXPECT_TRUE(well_formed(read_text_file(out / "charts/rate-polygon-light-middle-variance-iterations.svg")));
  EXPECT_NE(read_text_file(out / "report.html").find("id=\"predictions\""), std::string::npos);

  const RunLog log = read_log((out / "runs.jsonl").string());
  const CheckpointRecord& last = log.checkpoints.back();
  const Image image = read_exr((out / log.cells.back().image).string());
  const Image reference = read_exr((out / log.references.front().file).string());
  const Region middle = make_regions(log.stated.regions, "builtin:polygon-light", {12, 12}).at(0);
  EXPECT_NEAR(last.regions.at("middle").at("mse"), mse(crop(image, middle), crop(reference, middle)),
              1e-5 * last.metrics.at("mse"));
  const Image strip = read_exr((out / log.cells.back().strip).string());
  EXPECT_EQ(strip.size.y, 12 * 6) << "1, 2, 4, ..., 32 iterations";
  EXPECT_TRUE(std::equal(image.pixels.begin(), image.pixels.end(), strip.pixels.end() - 144));
}

TEST_F(RatesRun, RecordsAreCountedWhereTheErrorIs) {
  write_file(
      "cache.toml",
      "scenes = [\"builtin:broad-light?veil=false\"]\nbudget = { samples = 1 }\nresolution = [48, 48]\nreference = \"exact\"\n"
      "metrics = [\"mse\"]\n[[integrators]]\nname = \"irradiance-cache\"\nfill = \"closed-form\"\ncache_direct = true\n"
      "refine = false\nmax_spacing = 0.05\nneighbour_clamping = false\n"
      "[[regions]]\nname = \"left\"\nfrom = [0, 0]\nto = [0.5, 1]\n[[regions]]\nname = \"right\"\nfrom = [0.5, 0]\nto = [1, "
      "1]\n"
      "[[predictions]]\nmethod = \"irradiance-cache\"\nregion = \"left\"\nx = \"records\"\nexpect = { exponent = -1 }\nsource "
      "= \"none\"\n");
  const Outcome outcome = run({"run", "cache.toml", "--threads", "1"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const RunLog log = read_log((directory_ / "out/cache/runs.jsonl").string());
  const CheckpointRecord& last = log.checkpoints.back();
  const double left = last.regions.at("left").at("records"), right = last.regions.at("right").at("records");
  EXPECT_GT(left, 5);
  EXPECT_GT(right, 5);
  EXPECT_EQ(left + right, static_cast<double>(last.counters.at("records")));
}

}  // namespace
}  // namespace etendue
