#include "experiments/config/prediction.h"

#include "framework/core/counters.h"
#include "framework/core/error.h"
#include "framework/io/text.h"

#include <fmt/format.h>
#include <algorithm>

namespace etendue {

namespace {

// "key=0.20" is "key=0.2".
bool same_parameter(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const std::size_t at = a.find('=');
  if (at == std::string::npos || b.compare(0, at + 1, a, 0, at + 1) != 0) return false;
  const auto x = parse_number(std::string_view(a).substr(at + 1)), y = parse_number(std::string_view(b).substr(at + 1));
  return x && y && *x == *y;
}

std::string read_choice(TableReader& reader, const char* key, const char* otherwise, const std::vector<std::string>& valid) {
  const auto* node = reader.find(key);
  if (!node) return otherwise;
  const std::string name = read_text(*node, std::string("predictions.") + key);
  require_name(node->where, key, name, valid, "predictions: ");
  return name;
}

std::vector<std::string> abscissae() {
  std::vector<std::string> names{"iterations", "time"};
  for (std::size_t i = 0; i < counter_count; ++i) names.emplace_back(counter_name(static_cast<Counter>(i)));
  return names;
}

// It must select between so many of the experiment's integrators.
std::string read_selection(const ConfigNode& node, const char* key, const PredictionContext& context, std::size_t least,
                           std::size_t most) {
  const std::string wanted = read_text(node, std::string("predictions.") + key);
  const std::vector<std::string> labels = mapped(context.integrators, &Method::label);
  const auto selected =
      static_cast<std::size_t>(std::ranges::count_if(labels, [&](const std::string& label) { return selects(wanted, label); }));
  if (selected == 0) throw Error(node.where, "predictions: " + unknown_name("method", wanted, labels));
  if (selected < least || selected > most)
    throw Error(node.where, fmt::format("predictions: '{}' selects {} of the integrators; expected {}", wanted, selected,
                                        selected > most ? "one" : "three or more configurations as points"));
  return wanted;
}

void read_region(TableReader& reader, const PredictionContext& context, Prediction& prediction) {
  const auto* node = reader.find("region");
  if (!node) return;
  const std::string region = prediction.region = read_text(*node, "predictions.region");
  const std::vector<std::string> names = mapped(context.regions, &RegionChoice::name);
  const bool of_scene = std::ranges::any_of(context.regions, [&](const RegionChoice& choice) {
    return choice.name == region && (prediction.scene.empty() || choice.of_scene(prediction.scene));
  });
  if (names.empty())
    throw Error(node->where,
                fmt::format("predictions: region '{}', but there are no [[regions]]; expected one of that name", region));
  require_name(node->where, "region", region, names, "predictions: ");
  if (!of_scene) throw Error(node->where, fmt::format("predictions: {} has no region '{}'", prediction.scene, region));
}

void read_window(TableReader& reader, Prediction& prediction) {
  const auto *from = reader.find("from"), *to = reader.find("to");
  if (from) prediction.from = read_number(*from, "predictions.from", 0, 1e30);
  if (to) prediction.to = read_number(*to, "predictions.to", 0, 1e30);
  if (prediction.from >= prediction.to)
    throw Error((to ? to : from)->where,
                fmt::format("predictions: from {} to {}; expected from < to", prediction.from, prediction.to));
}

void read_fit(TableReader& reader, Prediction& prediction) {
  prediction.metric = read_choice(reader, "metric", "mse", {"mse", "rmse", "bias2", "variance"});
  prediction.x = read_choice(reader, "x", "iterations", abscissae());
  prediction.across = read_choice(reader, "points", "checkpoints", {"checkpoints", "configurations"}) == "configurations";
  const bool plateau = read_choice(reader, "model", "power", {"power", "plateau"}) == "plateau";
  prediction.model = plateau ? Prediction::Model::plateau : Prediction::Model::power;
  read_window(reader, prediction);
}

Prediction::Quantity quantity_of(const ConfigNode* over, const ConfigNode* expect) {
  if (over) return Prediction::Quantity::ratio;
  const bool of_bias = expect && expect->table() && find_key(*expect, "bias");
  return of_bias ? Prediction::Quantity::bias : Prediction::Quantity::exponent;
}

void read_expected(const ConfigNode& table, const ConfigNode* expect, const ConfigNode* source, Prediction& prediction) {
  const std::string quantity = prediction.is_ratio() ? "ratio" : prediction.is_exponent() ? "exponent" : "bias";
  if (expect)
    prediction.expected = read_expectations(*expect, "predictions.expect", {quantity}).at(quantity);
  else if (!prediction.is_ratio())
    throw Error(table.where,
                "predictions: nothing is expected; expected expect = { exponent = \"-2/3\" }, expect with a bias, or over");
  if (source) prediction.source = read_text(*source, "predictions.source");
  if (expect && !source)
    throw Error(expect->where, "predictions: expect without a source; expected source = \"whose theory or figure this is\"");
}

Prediction read_prediction(const ConfigNode& node, const PredictionContext& context) {
  TableReader reader(node, "predictions", "tables { method, expect, … }");
  Prediction prediction;
  const ConfigNode& method = reader.need("method");
  prediction.scene = read_choice(reader, "scene", "", context.scenes);
  const auto *over = reader.find("over"), *expect = reader.find("expect"), *source = reader.find("source");
  prediction.quantity = quantity_of(over, expect);
  if (over) prediction.over = read_selection(*over, "over", context, 1, 1);
  if (prediction.quantity != Prediction::Quantity::bias) read_region(reader, context, prediction);
  if (prediction.is_exponent()) read_fit(reader, prediction);
  const std::size_t least = prediction.across ? 3 : 1;
  prediction.method = read_selection(method, "method", context, least, context.integrators.size());
  reader.finish();
  read_expected(node, expect, source, prediction);
  const std::string needed = prediction.quantity == Prediction::Quantity::bias ? "bias" : "mse";
  if (!contains(context.metrics, needed))
    throw Error(node.where, fmt::format("predictions: {0} is not among the metrics; expected metrics = [\"{0}\", …]", needed));
  return prediction;
}

}  // namespace

bool selects(const std::string& method, const std::string& label) {
  const std::vector<std::string> wanted = words_of(method), present = words_of(label);
  if (wanted.empty() || present.empty() || wanted.front() != present.front()) return false;
  return std::all_of(wanted.begin() + 1, wanted.end(), [&](const std::string& parameter) {
    return std::any_of(present.begin() + 1, present.end(), [&](const auto& other) { return same_parameter(parameter, other); });
  });
}

std::vector<Prediction> read_predictions(const ConfigNode& node, const PredictionContext& context) {
  return mapped(list_elements(node, "predictions", "[[predictions]] tables { method, expect, … }"),
                [&](const ConfigNode* element) { return read_prediction(*element, context); });
}

bool StatedRecord::concerns(const Prediction& prediction, const std::string& scene) const {
  if (!prediction.scene.empty() && prediction.scene != scene) return false;
  return prediction.region.empty() || std::ranges::any_of(regions, [&](const RegionChoice& choice) {
           return choice.name == prediction.region && choice.of_scene(scene);
         });
}

void StatedRecord::merge(const StatedRecord& other) {
  for (const Prediction& prediction : other.predictions)
    if (!contains(predictions, prediction)) predictions.push_back(prediction);
  for (const RegionChoice& region : other.regions)
    if (std::ranges::none_of(regions, [&](const RegionChoice& r) { return r.name == region.name && r.scene == region.scene; }))
      regions.push_back(region);
  for (const ElsewhereFigure& figure : other.elsewhere)
    if (!contains(elsewhere, figure)) elsewhere.push_back(figure);
  labels.insert(other.labels.begin(), other.labels.end());
}

}  // namespace etendue
