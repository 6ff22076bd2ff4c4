#include "experiments/report/curves_csv.h"

#include "experiments/config/method.h"
#include "experiments/report/report_text.h"

#include <fmt/format.h>

#include <filesystem>
#include <iterator>
#include <map>

namespace etendue {
namespace {

using Parameters = std::map<std::string, std::string>;

// "photon-map photons=200000" -> name: photon-map, photons: 200000.
Parameters parameters_of(const std::string& label) {
  Parameters parameters;
  for (const std::string& word : words_of(label)) {
    const std::size_t equals = word.find('=');
    if (parameters.empty())
      parameters["name"] = word;
    else
      parameters[word.substr(0, equals)] = equals == std::string::npos ? "" : word.substr(equals + 1);
  }
  return parameters;
}

// The columns of methods' names and parameters, "name" first.
std::vector<std::string> keys_of(const std::vector<std::string>& labels) {
  std::vector<std::string> keys{"name"};
  for (const std::string& label : labels)
    for (const auto& [key, value] : parameters_of(label)) index_in(keys, key);
  return keys;
}

std::string cells_of(const std::string& label, const std::vector<std::string>& keys) {
  Parameters parameters = parameters_of(label);
  std::string text;
  for (const std::string& key : keys) text += "," + escape_csv(parameters[key]);
  return text;
}

std::string experiment_name(const ManifestRecord& manifest) {
  return manifest.file.empty() ? manifest.title : std::filesystem::path(manifest.file).stem().string();
}

class CurvesText {
 public:
  explicit CurvesText(const ReportData& data) : accel_keys_(keys_of(data.accels)), integrator_keys_(keys_of(data.integrators)) {
    for (const ManifestRecord& manifest : data.log->manifests) experiments_[manifest.id] = experiment_name(manifest);
    text_ = "experiment,scene,accel,integrator,seed,iterations,time_s,region,metric,value";
    for (const std::string& key : accel_keys_) text_ += ",accel." + key;
    for (const std::string& key : integrator_keys_) text_ += ",integrator." + key;
    text_ += '\n';
    for (const Configuration* configuration : data.finished())
      for (const Replicate& replicate : configuration->replicates)
        for (const CheckpointRecord* checkpoint : replicate.checkpoints) add(*checkpoint);
  }

  std::string take() { return std::move(text_); }

 private:
  void add(const CheckpointRecord& checkpoint) {
    const CellName& cell = checkpoint.cell;
    const std::string before =
        fmt::format("{},{},{},{},{},{},{}", escape_csv(experiments_[checkpoint.manifest]), escape_csv(cell.scene),
                    escape_csv(cell.accel), escape_csv(cell.integrator), cell.seed, checkpoint.iterations, checkpoint.time_s);
    const std::string after = cells_of(cell.accel, accel_keys_) + cells_of(cell.integrator, integrator_keys_);
    const auto add_metrics = [&](const std::string& region, const std::map<std::string, double>& metrics) {
      for (const auto& [metric, value] : metrics)
        fmt::format_to(std::back_inserter(text_), "{},{},{},{}{}\n", before, escape_csv(region), metric, value, after);
    };
    add_metrics("", checkpoint.metrics);
    for (const auto& [region, metrics] : checkpoint.regions) add_metrics(region, metrics);
  }

  std::vector<std::string> accel_keys_, integrator_keys_;
  std::map<std::string, std::string> experiments_;  // by manifest
  std::string text_;
};

}  // namespace

std::string curves_csv(const ReportData& data) { return CurvesText(data).take(); }

}  // namespace etendue
