// `etendue run` from outside: interrupted anywhere it resumes, and ends with what an uninterrupted run would have written.
#include "experiments/log/log.h"
#include "experiments/run/run.h"
#include "experiments/run/suspension.h"
#include "framework/io/image/exr.h"
#include "tests/unit/harness_process.h"
#include "tests/unit/run_results.h"
#include "tests/unit/silent_observer.h"

#include <fmt/format.h>
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <map>
#include <sstream>

namespace etendue {
namespace {

constexpr const char* small_experiment =
    "title = \"Small\"\n"
    "scenes = [\"builtin:lambert-sphere\", \"builtin:furnace\"]\n"
    "seeds = 4\n"
    "budget = { samples = 24 }\n"
    "resolution = [24, 24]\n"
    "integrators = [\"path\", { name = \"path\", mis = \"light\" }]\n"
    "[quick]\n"
    "seeds = 1\n"
    "budget = { samples = 2 }\n";

class Run : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file("small.toml", small_experiment);
  }

  RunLog log(const std::string& out = "out/small") { return read_log((directory_ / out / "runs.jsonl").string()); }
  std::string log_text(const std::string& out) { return read_text_file(directory_ / out / "runs.jsonl"); }

  // Squared bias and variance of the images in the table of results: a line for each configuration, ordered by name, since the
  // table's order is that of errors at equal time.
  // The figures have six digits here: logs keep nine, and images more.
  std::string split_columns(const std::string& out) {
    std::istringstream lines(read_text_file(directory_ / out / "tables/final.csv"));
    std::vector<std::size_t> wanted{0, 1, 2};  // scene, integrator, structure
    std::set<std::string> rows;
    for (std::string line; std::getline(lines, line);) {
      std::istringstream cells(line);
      std::vector<std::string> row;
      for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
      for (std::size_t i = 0; rows.empty() && i < row.size(); ++i)
        if (row[i].starts_with("bias_squared") || row[i] == "image_variance") wanted.push_back(i);
      std::string text;
      for (const std::size_t i : wanted) {
        const std::string cell = i < row.size() ? row[i] : "";
        char* end = nullptr;
        const double number = std::strtod(cell.c_str(), &end);
        text += cell.empty() ? "– " : *end == 0 ? fmt::format("{:.6g} ", number) : cell + " ";
      }
      rows.insert(text + '\n');
    }
    return std::accumulate(rows.begin(), rows.end(), std::string());
  }

  // Waits until the log of `out` holds so many finished cells.
  bool wait_for_cells(const std::string& out, int cells) {
    for (int i = 0; i < 6000; ++i) {
      const std::string text = log_text(out);
      int found = 0;
      for (std::size_t at = 0; (at = text.find("\"type\":\"cell\"", at)) != std::string::npos; ++at) ++found;
      if (found >= cells) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }
};

TEST_F(Run, WritesLogImagesAndReport) {
  const Outcome outcome = run({"run", "small.toml", "--quick", "--threads", "2"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const RunLog written = log("out/small-quick");
  EXPECT_EQ(written.cells.size(), 4u);
  EXPECT_EQ(written.references.size(), 2u);
  ASSERT_EQ(written.manifests.size(), 1u);
  EXPECT_EQ(written.manifests[0].flags.find("SHELL:"), std::string::npos) << "CMake's word, which no compiler takes";
  for (const CellRecord& cell : written.cells) {
    EXPECT_TRUE(std::filesystem::exists(directory_ / "out/small-quick" / cell.image));
    const Parameters set{{"mis", "light"}};
    EXPECT_EQ(cell.parameters, cell.cell.integrator == "path" ? Parameters{} : set);
  }
  EXPECT_TRUE(std::filesystem::exists(directory_ / "out/small-quick/report.html"));
  EXPECT_NE(outcome.out.find("path"), std::string::npos) << "the table is on stdout";
  EXPECT_NE(outcome.err.find("[4/4]"), std::string::npos) << "a line per cell is on stderr";
}

TEST_F(Run, KilledRunResumesToTheSameResults) {
  ASSERT_EQ(run({"run", "small.toml", "--out", "whole", "--threads", "2"}).status, 0);
  for (const int after : {1, 7, 13}) {
    const pid_t pid = start({"run", "small.toml", "--out", "killed", "--threads", "2"});
    EXPECT_TRUE(wait_for_cells("killed", after));
    kill(pid, SIGKILL);
    const Outcome killed = finish(pid);
    EXPECT_TRUE(killed.status == -SIGKILL || after == 13) << killed.err;
  }
  // A write that is cut short in the middle leaves this.
  std::ofstream(directory_ / "killed/runs.jsonl", std::ios::app) << "{\"type\":\"checkpoint\",\"scene\":\"bui";
  const Outcome outcome = run({"run", "small.toml", "--out", "killed", "--threads", "2"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(results(log("killed")), results(log("whole")));
  EXPECT_EQ(log("killed").cells.size(), 16u);
  const auto line_count = [&](const std::string& out) {
    const std::string text = log_text(out);
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(line_count("killed"), line_count("whole")) << "nothing is logged twice";
  for (const auto& entry : std::filesystem::directory_iterator(directory_ / "whole/images"))
    EXPECT_EQ(read_exr(entry.path().string()).pixels,
              read_exr((directory_ / "killed/images" / entry.path().filename()).string()).pixels);

  const std::string before = log_text("killed");
  const Outcome again = run({"run", "small.toml", "--out", "killed", "--threads", "2"});
  EXPECT_EQ(again.status, 0);
  EXPECT_NE(again.err.find("16 of 16 cells are done already"), std::string::npos) << again.err;
  EXPECT_EQ(log_text("killed"), before) << "a finished run has nothing to add";
}

TEST_F(Run, GoesOnWithTheReferenceItBeganWith) {
  const auto run_to = [&](const char* out) {
    return run({"run", "small.toml", "--quick", "--threads", "1", "-o", "reference.samples=16", "--out", out}).status;
  };
  ASSERT_EQ(run_to("whole"), 0);
  ASSERT_EQ(run_to("resumed"), 0);
  // The log looks as if the run had been killed before its last cell; meanwhile somebody made a better reference.
  const std::string text = log_text("resumed");
  const std::string cell = "\"type\":\"cell\"";
  const std::size_t last_but_one = text.rfind(cell, text.rfind(cell) - 1);
  std::ofstream(directory_ / "resumed/runs.jsonl") << text.substr(0, text.find('\n', last_but_one) + 1);
  ASSERT_EQ(log("resumed").cells.size(), 3u);
  for (const auto& entry : std::filesystem::directory_iterator(directory_ / "cache/etendue/references")) {
    if (entry.path().extension() != ".exr") continue;
    std::map<std::string, std::string> attributes;
    Image image = read_exr(entry.path().string(), &attributes);
    for (dvec3& pixel : image.pixels) pixel *= 2;
    write_exr(entry.path().string(), image, attributes);
  }
  ASSERT_EQ(run_to("resumed"), 0);
  EXPECT_EQ(results(log("resumed")), results(log("whole")));
  EXPECT_EQ(log("resumed").cells.size(), 4u);
}

TEST_F(Run, WhatARefusedReferenceLeftIsNeverMeasuredAgainst) {
  std::ofstream(directory_ / "hidden.toml") << "scenes = [\"builtin:mirror?view=mirror\"]\nintegrators = [\"path\"]\n"
                                               "resolution = [16, 16]\nbudget = { samples = 1 }\n"
                                               "reference = { samples = 16 }\n";
  for (int time = 0; time < 2; ++time) {
    EXPECT_EQ(run({"run", "hidden.toml", "--threads", "1"}).status, 1);
    const RunLog hidden = log("out/hidden");
    ASSERT_EQ(hidden.cells.size(), 1u);
    EXPECT_EQ(hidden.cells[0].status, "failed") << time;
  }
}

TEST_F(Run, InterruptEndsWith130AndResumes) {
  const pid_t pid = start({"run", "small.toml", "--threads", "1", "-o", "budget.samples=2000"});
  for (int i = 0; i < 2000 && log_text("out/small").find("\"type\":\"reference\"") == std::string::npos; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  kill(pid, SIGINT);
  const Outcome outcome = finish(pid);
  EXPECT_EQ(outcome.status, 130);
  EXPECT_NE(outcome.err.find("the same command goes on"), std::string::npos);
}

TEST_F(Run, ImagesDoNotDependOnTheThreads) {
  std::map<std::string, std::string> first;
  for (const char* threads : {"1", "2", "3"}) {
    const std::string out = std::string("threads-") + threads;
    ASSERT_EQ(run({"run", "small.toml", "--quick", "--threads", threads, "--out", out}).status, 0);
    if (first.empty()) first = results(log(out));
    EXPECT_EQ(results(log(out)), first);
  }
}

TEST_F(Run, ShardsAreAPartitionAndMergeInTheReport) {
  ASSERT_EQ(run({"run", "small.toml", "--out", "whole", "--threads", "1", "-o", "budget.samples=2"}).status, 0);
  std::vector<RunLog> shards;
  for (const char* shard : {"0/3", "1/3", "2/3"}) {
    const std::string out = std::string("shard-") + shard[0];
    ASSERT_EQ(run({"run", "small.toml", "--shard", shard, "--out", out, "--threads", "1", "-o", "budget.samples=2"}).status, 0);
    shards.push_back(log(out));
  }
  EXPECT_EQ(shards[0].cells.size() + shards[1].cells.size() + shards[2].cells.size(), 16u);
  EXPECT_EQ(results(merge_logs(shards)), results(log("whole")));
  const auto order = [](const RunLog& log) {
    std::vector<std::string> cells;
    for (const CellRecord& cell : log.cells) cells.push_back(cell.cell.key());
    return cells;
  };
  EXPECT_EQ(order(merge_logs(shards)), order(log("whole"))) << "methods keep their order, and so their colours";
  const Outcome report = run({"report", "shard-0", "shard-1", "shard-2", "--out", "merged"});
  EXPECT_EQ(report.status, 0) << report.err;
  EXPECT_TRUE(std::filesystem::exists(directory_ / "merged/report.html"));
  EXPECT_EQ(split_columns("merged"), split_columns("whole")) << "seeds lie in several shards";
}

TEST_F(Run, WhatImagesToldIsInTheLog) {
  write_file("rates.toml", std::string(small_experiment).replace(0, 15, "title = \"Rates\"") +
                               "[[predictions]]\nmethod = \"path mis=light\"\nscene = \"builtin:lambert-sphere\"\n"
                               "metric = \"variance\"\nexpect = { exponent = \"-1\" }\nsource = \"[Veach1997]\"\n");
  ASSERT_EQ(run({"run", "rates.toml", "--out", "whole"}).status, 0);
  std::filesystem::create_directory(directory_ / "log-alone");
  std::filesystem::copy_file(directory_ / "whole/runs.jsonl", directory_ / "log-alone/runs.jsonl");
  ASSERT_EQ(run({"report", "log-alone", "--logs-only"}).status, 0);
  for (const char* table :
       {"tables/final.csv", "tables/predictions.csv", "charts/rate-lambert-sphere-whole-image-variance-iterations.svg"}) {
    const std::string whole = read_text_file(directory_ / "whole" / table);
    EXPECT_FALSE(whole.empty()) << table;
    EXPECT_EQ(read_text_file(directory_ / "log-alone" / table), whole) << table;
  }
  EXPECT_EQ(split_columns("whole").find("–"), std::string::npos);
}

TEST_F(Run, OtherSettingsInTheSameDirectoryAreRefused) {
  ASSERT_EQ(run({"run", "small.toml", "--quick", "--threads", "2"}).status, 0);
  const Outcome other = run({"run", "small.toml", "--quick", "--threads", "2", "-o", "seeds=2"});
  EXPECT_EQ(other.status, 2);
  EXPECT_NE(other.err.find("--fresh"), std::string::npos) << other.err;
  EXPECT_EQ(run({"run", "small.toml", "--quick", "--threads", "1"}).status, 2) << "times of other thread counts would be mixed";
  EXPECT_EQ(run({"run", "small.toml", "--quick", "--threads", "2", "-o", "seeds=2", "--fresh"}).status, 0);
  EXPECT_EQ(log("out/small-quick").cells.size(), 8u);
}

TEST_F(Run, SecondWriterOfADirectoryIsRefused) {
  const pid_t pid = start({"run", "small.toml", "--threads", "1", "-o", "budget.samples=100000"});
  for (int i = 0; i < 2000 && log_text("out/small").find("\"type\":\"reference\"") == std::string::npos; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const Outcome second = run({"run", "small.toml", "--threads", "1", "-o", "budget.samples=100000"});
  kill(pid, SIGKILL);
  finish(pid);
  EXPECT_EQ(second.status, 2);
  EXPECT_NE(second.err.find("another run"), std::string::npos) << second.err;
}

TEST_F(Run, DryRunListsCellsAndWritesNothing) {
  const Outcome outcome = run({"run", "small.toml", "--dry-run", "--filter", "furnace.*seed=[12]$"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 4);
  EXPECT_FALSE(std::filesystem::exists(directory_ / "out"));
}

TEST_F(Run, FailedCellIsRecordedTheRestGoOnAndItIsTriedAgain) {
  RunOptions options;
  options.experiment = (directory_ / "small.toml").string();
  options.out = (directory_ / "failing").string();
  options.quick = true;
  SilentObserver observer;
  const auto failing = [](const CellTask& task) {
    if (task.integrator.params.contains("mis")) throw std::runtime_error("no \"mis\" today");
    return run_cell(task);
  };
  const RunSummary first = execute_run(plan_run(options), observer, failing);
  EXPECT_EQ(first.done, 2u);
  EXPECT_EQ(first.failed, 2u);
  for (const CellRecord& cell : log("failing").cells) {
    EXPECT_EQ(cell.status, cell.cell.integrator == "path" ? "done" : "failed");
    EXPECT_EQ(cell.error, cell.cell.integrator == "path" ? "" : "no \"mis\" today");
  }
  const RunSummary second = execute_run(plan_run(options), observer);
  EXPECT_EQ(second.skipped, 2u);
  EXPECT_EQ(second.done, 2u);
  for (const CellRecord& cell : log("failing").cells) EXPECT_EQ(cell.status, "done");
}

// Ctrl-Z or a batch system suspends them, and their clock runs on meanwhile.
TEST_F(Run, SuspendedCellsRunAgain) {
  count_suspensions();
  RunOptions options;
  options.experiment = (directory_ / "small.toml").string();
  options.out = (directory_ / "suspended").string();
  options.quick = true;
  SilentObserver observer;
  std::size_t runs = 0;
  const auto once = [&](const CellTask& task) {
    if (++runs == 1) std::raise(SIGCONT);
    return run_cell(task);
  };
  EXPECT_EQ(execute_run(plan_run(options), observer, once).done, 4u);
  EXPECT_EQ(runs, 5u);
  options.fresh = true;
  const auto always = [](const CellTask& task) {
    std::raise(SIGCONT);
    return run_cell(task);
  };
  EXPECT_EQ(execute_run(plan_run(options), observer, always).failed, 4u);
  EXPECT_TRUE(log("suspended").cells[0].error.starts_with("suspended each of the 3 times")) << log("suspended").cells[0].error;
}

// A mirror shows the caustic of a point light, which merging alone finds: there is nothing to judge a method by.
TEST_F(Run, CausticOfAPointLightFailsTheScenesCells) {
  write_file("caustic.toml",
             "scenes = [\"builtin:mirror?view=mirror\"]\nintegrators = [\"path\"]\nresolution = [16, 16]\n"
             "budget = { samples = 1 }\nreference = { samples = 16 }\n");
  const Outcome outcome = run({"run", "caustic.toml"});
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  const RunLog written = log("out/caustic");
  ASSERT_EQ(written.cells.size(), 1u);
  EXPECT_EQ(written.cells[0].status, "failed");
  EXPECT_NE(written.cells[0].error.find("only merging finds caustics"), std::string::npos) << written.cells[0].error;
}

TEST_F(Run, StructuresBeyondTheirMemoryAreToldInLogReportAndTerminal) {
  write_file("memory.toml",
             "scenes = [\"builtin:lambert-sphere\"]\n"
             "budget = { samples = 1 }\n"
             "resolution = [8, 8]\n"
             "integrators = [\"path\"]\n"
             "accels = [\"sah\", { name = \"sah\", memory = \"1KiB\" }]\n"
             "structures = { resolution = 8, repetitions = 1 }\n");
  const Outcome outcome = run({"run", "memory.toml", "--threads", "1"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::string told = "beyond its memory of 1 KiB: sah would take about ";
  const RunLog written = log("out/memory");
  ASSERT_EQ(written.cells.size(), 2u);
  ASSERT_EQ(written.structures.size(), 2u);
  EXPECT_EQ(written.cells[0].image_hash, written.cells[1].image_hash);
  for (const CellRecord& cell : written.cells)
    EXPECT_EQ(cell.fallback.starts_with(told), cell.cell.accel == "sah memory=1KiB") << cell.cell.accel << cell.fallback;
  for (const StructureRecord& structure : written.structures)
    EXPECT_EQ(structure.fallback.starts_with(told), structure.structure == "sah memory=1KiB") << structure.fallback;
  EXPECT_NE(outcome.err.find("warning: builtin:lambert-sphere: sah memory=1KiB: " + told), std::string::npos) << outcome.err;
  EXPECT_NE(read_text_file(directory_ / "out/memory/report.html").find("sah memory=1KiB: " + told), std::string::npos);
}

TEST_F(Run, MisspeltMemoryIsAnErrorAtItsPlace) {
  write_file("memory.toml",
             "scenes = [\"builtin:furnace\"]\nintegrators = [\"path\"]\nbudget = { samples = 1 }\n"
             "accels = [{ name = \"grid\", memory = \"512Mb\" }]\n");
  const Outcome outcome = run({"run", "memory.toml"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_TRUE(outcome.err.starts_with("error: memory.toml:4:")) << outcome.err;
  EXPECT_NE(outcome.err.find("grid: memory: unknown unit in '512Mb': expected a size such as \"512MiB\""), std::string::npos)
      << outcome.err;
}

TEST_F(Run, BadInputExitsWith2) {
  write_file("bad.toml", "scenes = [\"builtin:furnace\"]\nsedes = 3\n");
  const Outcome outcome = run({"run", "bad.toml"});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_TRUE(outcome.err.starts_with("error: bad.toml:2:1: ")) << outcome.err;
  EXPECT_EQ(run({"run", "missing.toml"}).status, 2);
  EXPECT_EQ(run({"run"}).status, 2);
  const Outcome named_as_another = run({"list", "report"});
  EXPECT_EQ(named_as_another.status, 2);
  EXPECT_NE(named_as_another.err.find("'report'"), std::string::npos) << named_as_another.err;
  EXPECT_EQ(run({"run", "small.toml", "--shard", "4/4"}).status, 2);
  EXPECT_EQ(run({"run", "small.toml", "--threads", "0"}).status, 2);
  EXPECT_EQ(run({"runn", "small.toml"}).status, 2);
  EXPECT_EQ(run({"run", "small.toml", "--quik"}).status, 2);
  EXPECT_FALSE(std::filesystem::exists(directory_ / "out"));
}

}  // namespace
}  // namespace etendue
