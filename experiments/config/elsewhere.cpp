#include "experiments/config/elsewhere.h"

#include "framework/core/error.h"
#include "framework/image/metrics.h"

#include <filesystem>

namespace etendue {

namespace {

ElsewhereFigure read_figure(const ConfigNode& node) {
  TableReader reader(node, "elsewhere", "tables { scene, program, method, time, error, … }");
  using Figure = ElsewhereFigure;
  Figure figure;
  for (const auto& [key, text] : {std::pair{"scene", &Figure::scene},
                                  {"program", &Figure::program},
                                  {"method", &Figure::method},
                                  {"machine", &Figure::machine},
                                  {"date", &Figure::date},
                                  {"source", &Figure::source}})
    figure.*text = reader.needed_text(key);
  figure.time_s = read_duration(reader.need("time"), "elsewhere.time");
  figure.error = read_number(reader.need("error"), "elsewhere.error", 0, 1e30);
  if (const ConfigNode* metric = reader.find("metric")) {
    figure.metric = read_text(*metric, "elsewhere.metric");
    const auto names = mapped(metrics(), [](const Metric& known) { return std::string(known.name); });
    require_name(metric->where, "metric", figure.metric, names, "elsewhere: ");
  }
  reader.finish();
  return figure;
}

}  // namespace

bool ElsewhereFigure::of_scene(const std::string& name) const {
  return name == scene || std::filesystem::path(name).stem() == scene;
}

std::vector<ElsewhereFigure> read_elsewhere(const ConfigNode& node) {
  return mapped(list_elements(node, "elsewhere", "[[elsewhere]] tables { scene, program, method, … }"),
                [](const ConfigNode* element) { return read_figure(*element); });
}

}  // namespace etendue
