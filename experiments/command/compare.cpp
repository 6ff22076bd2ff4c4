// `etendue compare` and `etendue report`: from files alone, with no scene and no rendering.
#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/log/json_line.h"
#include "experiments/report/report.h"
#include "framework/image/metrics.h"
#include "framework/io/image/exr.h"
#include "framework/io/image/image_file.h"
#include "framework/io/whole_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <filesystem>

namespace etendue {

namespace {

// Reads any image file as linear RGB.
Image read_any(const std::string& path) {
  if (path.ends_with(".exr")) return read_exr(path);
  const RgbImage read = read_image(path);
  Image image(read.size);
  std::copy(read.texels.begin(), read.texels.end(), image.pixels.begin());
  return image;
}

// By luminance: red where the image is brighter than the reference, blue where it is darker, full at a factor of two; white
// where they are alike, grey where a value is not finite.
void write_difference(const std::string& path, const Image& image, const Image& reference) {
  std::vector<std::uint8_t> rgb;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    constexpr double floor = 1e-3;  // below it all is dark
    const double ratio = (luminance(Rgb(image.pixels[i])) + floor) / (luminance(Rgb(reference.pixels[i])) + floor);
    const double steps = ratio > 0 ? std::clamp(std::log2(ratio), -1.0, 1.0) : -1;
    const auto fading = static_cast<std::uint8_t>(std::lround(255 * (1 - std::abs(steps))));
    if (!std::isfinite(ratio))
      rgb.insert(rgb.end(), {128, 128, 128});
    else
      rgb.insert(rgb.end(), {steps < 0 ? fading : std::uint8_t{255}, fading, steps > 0 ? fading : std::uint8_t{255}});
  }
  const std::vector<std::uint8_t> png = encode_png(rgb.data(), image.size);
  write_whole_file(path, std::string(png.begin(), png.end()));
}

}  // namespace

int compare_command(const CompareCommand& command) {
  if (!command.difference.empty() && !command.difference.ends_with(".png"))
    throw Error(Location{"--difference"}, fmt::format("'{}'; expected a file that ends in .png", command.difference));
  const Image image = read_any(command.image);
  const Image reference = read_any(command.reference);
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
  if (command.csv) {
    fmt::print("{}", curves_of(command.directories));
    return 0;
  }
  // Merged results belong to none of the directories they come from.
  const std::string merged = (std::filesystem::path("out") / "merged").string();
  const std::string own = command.directories.size() > 1 ? merged : command.directories.front();
  const std::string out = command.out.empty() ? own : command.out;
  ReportOptions options;
  options.check_files = !command.logs_only;
  const Report report = write_report(command.directories, out, options);
  for (const std::string& file : report.files) fmt::print("{}\n", file);
  Console console;
  for (const std::string& note : report.notes) console.warning(note);
  for (const std::string& finding : report.findings) console.warning(finding);
  return report.findings.empty() ? 0 : 1;
}

}  // namespace etendue
