// The commands behind the command line: each takes what was typed and returns the process's exit status (0 done; 1 a cell
// failed or a gate tripped). Bad input is thrown as Error and becomes 2 in main.
#pragma once

#include "experiments/report/paper/comparison.h"
#include "experiments/run/run.h"
#include "framework/core/isa.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace etendue {

// What is not given on the command line keeps its value here, or is empty.

struct RunCommand {
  RunOptions options;
  bool dry_run = false;
};
int run_command(const RunCommand& command);
// The experiments that can be named alone ("first-light"), with their files: in experiments/ of the working directory, of the
// source tree beside the program's build directory, or of an installed program's share/etendue; the first of a name counts.
std::map<std::string, std::string> experiment_files();
// The failure map, experiments/stress.toml: `run` on it, wherever it is called from.
int stress_command(RunCommand command);

struct RenderCommand {
  std::string scene, from;  // of the two at least one; `from`: an image to repeat
  std::string integrator;   // empty: that of the cache to load, else path
  std::string accel;        // empty: default_accel(), as the integrator has it
  std::optional<std::uint64_t> spp, seed;
  std::optional<double> time_s, error;
  std::optional<int> threads;
  std::optional<ivec2> resolution;
  std::vector<double> crop;  // x0, x1, y0, y1; empty: what the scene says
  std::string camera;        // as of set_camera (view.h); empty: the scene's
  std::vector<std::string> params, aovs;
  std::string output, save_cache, load_cache;  // paths
  std::string preview;                         // "host:port" of tev
  bool json = false;
  SceneReading reading;
  double started = 0;  // when the process was, by now_s(): --time counts from there
};
int render_command(const RenderCommand& command);

struct AccelCommand {
  std::vector<std::string> scenes;
  std::string structures;
  StructureTiming timing;
  std::optional<int> threads;  // of the parallel builds
  bool json = false;
  SceneReading reading;
};
int accel_command(const AccelCommand& command);

struct InspectCommand {
  std::string scene;
  bool measure = false;  // time what the scene is spared
  bool pilot = false;    // what a pilot finds, and the advice that follows for a budget of
  std::optional<double> time_s, error;
  std::optional<int> threads;
  bool json = false;
  bool all = false;  // `scene` is a folder: which of the scenes below it can be read
  SceneReading reading;
};
int inspect_command(const InspectCommand& command);
int inspect_all(const InspectCommand& command);  // every scene file below a folder

struct ConvertCommand {
  std::string scene, output;  // `output`: a .pbrt file
  bool json = false;
  SceneReading reading;
};
int convert_command(const ConvertCommand& command);

struct ResultsCommand {
  std::vector<std::string> names, overrides;  // none: all experiments
  std::string shard, before;
  bool dry_run = false, derive = false;
};
int results_command(const ResultsCommand& command);

struct CompareCommand {
  std::string image, reference, difference;
  std::vector<std::string> seeds;  // images as `image`, of other seeds
  bool json = false;
};
int compare_command(const CompareCommand& command);

struct ReportCommand {
  std::vector<std::string> directories;
  std::string out;
  bool logs_only = false;
  bool csv = false;    // print the curves and write nothing
  bool latex = false;  // charts for pgfplots as well
  std::string figure;  // write this figure instead
  ComparisonChoice comparison;
};
int report_command(const ReportCommand& command);

// One list, or one name of any; "": all lists. `params`: with the parameters of each name.
int list_command(const std::string& what, bool params);
// The names in one of its lists; "": those of all, and of the lists.
std::vector<std::string> listed_names(const std::string& list);

// Typed values of the command line; they throw Error naming the option.
std::int64_t whole_option(const std::string& option, const std::string& text, std::int64_t low, std::int64_t high);
double duration_option(const std::string& option, const std::string& text);
std::uint64_t bytes_option(const std::string& option, const std::string& text);
double number_option(const std::string& option, const std::string& text, double low, double high);
std::vector<Isa> isas_option(const std::string& option, const std::string& text);  // "avx2,avx512"; of this machine
ivec2 resolution_option(const std::string& option, const std::string& text);       // "640x480"
Window window_option(const std::string& option, const std::string& text);          // "X,Y,WIDTH,HEIGHT"

// The commands and options of the program as data, from which completion and the manual page are generated.
struct OptionRow {
  std::vector<std::string> names;  // "-o", "--out"; empty: positional
  std::string value;               // what follows it ("N"); empty: a flag, or positional
  std::string help;
  std::string positional = {};  // "SCENE"
  bool required = false, many = false;
};

struct CommandRow {
  std::string name, what;
  std::vector<OptionRow> options;
};

using CommandTable = std::vector<CommandRow>;

// Print on stdout the completion of "bash" or "zsh" (else throws Error), and the manual page (roff).
int completion_command(const std::string& shell, const CommandTable& table);
int man_command(const CommandTable& table);

}  // namespace etendue
