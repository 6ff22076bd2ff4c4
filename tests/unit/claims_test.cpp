// Experiments on claims: the way from their TOML to their report.
#include "experiments/kinds/claims/claims.h"
#include "experiments/run/run.h"
#include "tests/places.h"
#include "tests/unit/experiment_text.h"
#include "tests/unit/harness_process.h"
#include "tests/unit/kind_records.h"

#include <algorithm>
#include <set>

namespace etendue {
namespace {

ClaimFigure figure(FigureKind kind, Measured measured, double low, double high) {
  return {"q", "q", kind, measured, true, {low, high}};
}

constexpr const char* claims_experiment =
    "title = \"Two claims\"\n"
    "timing = { resolution = 16, repetitions = 2 }\n"
    "[[claims]]\n"
    "id = 5\n"
    "claim = \"a tree is <good>\"\n"
    "source = \"notes\"\n"
    "claimed = \"2x\"\n"
    "[[claims.measures]]\n"
    "name = \"recursion\"\n"
    "scenes = [\"builtin:cornell-spheres\", \"claim:objects?count=20\"]\n"
    "expect = { iterative = [1, inf] }\n"
    "[[claims]]\n"
    "id = 11\n"
    "claim = \"nodes\"\n"
    "source = \"other notes\"\n"
    "claimed = \"64\"\n"
    "reading = \"bytes\"\n"
    "[[claims.measures]]\n"
    "name = \"node-arithmetic\"\n"
    "scenes = [\"builtin:cornell-box\"]\n"
    "expect = { node_bytes = [64, 64] }\n"
    "[[claims.measures]]\n"
    "name = \"duplicates\"\n"
    "scenes = [\"builtin:cornell-box\"]\n"
    "large = true\n";

std::string claims_with(const std::string& from, const std::string& to) { return replaced(claims_experiment, from, to); }

TEST(ClaimsConfig, ValidFileIsReadInFull) {
  const ExperimentConfig config = parse_experiment(claims_experiment, "x.toml");
  const auto& choice = choice_of<ClaimsChoice>(config);
  EXPECT_EQ(choice.resolution, 16);
  ASSERT_EQ(choice.rows.size(), 2u);
  EXPECT_EQ(choice.rows[1].reading, "bytes");
  EXPECT_TRUE(choice.rows[1].measures[1].large);
  const std::vector<Cell> cells = make_cells(config);
  ASSERT_EQ(cells.size(), 4u);
  EXPECT_EQ(cells[1].name.key(), "claim:objects?count=20 | recursion | claim-05 | seed=1");
}

TEST(ClaimsConfig, QuickLeavesOutWhatIsLarge) {
  EXPECT_EQ(make_cells(parse_experiment(claims_experiment, "x.toml", {true, {}})).size(), 3u);
}

TEST(ClaimsConfig, SlipsAreErrorsAtTheirPlace) {
  const std::tuple<std::string, std::string, std::string> slips[] = {
      {claims_with("name = \"recursion\"", "name = \"recursoin\""), "x.toml:9:8", "recursion"},
      {claims_with("iterative = [1", "itterative = [1"), "x.toml:11:12", "iterative"},
      {claims_with("[1, inf]", "[2, 1]"), "x.toml:11:", "low <= high"},
      {claims_with("[1, inf]", "[1]"), "x.toml:11:", "interval"},
      {claims_with("{ iterative = [1, inf] }", "{}"), "x.toml:11:10", "one of iterative"},
      {claims_with("objects?count=20", "objects?cuont=20"), "x.toml:10:38", "count"},
      {claims_with("claim:objects", "claim:object"), "x.toml:10:38", "objects"},
      {claims_with("claim:objects?count=20", "builtin:cornell-spheres"), "x.toml:10:38", "twice"},
      {claims_with("id = 11", "id = 5"), "x.toml:12:", "twice"},
      {claims_with("claimed = \"64\"\n", ""), "x.toml:12:", "claimed"},
      {claims_with("expect = { node_bytes = [64, 64] }\n", ""), "x.toml:12:", "expect"},
      {claims_with("resolution = 16", "resolutoin = 16"), "x.toml:2:12", "resolution"},
      {claims_with("repetitions = 2", "repetitions = 0"), "x.toml:2:", "out of range"},
      {claims_with("timing", "seeds = 3\ntiming"), "x.toml:2:1", "seeds"},
      {claims_with("large = true", "large = 1"), "x.toml:25:9", "true or false"},
      {"scenes = [\"builtin:mesh\"]\nstructures = true\ntiming = { repetitions = 2 }\n", "x.toml:3:1", "claims"}};
  for (const auto& [text, place, piece] : slips) {
    const std::string what = config_error(text);
    EXPECT_TRUE(what.starts_with(place)) << what;
    EXPECT_NE(what.find(piece), std::string::npos) << what;
  }
}

TEST(ClaimsExperiment, HoldsEveryClaimOnce) {
  const ExperimentConfig config = load_config(std::string(project_folder) + "experiments/claims.toml");
  std::vector<int> ids;
  for (const Claim& claim : choice_of<ClaimsChoice>(config).rows) ids.push_back(claim.id);
  std::vector<int> all(27);
  for (int i = 0; i < 27; ++i) all[static_cast<std::size_t>(i)] = i + 1;
  EXPECT_EQ(ids, all);
}

TEST(ClaimsExperiment, UsesEveryMeasurement) {
  std::set<const Measurement*> used;
  for (const char* file : {"claims.toml", "contents.toml", "coarse-geometry.toml"}) {
    const ExperimentConfig config = load_config(std::string(project_folder) + "experiments/" + file);
    for (const Claim& claim : choice_of<ClaimsChoice>(config).rows)
      for (const ClaimMeasure& measure : claim.measures) used.insert(measure.measurement);
  }
  for (const Measurement& measurement : measurements()) {
    EXPECT_TRUE(used.contains(&measurement)) << measurement.name << " exists for no claim";
  }
}

ClaimRecord sample_record() {
  ClaimRecord record;
  record.cell = {"claim:objects", "recursion", "claim-05", 1};
  record.manifest = "m";
  record.status = "done";
  record.id = 5;
  record.claim = "x \"<y>\"";
  record.source = "s";
  record.claimed = "2x";
  record.reading = "r";
  record.figures = {figure(FigureKind::factor, {1.1, 1.05, 1.33333333}, 1, endless),
                    figure(FigureKind::time, {0.1, 0.1, 0.2}, 0.08, 0.125)};
  record.figures.push_back({"beside", "beside", FigureKind::plain, {3, 3, 3}});
  record.remarks = {"one", "two"};
  record.disagreements = 2;
  return record;
}

TEST(ClaimRecord, LineIsReadBack) {
  const ClaimRecord record = sample_record();
  const std::string line = record.line();
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const auto read = read_back<ClaimRecord>(line);
  EXPECT_EQ(read.cell, record.cell);
  ASSERT_EQ(read.figures.size(), 3u);
  EXPECT_EQ(read.figures[0].expected.high, endless);
  EXPECT_EQ(read.figures[0].value.high, record.figures[0].value.high);
  EXPECT_EQ(read.figures[1].kind, FigureKind::time);
  EXPECT_FALSE(read.figures[2].judged);
  EXPECT_EQ(read.line(), line);
}

TEST(ClaimsReport, VerdictFollowsTheFigures) {
  RunLog log;
  ClaimRecord record = sample_record();
  record.figures.resize(1);
  add_record(log, record);
  ASSERT_EQ(arrange_claims(log).size(), 1u);
  EXPECT_EQ(arrange_claims(log)[0].verdict, Verdict::confirmed);
  record.cell.scene = "builtin:mesh";
  record.figures[0].value = {0.9, 0.8, 0.95};
  add_record(log, record);
  const std::vector<ClaimFindings> claims = arrange_claims(log);
  ASSERT_EQ(claims.size(), 1u);
  EXPECT_EQ(claims[0].verdict, Verdict::depends);
  EXPECT_EQ(claims[0].on_what, "confirmed: objects | refuted: mesh");
  EXPECT_NE(claims_report(log).section.find("x &quot;&lt;y&gt;&quot;"), std::string::npos) << "made safe for HTML";
  EXPECT_EQ(claims_table(log).rows.size(), 1u);
  EXPECT_EQ(claims_report(log).predictions.rows.size(), 2u);
}

class ClaimsRun : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file("two.toml", claims_experiment);
  }
};

TEST_F(ClaimsRun, WritesLogTablesAndPageAndResumes) {
  const Outcome first = run({"run", "two.toml", "--threads", "1", "--filter", "claim-05"});
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_NE(first.out.find("1 statement: "), std::string::npos) << first.out;
  const Outcome rest = run({"run", "two.toml", "--threads", "1"});
  ASSERT_EQ(rest.status, 0) << rest.err;
  EXPECT_NE(rest.err.find("2 of 4 cells are done already"), std::string::npos) << rest.err;
  const Outcome plan = run({"run", "two.toml", "--threads", "1", "--dry-run"});
  EXPECT_NE(plan.err.find("4 cells, 0 to run"), std::string::npos) << plan.err;
  const std::string page = read_text_file(directory_ / "out/two/report.html");
  EXPECT_NE(page.find("a tree is &lt;good&gt;"), std::string::npos);
  EXPECT_EQ(page.find("holds no finished cell"), std::string::npos);
  const std::string table = read_text_file(directory_ / "out/two/tables/claims.md");
  EXPECT_NE(table.find("| verdict"), std::string::npos) << table;
  std::filesystem::remove_all(directory_ / "out/two/tables");
  ASSERT_EQ(run({"report", "out/two", "--out", "out/two"}).status, 0);
  EXPECT_EQ(read_text_file(directory_ / "out/two/tables/claims.md"), table) << "from the log alone";
}

TEST_F(ClaimsRun, ReadsSceneFilesAsTheCommandSays) {
  write_file("rough.pbrt",
             "WorldBegin\nMaterial \"matte\" \"float sigma\" 20\n"
             "Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 2]\n");
  write_file(
      "rough.toml",
      "title = \"One claim\"\n[[claims]]\nid = 1\nclaim = \"nodes\"\nsource = \"notes\"\nclaimed = \"64\"\n"
      "[[claims.measures]]\nname = \"node-arithmetic\"\nscenes = [\"rough.pbrt\"]\nexpect = { node_bytes = [64, 64] }\n");
  const Outcome exact = run({"run", "rough.toml", "--threads", "1"});
  EXPECT_EQ(exact.status, 2) << exact.err;
  EXPECT_NE(exact.err.find("--approximate"), std::string::npos) << exact.err;
  const Outcome approximate = run({"run", "rough.toml", "--threads", "1", "--approximate"});
  EXPECT_EQ(approximate.status, 0) << approximate.err;
}

}  // namespace
}  // namespace etendue
