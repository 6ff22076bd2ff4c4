// The report on methods' defaults beside their other settings.
#include "experiments/report/regret.h"
#include "tests/unit/report_helpers.h"

namespace etendue {
namespace {

using namespace report_test;

std::string cell_of(const Table& table, const char* key) { return table.rows.at(0).at(column_of(table, key).value()).raw; }

TEST(Settings, AreComparedWithTheDefaultsOfTheSameMethodAtEachTime) {
  RunLog log;
  log.manifests.push_back(manifest());
  add_cells(log, "builtin:room", {.integrator = "sppm", .variance = 1, .exponent = -1}, 2);
  add_cells(log, "builtin:room", {.integrator = "sppm radius=1", .variance = 0.5, .exponent = -0.5},
            2);  // level at 4 iterations
  const KindReport report = settings_report(arrange(log));
  ASSERT_EQ(report.tables.size(), 1u);
  EXPECT_EQ(cell_of(report.tables[0], "method"), "sppm");
  EXPECT_EQ(cell_of(report.tables[0], "best_there"), "sppm radius=1");
  EXPECT_NEAR(std::stod(cell_of(report.tables[0], "worst")), std::sqrt(2.0), 1e-6);  // after two iterations, a 64th of the end
  EXPECT_NEAR(std::stod(cell_of(report.tables[0], "worst_time_s")), 0.2, 1e-6);
  EXPECT_EQ(std::stod(cell_of(report.tables[0], "at_end")), 1);
  EXPECT_TRUE(well_formed(to_svg(report.figures.at(0).figures.at(0))));
}

// The noise that all errors hold alike is not the settings' own.
TEST(Settings, AreComparedWithoutTheNoiseOfTheReferenceWhereItIsKnown) {
  RunLog log;
  log.manifests.push_back(manifest());
  add_cells(log, "builtin:room", {.integrator = "sppm", .variance = 1, .exponent = -1}, 2);
  add_cells(log, "builtin:room", {.integrator = "sppm radius=1", .variance = 0.5, .exponent = -1}, 2);
  const auto found = [&] { return settings_report(arrange(log)).tables.at(0); };
  EXPECT_NEAR(std::stod(cell_of(found(), "at_end")), 2, 1e-6);
  EXPECT_EQ(to_markdown(found()).find("noise"), std::string::npos);
  log.references.push_back(reference("builtin:room", 1e-6));
  EXPECT_NEAR(std::stod(cell_of(found(), "at_end")), 2, 1e-6);
  EXPECT_NE(to_markdown(found()).find("hold it, which brings"), std::string::npos);
  const double end = 1.0 / 128;  // about the error of the defaults
  log.references[0].relmse_floor = end / 4;
  EXPECT_NEAR(std::stod(cell_of(found(), "at_end")), 3, 0.3);
  EXPECT_NE(to_markdown(found()).find("is taken from errors"), std::string::npos);
  log.references[0].relmse_floor = 0.6 * end;  // more than the least: a tenth of the noise is left
  EXPECT_NEAR(std::stod(cell_of(found(), "at_end")), 8, 2);
}

TEST(Settings, KeepAMethodsColourInAllScenes) {
  RunLog log;
  log.manifests.push_back(manifest());
  for (const char* method : {"irradiance-cache", "radiance-cache", "photon-cache"})
    for (const char* scene : {"builtin:room", "builtin:door"})
      if (std::string(method) != "radiance-cache" || std::string(scene) == "builtin:room")
        for (const char* setting : {"", " error=1"}) add_cells(log, scene, {.integrator = std::string(method) + setting}, 2);
  const Figure figure = settings_report(arrange(log)).figures.at(0).figures.at(0);
  ASSERT_EQ(figure.panels.size(), 2u);
  ASSERT_EQ(figure.panels[1].series.size(), 2u);
  EXPECT_TRUE(looks_alike_in_all_panels(figure));
}

TEST(Settings, AreNotComparedByTheirBias) {
  RunLog log;
  log.manifests.push_back(manifest());
  for (const char* method : {"sppm", "sppm radius=1"}) add_cells(log, "builtin:room", {.integrator = method}, 2);
  for (CheckpointRecord& record : log.checkpoints) record.metrics = {{"bias", -0.1}};
  EXPECT_TRUE(settings_report(arrange(log)).tables.empty());
}

TEST(Settings, AreNotComparedWhereSomeMethodStandsAlone) {
  RunLog log = small_log();
  add_cells(log, "builtin:room", {.integrator = "sppm radius=1"}, 3);
  EXPECT_TRUE(settings_report(arrange(log)).tables.empty());
}

}  // namespace
}  // namespace etendue
