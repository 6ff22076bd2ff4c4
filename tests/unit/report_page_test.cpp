#include "experiments/kinds/claims/claims.h"
#include "experiments/report/page/html.h"
#include "experiments/report/page/images.h"
#include "experiments/report/report.h"
#include "experiments/report/tables.h"
#include "experiments/run/run.h"
#include "framework/core/error.h"
#include "framework/io/image/exr.h"
#include "tests/unit/report_helpers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace etendue {
namespace {

using namespace report_test;
namespace fs = std::filesystem;

std::string page_of(const RunLog& log) {
  const ReportData data = arrange(log);
  PageContent content;
  content.tables = report_tables(data);
  return report_page(data, content);
}

TEST(Page, NeedsNothingBeyondItself) {
  const std::string page = page_of(small_log());
  EXPECT_EQ(page.find("src=\"http"), std::string::npos);
  EXPECT_EQ(page.find("href=\"http"), std::string::npos);
  EXPECT_EQ(page.find("@import"), std::string::npos);
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

TEST(Page, HostileNamesStayText) {
  const std::string hostile = "</script><img src=x onerror=alert(1)>\"'&";
  RunLog log;
  log.manifests.push_back(manifest(hostile));
  ReferenceRecord record = reference(hostile);
  record.source = record.checks = hostile;
  log.references.push_back(record);
  add_cells(log, hostile, {hostile, hostile}, 3);
  add_failure(log, {hostile, hostile, "failed", 9}, hostile);
  log.structures = {structure(hostile, hostile, hostile, 1, 1), structure(hostile, "b", "-", 2, 2)};
  const std::string page = page_of(log);
  EXPECT_EQ(page.find("<img src=x"), std::string::npos);
  EXPECT_EQ(occurrences(page, "</script>"), occurrences(page, "<script"));
}

TEST(Page, HostileNamesOfImagesStayText) {
  PageContent content;
  content.images.emplace_back().images.push_back({"</script>\"\\\n", "<!--"});
  const RunLog log = small_log();
  const std::string page = report_page(arrange(log), content);
  EXPECT_EQ(occurrences(page, "</script>"), occurrences(page, "<script"));
  EXPECT_NE(page.find("\"\\u003c/script>\\\"\\\\\\n\""), std::string::npos);
}

TEST(Page, HoldsAVariantForEachMetricScaleAndAxis) {
  const std::string page = page_of(small_log());
  EXPECT_EQ(occurrences(page, "<script type=\"text/html\" data-variant=\"relmse|log|time\">"), 1u);
  EXPECT_EQ(occurrences(page, "<script type=\"text/html\" data-variant=\"bias|linear|iterations\">"), 1u);
  EXPECT_EQ(occurrences(page, "<script type=\"text/html\" data-variant=\"mse|linear\">"), 1u);  // the front
}

TEST(Page, BeyondItsBudgetLessUsefulChartsAreLeftOut) {
  const RunLog log = small_log();
  const ReportData data = arrange(log);
  PageContent content;
  content.chart_budget_bytes = 1;
  const std::string page = report_page(data, content);
  EXPECT_EQ(page.find("|linear"), std::string::npos);
  EXPECT_EQ(page.find("data-variant=\"mse"), std::string::npos);
  EXPECT_NE(page.find("data-variant=\"relmse|log|time\""), std::string::npos);
  EXPECT_NE(page.find("to keep this page small"), std::string::npos);
}

TEST(Page, OfLogsWithLittleInThemSaysWhatIsMissing) {
  EXPECT_NE(page_of({}).find("The log holds no finished cell."), std::string::npos);
  RunLog failed;
  add_failure(failed, {"room", "sah", "path", 1}, "out of memory");
  EXPECT_NE(page_of(failed).find("No cell finished"), std::string::npos);
  EXPECT_NE(page_of(failed).find("out of memory"), std::string::npos);
  RunLog unmeasured = small_log();
  for (CheckpointRecord& record : unmeasured.checkpoints) record.metrics.clear();
  EXPECT_NE(page_of(unmeasured).find("No metric was logged"), std::string::npos);
  RunLog timeless = small_log();
  for (CheckpointRecord& record : timeless.checkpoints) record.time_s = 0;
  const std::string page = page_of(timeless);
  EXPECT_NE(page.find("relmse over iterations"), std::string::npos);
  RunLog only_bias = small_log();
  for (CheckpointRecord& record : only_bias.checkpoints) record.metrics = {{"bias", -0.1}};
  EXPECT_EQ(page_of(only_bias).find("the least bias"), std::string::npos);
}

TEST(Page, PartsHaveSectionsLinksAndCaptionsThatSayWhatTheyAreOf) {
  Figure figure{.name = "f", .scene = "a set", .title = "times"};
  figure.panels.push_back({.series = {{.key = "k", .label = "k", .points = {{1, 1}, {2, 2}}}}});
  PageContent content;
  content.parts = {
      {.fact = "3 sets", .id = "sets", .heading = "Sets", .figures = {{"", {figure}}, {"Under a heading", {figure}}}},
      {.id = "nothing", .heading = "Nothing"}};
  ReportData data;
  const RunLog log;
  data.log = &log;
  data.findings = {"the run has not finished"};
  const std::string page = report_page(data, content);
  EXPECT_NE(page.find("<p class=\"facts\">3 sets</p>"), std::string::npos);
  EXPECT_NE(page.find("<a href=\"#sets\">Sets</a>"), std::string::npos);
  EXPECT_NE(page.find("<section id=\"sets\"><h2>Sets</h2>"), std::string::npos);
  EXPECT_NE(page.find("<figcaption>a set, times</figcaption>"), std::string::npos);
  EXPECT_NE(page.find("<h3>Under a heading</h3>"), std::string::npos);
  EXPECT_NE(page.find("<figcaption>times</figcaption>"), std::string::npos);
  EXPECT_EQ(page.find("#nothing"), std::string::npos);
  EXPECT_NE(page.find("<li>the run has not finished.</li>"), std::string::npos);
}

TEST(Page, ZeroErrorsBringNoNonFiniteText) {
  RunLog log = small_log();
  for (CheckpointRecord& record : log.checkpoints) record.metrics["relmse"] = record.metrics["mse"] = 0;
  const std::string page = page_of(log);
  EXPECT_EQ(page.find(">nan"), std::string::npos);
  EXPECT_EQ(page.find("-nan"), std::string::npos);
  EXPECT_EQ(page.find("data-v=\"inf"), std::string::npos);
}

Image flat(double value, ivec2 size = ivec2(8, 6)) {
  Image image(size);
  for (dvec3& pixel : image.pixels) pixel = dvec3(value);
  return image;
}

class Report : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("etendue-report-" + std::to_string(getpid()) + "-" +
                                         ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  std::string directory(const std::string& name, const RunLog& log) {
    const fs::path path = root_ / name;
    fs::create_directories(path);
    LogWriter writer((path / "runs.jsonl").string());
    std::vector<std::string> lines;
    for (const auto& record : log.manifests) lines.push_back(to_json_line(record));
    for (const auto& record : log.scenes) lines.push_back(to_json_line(record));
    for (const auto& record : log.references) lines.push_back(to_json_line(record));
    for (const auto& record : log.structures) lines.push_back(to_json_line(record));
    for (const auto& cell : log.cells) {
      for (const auto& record : log.checkpoints)
        if (record.cell == cell.cell) lines.push_back(to_json_line(record));
      lines.push_back(to_json_line(cell));
    }
    for (const auto& record : log.records) lines.push_back(record->line());
    writer.append(lines);
    return path.string();
  }
  // A finished run whose reference and images are there.
  std::string with_images(const auto& image_of) {
    RunLog log = small_log();
    const std::string a = (root_ / "a").string();
    fs::create_directories(a);
    log.references[0].file = "ref.exr";
    log.references[0].stamp = write_exr(a + "/ref.exr", flat(1));
    for (CellRecord& cell : log.cells) {
      cell.image = cell.cell.integrator + std::to_string(cell.cell.seed) + ".exr";
      cell.image_stamp = write_exr(a + "/" + cell.image, image_of(cell.cell));
    }
    LogWriter((fs::path(directory("a", log)) / "runs.jsonl").string()).append({finished_line()});
    EXPECT_TRUE(write_report({a}, out()).findings.empty());
    return a;
  }
  std::string out() const { return (root_ / "out").string(); }

  fs::path root_;
};

TEST_F(Report, WritesTablesChartsAndPage) {
  const auto paths = write_report({directory("a", small_log())}, out()).files;
  EXPECT_TRUE(fs::exists(root_ / "out/report.html"));
  for (const char* name :
       {"tables/final.md", "tables/final.csv", "tables/final.tex", "tables/phases.md", "tables/manifest.csv",
        "charts/error-time-room-relmse.svg", "charts/error-iterations-room-bias.svg", "charts/front-room-mse.svg"})
    EXPECT_TRUE(fs::exists(root_ / "out" / name)) << name;
  for (const std::string& path : paths) EXPECT_TRUE(fs::exists(path)) << path;
  for (const auto& entry : fs::recursive_directory_iterator(root_ / "out")) EXPECT_NE(entry.path().extension(), ".part");
}

TEST_F(Report, SameLogGivesTheSameBytes) {
  const std::string a = directory("a", small_log());
  write_report({a}, out());
  const std::string first = file_text(root_ / "out/report.html");
  write_report({a}, out());
  EXPECT_EQ(file_text(root_ / "out/report.html"), first);
}

TEST_F(Report, RemovesOnlyWhatAnEarlierReportWrote) {
  RunLog two = small_log();
  add_cells(two, "builtin:hall", {}, 1);
  write_report({directory("two", two)}, out());
  EXPECT_TRUE(fs::exists(root_ / "out/charts/error-time-hall-relmse.svg"));
  std::ofstream(root_ / "out/charts/mine.svg") << "mine";
  std::ofstream(root_ / "outside.txt") << "outside";
  write_report({directory("one", small_log())}, out(), {{"csv"}});
  EXPECT_FALSE(fs::exists(root_ / "out/charts/error-time-hall-relmse.svg"));
  EXPECT_FALSE(fs::exists(root_ / "out/tables/final.md"));
  EXPECT_TRUE(fs::exists(root_ / "out/tables/final.csv"));
  EXPECT_TRUE(fs::exists(root_ / "out/charts/mine.svg"));
  // A list that is not as it was written names nothing that may be removed.
  std::ofstream(root_ / "out/report.files", std::ios::app)
      << "0123456789abcdef 7 ../outside.txt\n0123456789abcdef 7 " << (root_ / "outside.txt").string() << "\n";
  const auto report = write_report({directory("one", small_log())}, out(), {{"md"}});
  ASSERT_EQ(report.notes.size(), 1u);
  EXPECT_NE(report.notes[0].find("report.files was changed"), std::string::npos) << report.notes[0];
  EXPECT_TRUE(fs::exists(root_ / "out/tables/final.csv"));
  EXPECT_TRUE(fs::exists(root_ / "outside.txt"));
}

TEST_F(Report, CellsOfSeveralDirectoriesAreTold) {
  const std::string a = directory("a", small_log()), b = directory("b", small_log());
  const auto report = write_report({a, b}, out(), {.check_files = false});
  ASSERT_EQ(report.notes.size(), 1u);
  EXPECT_TRUE(report.notes[0].starts_with(b + ": takes the place of ")) << report.notes[0];
  EXPECT_TRUE(write_report({a}, out(), {.check_files = false}).notes.empty());
  RunLog claims;
  ClaimRecord claim;
  claim.cell = {"room", "a measure", "claim-01", 1};
  claim.status = "done";
  claims.records.push_back(std::make_shared<ClaimRecord>(claim));
  const auto other = write_report({directory("c", claims), directory("d", claims)}, out(), {.check_files = false});
  ASSERT_EQ(other.notes.size(), 1u);
  EXPECT_NE(other.notes[0].find("takes the place of 1 cell of"), std::string::npos) << other.notes[0];
}

TEST_F(Report, ChangedFilesAreToldAndWrittenAnew) {
  const std::string a = directory("a", small_log());
  write_report({a}, out());
  const std::string table = file_text(root_ / "out/tables/final.md");
  std::ofstream(root_ / "out/tables/final.md") << table.substr(1);
  const auto report = write_report({a}, out());
  ASSERT_EQ(report.notes.size(), 1u);
  EXPECT_NE(report.notes[0].find("final.md was changed since it was written"), std::string::npos) << report.notes[0];
  EXPECT_EQ(file_text(root_ / "out/tables/final.md"), table);
  EXPECT_TRUE(write_report({a}, out()).notes.empty());
}

TEST_F(Report, SeedsAreUpToANumberOnlyWhereSomeHaveFewer) {
  RunLog log = small_log();
  write_report({directory("all", log)}, out());
  EXPECT_NE(file_text(root_ / "out/report.html").find(" · 3 seeds · "), std::string::npos);
  add_cells(log, "builtin:room", {.integrator = "bdpt"}, 2);
  write_report({directory("fewer", log)}, out());
  EXPECT_NE(file_text(root_ / "out/report.html").find(" · up to 3 seeds · "), std::string::npos);
}

TEST_F(Report, MergesShardsOfOneExperiment) {
  RunLog a, b;
  for (RunLog* log : {&a, &b}) log->references.push_back(reference("room"));
  add_cell(a, "room", {}, 1);
  add_cell(b, "room", {}, 2);
  add_cell(b, "room", {}, 3);
  write_report({directory("a", a), directory("b", b)}, out());
  EXPECT_NE(file_text(root_ / "out/tables/final.csv").find("room,path,sah,3,"), std::string::npos);
  EXPECT_EQ(file_text(root_ / "out/report.html").find("different versions"), std::string::npos);
  b.references[0].scene_hash = "changed";
  write_report({directory("a2", a), directory("b2", b)}, out());
  EXPECT_NE(file_text(root_ / "out/report.html").find("different versions"), std::string::npos);
  b.references[0] = reference("room");
  b.references[0].stamp = {7, "another image"};
  write_report({directory("a3", a), directory("b3", b)}, out());
  EXPECT_NE(file_text(root_ / "out/report.html").find("against different references"), std::string::npos);
}

TEST_F(Report, TellsOfMergedVersionsOfASceneWithoutReferences) {
  RunLog a, b;
  for (RunLog* log : {&a, &b}) log->scenes = {{.scene = "room", .hash = "1"}, {.scene = "hall", .hash = "2"}};
  a.structures = {structure("room", "sah", "bvh8", 2, 0.1)};
  b.structures = {structure("room", "lbvh", "bvh8", 1, 0.1)};
  write_report({directory("a", a), directory("b", b)}, out());
  EXPECT_EQ(file_text(root_ / "out/report.html").find("different versions"), std::string::npos);
  b.scenes[0].hash = "3";
  write_report({directory("a2", a), directory("b2", b)}, out());
  const std::string page = file_text(root_ / "out/report.html");
  EXPECT_NE(page.find("room: the merged logs measured different versions"), std::string::npos);
  EXPECT_EQ(page.find("hall: the merged logs"), std::string::npos);
}

TEST_F(Report, ShowsImagesAndErrorMaps) {
  const std::string a = with_images([](const CellName& cell) { return flat(cell.integrator == "path" ? 1.1 : 1.3); });
  const std::string page = file_text(root_ / "out/report.html");
  EXPECT_EQ(occurrences(page, " data-image=\""), 3u);  // the reference and one for each integrator
  EXPECT_EQ(occurrences(page, "\"pixels\":{\"data\":\"e"), 3u);
  EXPECT_EQ(occurrences(page, "\"exr\":\"../a/path1.exr\""), 1u);
  EXPECT_NE(page.find("seed 1, 128 iterations"), std::string::npos);
}

TEST_F(Report, CellsWhoseFilesAreNotAsLoggedCountAsFailed) {
  const std::string a = with_images([](const CellName&) { return flat(1, ivec2(4, 4)); });
  EXPECT_NE(file_text(root_ / "out/report.html").find("The image of path is missing or of another size."), std::string::npos);
  fs::remove(a + "/path1.exr");
  fs::resize_file(a + "/path2.exr", 0);
  fs::copy_file(a + "/ref.exr", a + "/path3.exr", fs::copy_options::overwrite_existing);
  const auto findings = write_report({a}, out()).findings;
  ASSERT_EQ(findings.size(), 3u);
  EXPECT_NE(findings[0].find("path1.exr is not as the log says: missing"), std::string::npos) << findings[0];
  EXPECT_NE(findings[1].find("path2.exr is not as the log says: empty"), std::string::npos) << findings[1];
  EXPECT_NE(findings[2].find("path3.exr is not as the log says: "), std::string::npos) << findings[2];
  const std::string page = file_text(root_ / "out/report.html");
  EXPECT_NE(page.find("path1.exr is not as the log says"), std::string::npos);
  EXPECT_EQ(file_text(root_ / "out/tables/final.csv").find("builtin:room,path"), std::string::npos);
  EXPECT_EQ(write_report({a}, out(), {{"csv"}, false}).findings.size(), 0u) << "the log alone";
  for (const auto& entry : fs::directory_iterator(a))
    if (entry.path().extension() == ".exr") fs::remove(entry.path());
  const auto kept_alone = write_report({a}, out());
  EXPECT_EQ(kept_alone.findings.size(), 0u) << "no image is there at all";
  ASSERT_FALSE(kept_alone.notes.empty());
  EXPECT_NE(kept_alone.notes.back().find("without its images"), std::string::npos) << kept_alone.notes.back();
  EXPECT_NE(file_text(root_ / "out/tables/final.csv").find("builtin:room,path"), std::string::npos);
}

TEST_F(Report, MissingShardsAndUnfinishedRunsAreFound) {
  const auto shard = [&](int index, bool finished) {
    const std::string path = directory("shard-" + std::to_string(index), small_log());
    LogWriter writer((fs::path(path) / "runs.jsonl").string());
    writer.append({to_json_line(PlanRecord{"hash", "", index, 3, 6, 18})});
    if (finished) writer.append({finished_line()});
    return path;
  };
  const std::vector<std::string> all{shard(0, true), shard(1, false), shard(2, true)};
  const auto two = write_report({all[0], all[2]}, out()).findings;
  ASSERT_EQ(two.size(), 1u);
  EXPECT_TRUE(two[0].starts_with("shard 1/3 is missing: 12 of 18 cells")) << two[0];
  const auto three = write_report(all, out()).findings;
  ASSERT_EQ(three.size(), 1u);
  EXPECT_NE(three[0].find("shard-1: the run has not finished"), std::string::npos) << three[0];
}

TEST_F(Report, LinesThatALogHasLostAreFound) {
  const RunLog log = small_log();
  const std::string whole = directory("whole", log);
  LogWriter((fs::path(whole) / "runs.jsonl").string())
      .append({to_json_line(PlanRecord{"hash", "", 0, 1, log.cells.size() + 2, log.cells.size() + 2}), finished_line()});
  const auto findings = write_report({whole}, out()).findings;
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_NE(findings[0].find("lines of its log are missing"), std::string::npos) << findings[0];
  // A run with a filter that ended where the whole one was stopped.
  const std::string filtered = directory("filtered", log);
  const std::uint64_t cells = log.cells.size();
  LogWriter((fs::path(filtered) / "runs.jsonl").string())
      .append({to_json_line(PlanRecord{"hash", "", 0, 1, cells + 9, cells + 9}),
               to_json_line(PlanRecord{"hash", "sppm", 0, 1, 1, 1}), finished_line()});
  const auto stopped = write_report({filtered}, out()).findings;
  ASSERT_EQ(stopped.size(), 1u);
  EXPECT_NE(stopped[0].find(fmt::format("{} of {} cells are there", cells, cells + 9)), std::string::npos) << stopped[0];
}

TEST_F(Report, ImagesBeyondTheBudgetLieBesideThePage) {
  RunLog log = small_log();
  log.references[0].file = "ref.exr";
  for (CellRecord& cell : log.cells) cell.image = "image.exr";
  const std::string a = directory("a", log);
  write_exr(a + "/ref.exr", flat(1, ivec2(300, 200)));
  write_exr(a + "/image.exr", flat(2, ivec2(300, 200)));
  RunLog resolved = read_log(a + "/runs.jsonl");
  for (CellRecord& cell : resolved.cells) cell.image = a + "/" + cell.image;
  resolved.references[0].file = a + "/ref.exr";
  const ReportData data = arrange(resolved);
  std::map<std::string, std::string> files;
  ImagePlace place{.directory = a,
                   .write_beside = [&](const std::string& name, const std::string& text) { files[name] = text; }};
  const auto within = page_images(data, place);
  EXPECT_TRUE(files.empty());
  EXPECT_EQ(within.at(0).size, ivec2(300, 200));
  EXPECT_EQ(within.at(0).images.at(1).exr, "image.exr");
  place.budget_bytes = within.at(0).images.at(0).pixels.in_page.size();
  const auto beside = page_images(data, place);
  EXPECT_FALSE(beside.at(0).images.at(0).pixels.in_page.empty());
  const PageImage& image = beside.at(0).images.at(1);
  EXPECT_EQ(image.pixels.in_page, "");
  ASSERT_TRUE(files.contains(image.pixels.file)) << image.pixels.file;
  EXPECT_EQ(files[image.pixels.file],
            "pixelData(\"" + image.pixels.file + "\", \"" + within.at(0).images.at(1).pixels.in_page + "\")\n");
}

TEST_F(Report, DifferencesThatHalfFloatsWouldLoseAreKept) {
  RunLog log = small_log();
  log.references[0].file = "ref.exr";
  for (CellRecord& cell : log.cells) cell.image = cell.cell.integrator == "path" ? "near.exr" : "far.exr";
  const std::string a = directory("a", log);
  write_exr(a + "/ref.exr", flat(1));
  write_exr(a + "/near.exr", flat(1 + 1e-5));
  write_exr(a + "/far.exr", flat(1.5));
  RunLog resolved = read_log(a + "/runs.jsonl");
  for (CellRecord& cell : resolved.cells) cell.image = a + "/" + cell.image;
  resolved.references[0].file = a + "/ref.exr";
  const auto images = page_images(arrange(resolved), {}).at(0).images;
  for (const PageImage& image : images) EXPECT_EQ(!image.difference.in_page.empty(), image.label == "path") << image.label;
}

TEST_F(Report, ImagesOfCheckpointsAreFrames) {
  RunLog log = small_log();
  const std::string a = directory("a", log);
  write_exr(a + "/image.exr", flat(2));
  write_exr(a + "/strip.exr", flat(2, ivec2(8, 6 * 8)));  // of eight checkpoints
  write_exr(a + "/torn.exr", flat(2, ivec2(8, 6 * 7)));
  for (CellRecord& cell : log.cells) {
    cell.image = a + "/image.exr";
    cell.strip = a + (cell.cell.integrator == "path" ? "/strip.exr" : "/torn.exr");
  }
  const std::vector<SceneImages> scenes = page_images(arrange(log), {});
  for (const PageImage& image : scenes.at(0).images) {
    ASSERT_EQ(image.frames.size(), image.label == "path" ? 8u : 0u) << image.label;
    for (const PageFrame& frame : image.frames) EXPECT_EQ(frame.pixels.in_page, image.pixels.in_page);
  }
}

TEST(HalfImage, RoundsToElevenBitsAndKeepsWhatIsBright) {
  EXPECT_EQ(rounded_to_half(1, 1), 1);
  EXPECT_EQ(rounded_to_half(3, 0.25), 3);
  for (const double value : {0.001, 0.3, 7.7, 12345.0}) EXPECT_NEAR(rounded_to_half(value, 1), value, value / 2048);
  EXPECT_EQ(rounded_to_half(1e9, 1), 65504);
  EXPECT_EQ(rounded_to_half(1e9, 1 << 20), std::exp2(20) * rounded_to_half(1e9 / (1 << 20), 1));
}

TEST_F(Report, WhatIsNoExperimentIsAnError) {
  EXPECT_THROW(write_report({(root_ / "nowhere").string()}, out()), Error);
  EXPECT_THROW(write_report({directory("a", small_log())}, out(), {{"xlsx"}}), Error);
}

TEST_F(Report, NamesTheCommitsThatRan) {
  const std::string a = directory("a", small_log());
  LogWriter((fs::path(a) / "runs.jsonl").string()).append({to_json_line([] {
    ManifestRecord changed = manifest();
    changed.id = "n";
    changed.commit = "def-dirty";
    return changed;
  }())});
  write_report({a}, out());
  const std::string page = file_text(root_ / "out/report.html");
  EXPECT_NE(page.find("git checkout abc\n"), std::string::npos);
  EXPECT_NE(page.find("git checkout def  # and changes"), std::string::npos);
}

TEST_F(Report, NamesTheExperimentThatTheLogHolds) {
  RunLog log = small_log();
  log.manifests.front().file = "mine.toml";
  log.manifests.front().options = "--quick -o 'title=a b'";
  log.manifests.front().experiment = "seeds = 3 # <all>\n";
  write_report({directory("a", log)}, out());
  const std::string page = file_text(root_ / "out/report.html");
  EXPECT_NE(page.find("./etendue run mine.toml --quick -o &#39;title=a b&#39; --threads 2"), std::string::npos);
  EXPECT_NE(page.find("seeds = 3 # &lt;all&gt;"), std::string::npos);
}

TEST_F(Report, CommandsCanBeTyped) {
  RunLog log = small_log();
  log.manifests.front().file = "my file.toml";
  ManifestRecord elsewhere = manifest();
  elsewhere.id = "n";
  elsewhere.experiment = "seeds = 4\n";
  log.manifests.push_back(elsewhere);
  write_report({directory("a", log)}, out());
  const std::string page = file_text(root_ / "out/report.html");
  EXPECT_NE(page.find("./etendue run &#39;my file.toml&#39; --threads 2"), std::string::npos);
  EXPECT_NE(page.find("./etendue run EXPERIMENT.toml --threads 2  # its text is below"), std::string::npos);
  EXPECT_NE(page.find("<summary>EXPERIMENT.toml</summary>"), std::string::npos);
}

TEST(RunPlan, FilesAreNamedAsTypedFromHere) {
  const auto named = [](const fs::path& path) {
    RunPlan plan;
    plan.config.path = path.string();
    return plan_manifest(plan, 1).file;
  };
  EXPECT_EQ(named("../a.toml"), "../a.toml");
  EXPECT_EQ(named(fs::current_path() / "in/a.toml"), "in/a.toml");
  EXPECT_EQ(named("/nowhere/a.toml"), "");
}

TEST(Viridis, RunsFromDarkToBright) {
  EXPECT_EQ(viridis_stops().front(), "#440154");
  EXPECT_EQ(viridis_stops().back(), "#fde725");
  EXPECT_EQ(colour_among(std::array{0x440154, 0xfde725}, -3), "#440154");
}

}  // namespace
}  // namespace etendue
