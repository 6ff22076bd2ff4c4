// `etendue compare` and `etendue report`: from files alone, with no scene and no rendering.
#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/log/json_line.h"
#include "experiments/report/paper/comparison.h"
#include "experiments/report/report.h"
#include "framework/image/metrics.h"
#include "framework/io/image/exr.h"
#include "framework/io/image/image_file.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <filesystem>

namespace etendue {

namespace {

// Reads any image file as linear RGB; integers are taken for sRGB.
Image read_any(const std::string& path, Console& console) {
  if (path.ends_with(".exr")) return read_exr(path);
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

}  // namespace

int compare_command(const CompareCommand& command) {
  if (!command.difference.empty() && !command.difference.ends_with(".png"))
    throw Error(Location{"--difference"}, fmt::format("'{}'; expected a file that ends in .png", command.difference));
  Console console;
  const Image image = read_any(command.image, console), reference = read_any(command.reference, console);
  if (image.size != reference.size)
    throw Error(Location{command.image}, fmt::format("{} x {} pixels; expected {} x {} as in {}", image.size.x, image.size.y,
                                                     reference.size.x, reference.size.y, command.reference));
  Json json;
  for (const Metric& metric : metrics()) {
    const double value = metric.compute(image, reference);
    json[std::string(metric.name)] = value;
    if (!command.json) fmt::print("{:<15} {:.6g}\n", metric.name, value);
  }
  if (command.json) fmt::print("{}\n", dump(json, 2));
  if (!command.difference.empty()) write_difference(command.difference, image, reference);
  return 0;
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
