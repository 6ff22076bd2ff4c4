// Names that reports give to methods: the experiment's own labels, and in charts the shortest names that tell them apart.
#include "experiments/report/method_names.h"
#include "experiments/config/config.h"
#include "experiments/log/json_line.h"
#include "experiments/report/charts/charts.h"
#include "experiments/report/report_data.h"
#include "experiments/report/tables.h"
#include "experiments/report/verdicts.h"
#include "tests/unit/experiment_text.h"
#include "tests/unit/report_helpers.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

using namespace report_test;
using NameList = std::vector<std::string>;

NameList shortened(const NameList& full_names, const std::map<std::string, std::string>& labels = {}) {
  const ChartNames names = chart_names(full_names, labels);
  NameList found;
  for (const std::string& name : full_names) found.push_back(names.by_full_name.at(name));
  return found;
}

TEST(MethodNames, LeaveOutWhatIsTheSame) {
  const NameList names{"cache fill=paths metric=split records=1000", "cache fill=paths metric=hessian records=1000",
                       "cache fill=paths metric=hessian records=500"};
  EXPECT_EQ(shortened(names),
            (NameList{"metric=split records=1000", "metric=hessian records=1000", "metric=hessian records=500"}));
  EXPECT_EQ(chart_names(names, {}).left_out, NameList{"cache fill=paths"});
}

TEST(MethodNames, KeepTheNameBesideOthers) {
  const NameList names{"path", "ppm alpha=0.7 photons=1", "ppm alpha=0.7 photons=2", "cache samples=256"};
  EXPECT_EQ(shortened(names), (NameList{"path", "ppm photons=1", "ppm photons=2", "cache"}));
  EXPECT_EQ(chart_names(names, {}).left_out, (NameList{"ppm alpha=0.7", "cache samples=256"}));
}

TEST(MethodNames, SayThatThePlainMethodLacksWhatTheOthersShare) {
  const NameList names{"cache metric=a refine=false", "cache metric=b refine=false", "cache"};
  EXPECT_EQ(shortened(names), (NameList{"cache metric=a", "cache metric=b", "cache"}));
  EXPECT_EQ(chart_names(names, {}).left_out, NameList{"cache with parameters: refine=false"});
}

TEST(MethodNames, StayAsTheyAreWhereShorterOnesWouldBeEqual) {
  const NameList names{"path", "path max_depth=5"};
  EXPECT_EQ(shortened(names), names);
  EXPECT_TRUE(chart_names(names, {}).left_out.empty());
}

TEST(MethodNames, AreTheLabelsWhereThereAreSome) {
  EXPECT_EQ(shortened({"ppm photons=1", "ppm photons=2", "path"}, {{"ppm photons=1", "few"}, {"ppm photons=2", "many"}}),
            (NameList{"few", "many", "path"}));
  // A label that another method's short name would be.
  EXPECT_EQ(shortened({"path max_depth=5", "ppm photons=1"}, {{"path max_depth=5", "ppm"}}),
            (NameList{"ppm", "ppm photons=1"}));
}

// --- in the experiment's file ---

ExperimentConfig with_methods(const std::string& methods) {
  return parse_experiment("scenes = [\"builtin:cornell-box\"]\nbudget = { samples = 1 }\n" + methods, "labels.toml");
}

TEST(MethodLabels, ChangeNoNameAndNoHash) {
  const ExperimentConfig plain = with_methods("integrators = [{ name = \"path\", max_depth = 5 }]\naccels = [\"median\"]"),
                         labelled = with_methods(
                             "integrators = [{ name = \"path\", max_depth = 5, label = \"short\" }]\naccels = [\"median\"]");
  EXPECT_EQ(labelled.integrators.front().shown_as, "short");
  EXPECT_EQ(labelled.integrators.front().label(), plain.integrators.front().label());
  EXPECT_EQ(labelled.hash, plain.hash);
}

TEST(MethodLabels, AreToldApartByTheParametersThatAnArrayVaries) {
  const auto config =
      with_methods("integrators = [{ name = \"path\", max_depth = [2, 3], mis = [\"bsdf\"], label = \"paths\" }]");
  ASSERT_EQ(config.integrators.size(), 2u);
  EXPECT_EQ(config.integrators[0].shown_as, "paths max_depth=2");
  EXPECT_EQ(config.integrators[1].shown_as, "paths max_depth=3");
}

TEST(MethodLabels, AreRefusedWhereTheyTellNothing) {
  const std::string base = "scenes = [\"builtin:cornell-box\"]\nbudget = { samples = 1 }\n";
  EXPECT_NE(config_error(base + "integrators = [{ name = \"path\", label = \" \" }]").find("1 to 80"), std::string::npos);
  EXPECT_NE(config_error(base + "integrators = [{ name = \"path\", label = 3 }]").find("text"), std::string::npos);
  EXPECT_NE(config_error(base + "integrators = [\"path\", { name = \"sppm\", label = \"path\" }]").find("labels that differ"),
            std::string::npos);
}

TEST(MethodLabels, StandInTheLogBesideThePredictions) {
  StatedRecord stated;
  EXPECT_EQ(to_json_line(stated).find("labels"), std::string::npos);
  stated.labels = {{"path max_depth=5", "short"}};
  EXPECT_EQ(read_record<StatedRecord>(Json::parse(to_json_line(stated))).labels, stated.labels);
}

// --- in a report ---

RunLog labelled_log() {
  RunLog log = small_log();
  log.stated.labels = {{"sppm", "photons, pass by pass"}, {"sah", "a tree"}};
  return log;
}

TEST(MethodLabels, AreWhatReadersSeeAndNotPrograms) {
  const RunLog log = labelled_log();
  const ReportData data = arrange(log);
  const Table table = final_table(data);
  const std::size_t column = *column_of(table, "integrator");
  const TableCell& best = table.rows[0][column];
  EXPECT_EQ(best.text, "photons, pass by pass");
  EXPECT_EQ(best.raw, "sppm");
  EXPECT_FALSE(table.columns[column].right);
  EXPECT_NE(to_markdown(table).find("photons, pass by pass is sppm"), std::string::npos);
  EXPECT_NE(curves_csv(data).find(",sah,sppm,"), std::string::npos);
}

TEST(MethodLabels, AreInLegendsAndFindings) {
  const RunLog log = labelled_log();
  const ReportData data = arrange(log);
  const Figure figure = error_figure(data, data.scenes[0], "relmse", Abscissa::time, Scale::log);
  EXPECT_EQ(figure.panels[0].series[1].label, "photons, pass by pass");
  EXPECT_EQ(conclude(data).scenes[0].findings[0].lead.find("photons, pass by pass"), 0u);
}

TEST(MethodNames, AreShortInChartsAndFindingsButNotInTables) {
  RunLog log;
  log.manifests.push_back(manifest());
  add_cells(log, "room", {"ppm alpha=0.7 photons=1000"}, 1);
  add_cells(log, "room", {"ppm alpha=0.7 photons=2000", "sah", 0.1, 2}, 1);
  const ReportData data = arrange(log);
  const Figure figure = error_figure(data, data.scenes[0], "relmse", Abscissa::time, Scale::log);
  EXPECT_EQ(figure.panels[0].series[0].label, "photons=1000");
  EXPECT_EQ(figure.notes.back(), "Left out of names: ppm alpha=0.7.");
  EXPECT_EQ(conclude(data).scenes.at(0).findings.at(0).lead.find("photons=1000 has the least"), 0u)
      << conclude(data).scenes.at(0).findings.at(0).lead;
  EXPECT_NE(summary_table(log).find("Left out of names: ppm alpha=0.7."), std::string::npos);
  EXPECT_EQ(final_table(data).rows[0][*column_of(final_table(data), "integrator")].text, "ppm alpha=0.7 photons=1000");
}

}  // namespace
}  // namespace etendue
