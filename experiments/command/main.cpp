// The `etendue` program: its command line.
//
//   0 done   1 a cell failed, a gate tripped or the machine did   2 bad usage, config or scene   130 interrupted
#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/log/log.h"
#include "experiments/report/report_text.h"
#include "framework/core/memory.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <functional>

namespace etendue {

namespace {

// Help whose descriptions are wrapped beside their options, within the terminal.
class WrappedHelp : public CLI::Formatter {
 public:
  WrappedHelp() { column_width(36); }
  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped_beside(CLI::Formatter::make_option_desc(option));
  }
  std::string make_subcommand(const CLI::App* command) const override {
    std::stringstream out;
    CLI::detail::format_help(out, command->get_name(), wrapped_beside(command->get_description()), get_column_width());
    return out.str();
  }
  std::string make_description(const CLI::App* command) const override {
    return wrapped(CLI::Formatter::make_description(command), width());
  }

 private:
  static std::size_t width() { return std::clamp<std::size_t>(Console::width(), 72, 120); }
  std::string wrapped_beside(const std::string& text) const {
    return joined(broken_lines(text, width() - get_column_width()), "\n");
  }
};

class CommandLine {
 public:
  explicit CommandLine(double started) {
    render_.started = started;
    app_.set_version_flag("--version", version_text());
    app_.allow_extras();
    app_.require_subcommand(0, 1);  // what follows a command is its own, also where it is spelt as another: `results stress`
    app_.formatter(std::make_shared<WrappedHelp>());
    add_run();
    add_render();
    add_accel();
    add_small_commands();
  }

  int run(int argc, char** argv) {
    std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    if (!words.empty() && words.front() == "help") {  // `help render` is `render --help`
      words.erase(words.begin());
      if (!words.empty()) require_name({}, "command", words.front(), command_names());
      words.emplace_back("--help");
    }
    std::ranges::reverse(words);  // as the parser takes them
    try {
      app_.parse(words);
    } catch (const CLI::ParseError& e) {
      if (e.get_exit_code() == 0) return app_.exit(e);  // --help, --version
      const auto typed = app_.get_subcommands();        // as far as it came
      throw Error(fmt::format("{}; see `etendue {}--help`", e.what(), typed.empty() ? "" : typed.front()->get_name() + " "));
    }
    refuse_unknown();
    if (!chosen_) {
      std::fputs(app_.help().c_str(), stderr);
      return 2;
    }
    if (!isas_.empty()) choose_isa(isas_.front());
    set_memory_limit(memory_);
    return chosen_();
  }

 private:
  CLI::App* add(const char* name, const char* what, std::function<int()> action) {
    CLI::App* command = app_.add_subcommand(name, what);
    command->allow_extras();
    command->callback([this, action = std::move(action)] { chosen_ = action; });
    return command;
  }

  // Names what stands without an option.
  static void positional(CLI::App* command, const char* name, auto& value, const char* help, bool required = true) {
    command->add_option(name, value, help)->required(required)->type_name("");
  }
  // One value each time it is given, so that what follows is not swallowed.
  static void repeated(CLI::App* command, const char* name, std::vector<std::string>& values, const char* type,
                       const char* help) {
    command->add_option(name, values, help)->type_name(type)->allow_extra_args(false);
  }
  static void text(CLI::App* command, const char* name, std::string& value, const char* type, const char* help) {
    command->add_option(name, value, help)->type_name(type)->check([](const std::string& typed) {
      return typed.empty() ? std::string("nothing stands there; expected a value")
                           : std::string();  // of an empty variable, say
    });
  }

  // One that `parse(name, text)` makes of what is typed.
  template <class Value, class Parse>
  static void parsed(CLI::App* command, const char* name, Value& value, const Parse& parse, const char* type,
                     const char* help) {
    const auto read = [&value, name, parse](const std::string& typed) { value = static_cast<Value>(parse(name, typed)); };
    command->add_option_function<std::string>(name, read, help)->type_name(type);
  }
  template <class Value>
  static void whole(CLI::App* command, const char* name, Value& value, std::int64_t low, std::int64_t high, const char* type,
                    const char* help) {
    const auto parse = [=](const char* option, const std::string& typed) { return whole_option(option, typed, low, high); };
    parsed(command, name, value, parse, type, help);
  }
  static void threads(CLI::App* command, std::optional<int>& value, const char* help) {
    whole(command, "--threads", value, 1, 4096, "N", help);
  }

  static double relmse_option(const char* option, const std::string& typed) { return number_option(option, typed, 1e-12, 1e6); }

  static void reading(CLI::App* command, SceneReading& value) {
    command->add_flag("--confined", value.confined,
                      "a file that a scene names outside its own folder is an error, not a warning");
    command->add_flag("--approximate", value.approximate,
                      "what a scene file holds and cannot be represented is approximated, with a warning each, not an error");
    text(command, "--pixel-filter", value.pixel_filter, "NAME",
         "box, triangle, gaussian, mitchell or sinc in the place of the scene's; a box keeps pixels apart");
  }

  void memory(CLI::App* command) {
    parsed(command, "--memory", memory_, bytes_option, "2GiB",
           "the whole program takes no more: what would is refused before it is built, what grows beyond it fails");
  }

  void isa(CLI::App* command) {
    const auto one = [](const char* option, const std::string& typed) {
      const std::vector<Isa> isas = isas_option(option, typed);
      if (isas.size() > 1) throw Error(Location{option}, fmt::format("'{}' names several; expected one", typed));
      return isas;
    };
    parsed(command, "--isa", isas_, one, "NAME",
           "sse, avx2 or avx512: no wider instructions, by Embree neither; default: the machine's widest");
  }

  void add_run() {
    CLI::App* c =
        add("run", "run an experiment: its cells, then tables, charts and a page", [this] { return run_command(run_); });
    positional(c, "EXPERIMENT", run_.options.experiment, "a .toml file, or the name of one in experiments/");
    add_run_options(c);
    add_run_options(add("stress", "the failure map: from where on each method fails along each hazard, with intervals",
                        [this] { return stress_command(run_); }));
  }

  void add_run_options(CLI::App* c) {
    repeated(c, "-o", run_.options.overrides, "KEY=VALUE",
             "put a value in the place of the file's (budget.time=5s), repeatable");
    text(c, "--out", run_.options.out, "DIR", "where results go; default out/NAME");
    c->add_flag("--fresh", run_.options.fresh, "delete what an earlier run left there");
    threads(c, run_.options.threads, "default: the experiment's, else all of the machine's");
    isa(c);
    memory(c);
    c->add_flag("--quick", run_.options.quick,
                "a small version, into out/NAME-quick: what the file's [quick] table says, else what its kind has");
    c->add_flag("--dry-run", run_.dry_run, "list the cells and run nothing");
    reading(c, run_.options.reading);
    text(c, "--filter", run_.options.filter, "REGEX",
         "only cells whose name it finds: \"scene | accel | integrator | seed=N\"");
    text(c, "--shard", run_.options.shard, "I/N",
         "only part I (0 .. N-1) of N; slurm: as the job array says (then the default)");
  }

  void add_render() {
    CLI::App* c = add("render", "render one image", [this] { return render_command(render_); });
    positional(c, "SCENE", render_.scene, "builtin:NAME, .pbrt, .xml, .obj, .ply or .smf; with --from, where it lies now",
               false);
    text(c, "--from", render_.from, "IMAGE",
         "an .exr that render or run wrote: repeat it to the same bits, from what its attributes say. Refused if the scene has "
         "changed; exit 1 if the bits differ");
    text(c, "-i,--integrator", render_.integrator, "NAME",
         "default path, with --load-cache that of the cache; see `etendue list integrators`");
    text(c, "--accel", render_.accel, "NAME",
         "default: binned-sah in the layout that suits, beside -i auto what suits the budget; see `etendue list accels`");
    whole(c, "--spp", render_.spp, 1, 4'000'000'000, "N", "iterations: samples per pixel, photon passes; default 64");
    parsed(c, "--time", render_.time_s, duration_option, "30s",
           "the image is there by then, preparation included (a longer preparation is finished first)");
    parsed(c, "--error", render_.error, relmse_option, "0.01", "until relmse is that small (within --time, default 10min)");
    whole(c, "--seed", render_.seed, 0, INT64_MAX, "N", "default 1");
    repeated(c, "-p", render_.params, "KEY=VALUE",
             "a parameter of the integrator, or accel.KEY of the structure, binned-sah where none is named; repeatable");
    text(c, "-o", render_.output, "FILE", ".exr or .png; default: named after scene and integrator, none with --json");
    c->add_option(
         "--aov", render_.aovs,
         "other images beside the output, FILE.NAME.exr: albedo, normal, position, depth, primitive, material (what the "
         "camera sees first, whatever the method); records (where a cache's lie, and how far they serve), "
         "standard-error (of each pixel, as the method itself estimates it); repeatable")
        ->type_name("NAME,...")
        ->allow_extra_args(false)
        ->delimiter(',');
    text(c, "--save-cache", render_.save_cache, "FILE",
         "the cache as the last iteration left it (irradiance-cache, radiance-cache, photon-cache, "
         "hash-cache), for other views of the scene");
    text(c, "--load-cache", render_.load_cache, "FILE",
         "begin with a saved cache: its integrator and parameters, where not given; what it does not cover is added. The same "
         "view and seed with refine=false: the same image to the bit; with refine, and hash-cache always, it goes on where it "
         "stood. Refused if the scene (but for the camera), a parameter its records depend on, or the version differs");
    text(c, "--preview", render_.preview, "HOST:PORT",
         "show the image as it grows in the viewer tev, which listens on 127.0.0.1:14158; off the clock");
    c->add_flag("--json", render_.json, "figures as JSON on stdout");
    reading(c, render_.reading);
    threads(c, render_.threads, "default: all of the machine's");
    isa(c);
    memory(c);
    parsed(c, "--resolution", render_.resolution, resolution_option, "WxH", "default: the scene's");
    c->add_option("--crop", render_.crop,
                  "only that part of the image, to the same bits; shares of it, or pixels. Default: the scene's, else all")
        ->expected(4)
        ->type_name("X0 X1 Y0 Y1");
    text(c, "--camera", render_.camera, "VIEW",
         "a camera of the file by name, or \"EYE TARGET [UP] [FOV]\" such as \"0,1,4 0,1,0 40\": metres, degrees");
  }

  void add_accel() {
    CLI::App* c =
        add("accel", "every ray structure on one scene: agreement, build time, memory, SAH and EPO cost, Mrays/s, work per ray",
            [this] { return accel_command(accel_); });
    positional(c, "SCENE", accel_.scenes, "builtin:NAME or files");
    c->add_flag("--json", accel_.json, "one JSON object a line");
    reading(c, accel_.reading);
    text(c, "--structures", accel_.structures, "A,B:key=value", "default: all that are built in");
    whole(c, "--resolution", accel_.timing.resolution, 8, 8192, "N", "about N x N rays of each kind; default 256");
    whole(c, "--repetitions", accel_.timing.repetitions, 1, 1000, "N",
          "interleaved builds and timings, of which the median counts; default 3");
    whole(c, "--check", accel_.timing.check_rays, 0, 1'000'000'000'000, "1e7",
          "rays aimed at vertices and edges, at four scales and offsets, judged in double precision; default none");
    parsed(c, "--budget", accel_.timing.budget_s, duration_option, "10s",
           "for each structure, checks aside; what does not fit is sampled or skipped, and noted");
    threads(c, accel_.threads, "of the parallel builds; default: all of the machine's");
    parsed(c, "--isa", accel_.timing.isas, isas_option, "A,B",
           "sse, avx2, avx512: with no wider instructions, Embree neither; several are compared; default: the widest");
  }

  void add_small_commands() {
    CLI::App* c = add("inspect", "what a scene holds and what it needs", [this] { return inspect_command(inspect_); });
    positional(c, "SCENE", inspect_.scene, "builtin:NAME, a file, or with --all a folder");
    c->add_flag("--measure", inspect_.measure,
                "time what the scene is spared: the same scene with each thing that it lacks, over without (some seconds)");
    c->add_flag("--pilot", inspect_.pilot,
                "trace a pilot: which method and structure `auto` chooses and why, time, memory and hazards (a second or two)");
    parsed(c, "--time", inspect_.time_s, duration_option, "4s", "with --pilot: the budget to choose for");
    parsed(c, "--error", inspect_.error, relmse_option, "0.01", "with --pilot: the relmse to choose for");
    threads(c, inspect_.threads, "with --pilot; default: the machine's");
    c->add_flag("--json", inspect_.json, "as JSON");
    c->add_flag("--all", inspect_.all,
                "SCENE is a folder: for every scene file below it, whether it loads, needs --approximate or fails, and why");
    reading(c, inspect_.reading);
    c = add("convert", "a scene of any kind as a pbrt file, with its meshes (PLY) and images beside it",
            [this] { return convert_command(convert_); });
    positional(c, "SCENE", convert_.scene, "builtin:NAME, .pbrt, .xml, .obj, .ply or .smf");
    positional(c, "OUT", convert_.output,
               "NAME.pbrt; files go to NAME-files beside it and replace those of the same names there");
    c->add_flag("--json", convert_.json, "what was written, and what pbrt cannot say, as JSON");
    reading(c, convert_.reading);
    c = add("compare", "every metric of an image against a reference", [this] { return compare_command(compare_); });
    positional(c, "IMAGE", compare_.image, ".exr, .pfm or .hdr; or .png, .jpg, .tga or .bmp, whose numbers are taken for sRGB");
    positional(c, "REFERENCE", compare_.reference, "of the same size, or a whole number of times as wide and high");
    text(c, "--difference", compare_.difference, "FILE.png",
         "where and how they differ: red is brighter than the reference, blue darker, full at a factor of two");
    c->add_option(
         "--seeds", compare_.seeds,
         "further images like IMAGE, of other seeds: bias and noise apart, tests of the mean, of blocks and of each pixel; "
         "exit 1 where one fails")
        ->type_name("IMAGE...");
    c->add_flag("--json", compare_.json, "as JSON");
    c = add("report", "tables, charts and report.html again, from logs alone; several directories are merged",
            [this] { return report_command(report_); });
    positional(c, "DIR", report_.directories, "what `etendue run` wrote");
    text(c, "--out", report_.out, "DIR", "default: the one DIR itself, of several out/merged");
    c->add_flag("--logs-only", report_.logs_only,
                "believe the logs alone: no image, reference or scene is read and held against them");
    c->add_flag("--csv", report_.csv, "print every metric of every checkpoint as CSV, from the logs alone, and write nothing");
    c->add_flag("--latex", report_.latex,
                "charts for papers as well: latex/NAME.tex, which draws with pgfplots, and its points, NAME.dat");
    text(c, "--figure", report_.figure, "FILE.png",
         "instead: images of methods and reference side by side, with enlarged windows and their differences from the "
         "reference, as PNG and as LaTeX beside it (FILE.tex)");
    text(c, "--scene", report_.comparison.scene, "NAME", "with --figure; default: the first one");
    repeated(c, "--method", report_.comparison.methods, "NAME",
             "with --figure: as the report calls it, repeatable; default: all whose images were kept");
    const auto crop = [this](const std::vector<std::string>& typed) {
      for (const std::string& one : typed) report_.comparison.windows.push_back(window_option("--crop", one));
    };
    c->add_option_function<std::vector<std::string>>(
         "--crop", crop, "with --figure: a window in pixels, repeatable; default: the two where errors are largest")
        ->type_name("X,Y,W,H")
        ->allow_extra_args(false);
    c = add("results", "the experiments behind results/ again: what moved since, then tables, charts and documents",
            [this] { return results_command(results_); });
    positional(c, "NAMES", results_.names, "of experiments/; default: all", false);
    c->add_flag("--dry-run", results_.dry_run, "list them with the time their last logs took, and run nothing");
    CLI::Option* derive = c->add_flag("--derive", results_.derive,
                                      "run nothing: write tables, charts, pages and quoted figures again from the logs");
    c->add_option("--before", results_.before, "with --derive: what moved since the logs of DIR, a copy of an older results/")
        ->type_name("DIR")
        ->needs(derive);
    repeated(c, "-o", results_.overrides, "KEY=VALUE", "put a value in the place of the file's, repeatable");
    text(c, "--shard", results_.shard, "I/N", "only part I (0 .. N-1) of N of each; what they found is left in out/results/");
    c = add("list", "every scene, method, structure and metric", [this] { return list_command(list_, list_params_); });
    positional(c, "WHAT", list_,
               "scenes, integrators, accels, metrics, points, records, motions, policies, measurements, figures, edits, "
               "decisions or experiments; or one name, such as sppm; default all",
               false);
    c->add_flag("--params,--all", list_params_, "with each parameter: default, range and unit");
    c = add("completion", "a script that completes commands, options and names in a shell: source <(etendue completion bash)",
            [this] { return completion_command(shell_, table()); });
    positional(c, "SHELL", shell_, "bash or zsh");
    add("man", "the manual page: etendue man | man -l -", [this] { return man_command(table()); });
  }

  // The commands as completion and the manual page show them.
  CommandTable table() const {
    CommandTable table;
    for (const CLI::App* command : app_.get_subcommands([](const CLI::App*) { return true; })) {
      CommandRow row{command->get_name(), command->get_description(), {}};
      for (const CLI::Option* option : command->get_options()) {
        OptionRow of{{}, option->get_expected_max() == 0 ? "" : option->get_type_name(), option->get_description()};
        for (const std::string& name : option->get_snames()) of.names.push_back("-" + name);
        for (const std::string& name : option->get_lnames()) of.names.push_back("--" + name);
        of.positional = of.names.empty() ? option->get_name() : "";
        of.required = option->get_required();
        of.many = option->get_expected_max() > 1;
        row.options.push_back(std::move(of));
      }
      table.push_back(std::move(row));
    }
    return table;
  }

  // Tells what no option took, with the nearest names.
  std::vector<std::string> command_names() const {
    return mapped(app_.get_subcommands([](const CLI::App*) { return true; }), &CLI::App::get_name);
  }

  void refuse_unknown() const {
    const CLI::App* used = nullptr;
    if (const auto parsed = app_.get_subcommands(); !parsed.empty()) used = parsed.front();
    const CLI::App& owner = used ? *used : app_;
    const auto extras = owner.remaining();
    if (extras.empty()) return;
    const std::string word = extras.front().substr(0, extras.front().find('='));
    if (!word.starts_with("-") && !used) throw Error(unknown_name("command", word, command_names()));
    const std::string where = used ? used->get_name() : "etendue";
    if (!word.starts_with("-"))
      throw Error(Location{where}, fmt::format("unexpected '{}'; see `etendue {} --help`", word, where));
    std::vector<std::string> flags;
    for (const CLI::Option* option : owner.get_options()) {
      for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
      for (const std::string& name : option->get_snames()) flags.push_back("-" + name);
    }
    throw Error(Location{where}, unknown_name("option", word, flags));
  }

  CLI::App app_{"etendue: a laboratory for photon mapping and radiance caching", "etendue"};
  RunCommand run_;
  RenderCommand render_;
  AccelCommand accel_;
  InspectCommand inspect_;
  ConvertCommand convert_;
  CompareCommand compare_;
  ReportCommand report_;
  ResultsCommand results_;
  std::string list_;
  bool list_params_ = false;
  std::string shell_;
  std::vector<Isa> isas_;
  std::uint64_t memory_ = 0;  // bytes; 0: no limit
  std::function<int()> chosen_;
};

}  // namespace

}  // namespace etendue

int main(int argc, char** argv) {
  const double started = etendue::now_s();
  etendue::keep_freed_memory();
  return etendue::guarded([&] { return etendue::CommandLine(started).run(argc, argv); });
}
