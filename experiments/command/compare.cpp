// `etendue compare` and `etendue report`: from files alone, with no scene and no rendering.
#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/log/json_line.h"
#include "experiments/report/paper/comparison.h"
#include "experiments/report/report.h"
#include "experiments/statistics/against_reference.h"
#include "framework/image/metrics.h"
#include "framework/io/image/image_file.h"
#include "framework/io/text.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

namespace etendue {

namespace {

// Reads an image and tells what is wrong with it. `samples` grows by those of a pixel, where an image of ours says how many,
// else by one.
Image read_told(const std::string& path, Console& console, std::uint64_t& samples) {
  std::vector<std::string> warnings;
  std::map<std::string, std::string> attributes;
  Image image = read_as_image(path, warnings, &attributes);
  for (const std::string& warning : warnings) console.warning(warning);
  samples += parse_whole<std::uint64_t>(attributes["etendue_iterations"], 10).value_or(1);
  return image;
}

void write_difference(const std::string& path, const Image& image, const Image& reference) {
  write_whole_file(path, difference_of(image, reference, {{0, 0}, image.size}, image.size).png());
}

void require_size(const std::string& path, ivec2 size, const CompareCommand& command, ivec2 expected) {
  if (size != expected)
    throw Error(Location{path}, fmt::format("{} x {} pixels; expected {} x {} as in {}", size.x, size.y, expected.x, expected.y,
                                            command.reference));
}

// The reference, averaged over squares of pixels where it is so many times as wide and as high as the image.
Image at_size_of(const Image& image, Image reference, const std::string& path, Console& console) {
  const int factor = reference.size.x / image.size.x;
  if (factor < 2 || reference.size != factor * image.size) return reference;
  console.warning(fmt::format("{} is averaged over {} x {} pixels, to the size of the image", path, factor, factor));
  return averaged(reference, factor);
}

// Says where one image is there twice, as by --seeds s*.exr: what is counted twice hides noise.
void warn_of_twins(const std::vector<std::string>& paths, const std::vector<Image>& images, Console& console) {
  for (std::size_t i = 1; i < images.size(); ++i) {
    const auto twin = std::ranges::find_if(images, [&](const Image& other) { return other.pixels == images[i].pixels; });
    const auto first = static_cast<std::size_t>(twin - images.begin());
    if (first < i)
      console.warning(
          fmt::format("{} has the pixels of {}: expected images of different seeds, or the tests count on less noise "
                      "than there is",
                      paths[i], paths[first]));
  }
}

// Figures of several seeds, by name.
std::vector<std::pair<std::string, double>> figures_of(const AgainstReference& found) {
  return {{"mean_ratio", found.ratio},
          {"mean_ratio_error", found.ratio_error},
          {"mean_t", found.mean_t},
          {"mean_limit_of_t", found.mean_limit},
          {"mean_allowed", found.mean_allowed},
          {"red_ratio", found.channel_ratio.x},
          {"green_ratio", found.channel_ratio.y},
          {"blue_ratio", found.channel_ratio.z},
          {"worst_block_ratio", found.worst.ratio},
          {"worst_block_error", found.worst.error},
          {"worst_block_column", found.worst.at.x},
          {"worst_block_row", found.worst.at.y},
          {"blocks_tested", static_cast<double>(found.blocks)},
          {"blocks_failed", static_cast<double>(found.blocks_failed)},
          {"block_largest_t", found.largest_block_t},
          {"block_limit_of_t", found.block_limit},
          {"relmse_of_bias", found.relmse_of_bias},
          {"relmse_of_noise", found.relmse_of_noise},
          {"pixels_tested", static_cast<double>(found.tests)},
          {"pixels_failed", static_cast<double>(found.failed)},
          {"largest_t", found.largest_t},
          {"limit_of_t", found.limit},
          {"largest_t_column", found.largest_at.x},
          {"largest_t_row", found.largest_at.y}};
}

// Says in words what the exit status means.
std::string verdict_of(const AgainstReference& found) {
  std::vector<std::string> failures;
  if (!found.mean_agrees()) failures.push_back("the mean");
  if (found.blocks_failed > 0) failures.push_back(fmt::format("{} of {} blocks", found.blocks_failed, found.blocks));
  if (found.failed > 0) failures.push_back(fmt::format("{} of {} pixels' channels", found.failed, found.tests));
  const double least = found.mean_limit * found.ratio_error + found.mean_allowed;
  if (failures.empty())
    return std::isfinite(least) ? fmt::format("agrees: a mean ratio off by {:.2g} or more would have differed", least)
                                : "agrees";
  return fmt::format("differs: {}", fmt::join(failures, ", "));
}

}  // namespace

int compare_command(const CompareCommand& command) {
  if (!command.difference.empty() && !command.difference.ends_with(".png"))
    throw Error(Location{"--difference"}, fmt::format("'{}'; expected a file that ends in .png", command.difference));
  Console console;
  std::uint64_t samples = 0, of_reference = 0;
  Image reference = read_told(command.reference, console, of_reference);
  std::vector<std::string> paths{command.image};
  paths.insert(paths.end(), command.seeds.begin(), command.seeds.end());
  std::vector<Image> images;  // all of them are read before anything is told
  for (const std::string& path : paths) {
    images.push_back(read_told(path, console, samples));
    if (images.size() == 1) reference = at_size_of(images[0], std::move(reference), command.reference, console);
    require_size(path, images.back().size, command, reference.size);
  }
  warn_of_twins(paths, images, console);
  if (const std::string_view how = turned_against(images.front(), reference); !how.empty())
    console.warning(fmt::format("{} resembles {} {}", command.image, command.reference, how));
  Json json;
  const auto tell = [&](std::string_view name, double value, int width) {
    json[std::string(name)] = value;
    if (!command.json) fmt::print("{:<{}} {:.6g}\n", name, width, value);
  };
  for (const Metric& metric : metrics()) tell(metric.name, metric.compute(images.front(), reference), 15);
  bool agrees = true;
  if (!command.seeds.empty()) {
    const AgainstReference found = hold_against(images, reference, samples);
    agrees = found.agrees();
    for (const auto& [name, value] : figures_of(found)) tell(name, value, 18);
    json["verdict"] = verdict_of(found);
    if (!command.json) fmt::print("{:<18} {}\n", "verdict", verdict_of(found));
  }
  if (command.json) fmt::print("{}\n", dump(json, 2));
  if (!command.difference.empty()) write_difference(command.difference, images.front(), reference);
  return agrees ? 0 : 1;
}

int report_command(const ReportCommand& command) {
  if (command.figure.empty() &&
      !(command.comparison.scene.empty() && command.comparison.methods.empty() && command.comparison.windows.empty()))
    throw Error(Location{"report"}, "--scene, --method and --crop are of a figure; expected --figure FILE.png");
  if (!command.figure.empty() && !command.figure.ends_with(".png"))
    throw Error(Location{"--figure"}, fmt::format("'{}'; expected a file that ends in .png", command.figure));
  if (command.csv) {
    fmt::print("{}", curves_of(command.directories));
    return 0;
  }
  Console console;
  if (!command.figure.empty()) {
    const Comparison written = write_comparison(command.directories, command.figure, command.comparison);
    for (const std::string& file : written.files) fmt::print("{}\n", file);
    for (const std::string& note : written.notes) console.warning(note);
    return written.notes.empty() ? 0 : 1;
  }
  // Merged results belong to none of the directories they come from.
  const std::string merged = (std::filesystem::path("out") / "merged").string();
  const std::string own = command.directories.size() > 1 ? merged : command.directories.front();
  const std::string out = command.out.empty() ? own : command.out;
  ReportOptions options;
  options.check_files = !command.logs_only;
  options.latex = command.latex;
  const Report report = write_report(command.directories, out, options);
  for (const std::string& file : report.files) fmt::print("{}\n", file);
  for (const std::string& note : report.notes) console.warning(note);
  for (const std::string& finding : report.findings) console.warning(finding);
  return report.findings.empty() ? 0 : 1;
}

}  // namespace etendue
