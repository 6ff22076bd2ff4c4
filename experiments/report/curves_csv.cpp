#include "experiments/config/method.h"
#include "experiments/report/report_text.h"
#include "experiments/report/tables.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>

namespace etendue {
namespace {

using Texts = std::map<std::string, std::string>;

Texts texts_of(const std::string& label, const Parameters& logged) {
  Texts texts{{"name", label.substr(0, label.find(' '))}};
  for (const auto& [name, value] : logged) texts[name] = to_text(ParamValue{value, {}});
  return texts;
}

// Columns of the names and parameters of structures or integrators, "name" first.
class MethodColumns {
 public:
  // `logged`: of a cell, the parameters of what `named` says of it.
  MethodColumns(const RunLog& log, const std::vector<std::string>& labels, std::string CellName::*named,
                Parameters CellRecord::*logged) {
    for (const CellRecord& cell : log.cells)
      texts_.insert_or_assign(cell.cell.*named, texts_of(cell.cell.*named, cell.*logged));
    for (const std::string& label : labels)
      for (const auto& [key, value] : texts_.try_emplace(label, texts_of(label, {})).first->second) index_in(keys_, key);
  }

  std::string heading(const std::string& prefix) const {
    std::string text;
    for (const std::string& key : keys_) text += "," + prefix + "." + key;
    return text;
  }
  std::string cells(const std::string& label) {
    std::string text;
    for (const std::string& key : keys_) text += "," + escape_csv(texts_[label][key]);
    return text;
  }

 private:
  std::map<std::string, Texts> texts_;  // by label
  std::vector<std::string> keys_{"name"};
};

std::string experiment_name(const ManifestRecord& manifest) {
  return manifest.file.empty() ? manifest.title : std::filesystem::path(manifest.file).stem().string();
}

}  // namespace

std::string curves_csv(const ReportData& data) {
  MethodColumns accels(*data.log, data.accels, &CellName::accel, &CellRecord::accel_parameters);
  MethodColumns integrators(*data.log, data.integrators, &CellName::integrator, &CellRecord::parameters);
  std::map<std::string, std::string> experiments;  // by manifest
  for (const ManifestRecord& manifest : data.log->manifests) experiments[manifest.id] = experiment_name(manifest);
  std::string text = "experiment,scene,accel,integrator,seed,iterations,time_s,region,metric,value" + accels.heading("accel") +
                     integrators.heading("integrator") + '\n';
  const auto add = [&](const CheckpointRecord& checkpoint) {
    const CellName& cell = checkpoint.cell;
    const std::string before =
        fmt::format("{},{},{},{},{},{},{}", escape_csv(experiments[checkpoint.manifest]), escape_csv(cell.scene),
                    escape_csv(cell.accel), escape_csv(cell.integrator), cell.seed, checkpoint.iterations, checkpoint.time_s);
    const std::string after = accels.cells(cell.accel) + integrators.cells(cell.integrator);
    auto by_region = checkpoint.regions;
    by_region[""] = checkpoint.metrics;  // first
    for (const auto& [region, metrics] : by_region)
      for (const auto& [metric, value] : metrics)
        text += fmt::format("{},{},{},{}{}\n", before, escape_csv(region), metric, value, after);
  };
  for (const Configuration* configuration : data.finished())
    for (const Replicate& replicate : configuration->replicates)
      for (const CheckpointRecord* checkpoint : replicate.checkpoints) add(*checkpoint);
  return text;
}

}  // namespace etendue
