// `etendue compare` and `etendue report`: from files alone, with no scene and no rendering.
#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/log/json_line.h"
#include "experiments/report/paper/comparison.h"
#include "experiments/report/report.h"
#include "experiments/statistics/against_reference.h"
#include "framework/image/metrics.h"
#include "framework/io/image/exr.h"
#include "framework/io/image/image_file.h"
#include "framework/io/text.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>
#include <map>

namespace etendue {

namespace {

// Reads any image file as linear RGB; integers are taken for sRGB. `samples`: grows by those of a pixel, where an image of ours
// says how many, else by one.
Image read_any(const std::string& path, Console& console, std::uint64_t* samples = nullptr) {
  std::map<std::string, std::string> attributes;
  if (path.ends_with(".exr")) {
    Image image = read_exr(path, &attributes);
    if (samples != nullptr) *samples += parse_whole<std::uint64_t>(attributes["etendue_iterations"], 10).value_or(1);
    return image;
  }
  if (samples != nullptr) ++*samples;
  const RgbImage read = read_image(path);
  if (read.not_finite > 0)
    console.warning(fmt::format("{}: {} of {} pixels are not finite and count as 0, the first at ({}, {})", path,
                                read.not_finite, read.texels.size(), read.first_not_finite.front().x,
                                read.first_not_finite.front().y));
  Image image(read.size);
  std::copy(read.texels.begin(), read.texels.end(), image.pixels.begin());
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

// Figures of several seeds, by name.
std::vector<std::pair<std::string, double>> figures_of(const AgainstReference& found) {
  return {{"mean_ratio", found.ratio},
          {"mean_ratio_error", found.ratio_error},
          {"worst_block_ratio", found.worst.ratio},
          {"worst_block_error", found.worst.error},
          {"worst_block_column", found.worst.at.x},
          {"worst_block_row", found.worst.at.y},
          {"relmse_of_bias", found.relmse_of_bias},
          {"relmse_of_noise", found.relmse_of_noise},
          {"pixels_tested", static_cast<double>(found.tests)},
          {"pixels_failed", static_cast<double>(found.failed)},
          {"largest_t", found.largest_t},
          {"limit_of_t", found.limit},
          {"largest_t_column", found.largest_at.x},
          {"largest_t_row", found.largest_at.y}};
}

}  // namespace

int compare_command(const CompareCommand& command) {
  if (!command.difference.empty() && !command.difference.ends_with(".png"))
    throw Error(Location{"--difference"}, fmt::format("'{}'; expected a file that ends in .png", command.difference));
  Console console;
  std::uint64_t samples = 0;
  const Image image = read_any(command.image, console, &samples), reference = read_any(command.reference, console);
  require_size(command.image, image.size, command, reference.size);
  Json json;
  for (const Metric& metric : metrics()) {
    const double value = metric.compute(image, reference);
    json[std::string(metric.name)] = value;
    if (!command.json) fmt::print("{:<15} {:.6g}\n", metric.name, value);
  }
  bool agrees = true;
  if (!command.seeds.empty()) {
    std::vector<Image> images{image};
    for (const std::string& path : command.seeds) {
      images.push_back(read_any(path, console, &samples));
      require_size(path, images.back().size, command, reference.size);
    }
    const AgainstReference found = hold_against(images, reference, samples);
    agrees = found.agrees();
    for (const auto& [name, value] : figures_of(found)) {
      json[name] = value;
      if (!command.json) fmt::print("{:<18} {:.6g}\n", name, value);
    }
  }
  if (command.json) fmt::print("{}\n", dump(json, 2));
  if (!command.difference.empty()) write_difference(command.difference, image, reference);
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
