// `etendue compare` and `etendue report`: from files alone, with no scene and no rendering.
#include "experiments/command/commands.h"
#include "experiments/command/console.h"
#include "experiments/log/json_line.h"
#include "experiments/report/report.h"
#include "framework/image/metrics.h"
#include "framework/io/image/exr.h"

#include <fmt/format.h>
#include <filesystem>

namespace etendue {

int compare_command(const CompareCommand& command) {
  const Image image = read_exr(command.image);
  const Image reference = read_exr(command.reference);
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
  return 0;
}

int report_command(const ReportCommand& command) {
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
