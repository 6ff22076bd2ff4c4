#include "experiments/config/rate_law.h"

#include "framework/core/counters.h"
#include "framework/core/error.h"

#include <fmt/format.h>
#include <algorithm>
#include <charconv>

namespace etendue {

namespace {

std::vector<std::string> words(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    if (end > begin) parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failed != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// "key=0.20" is "key=0.2".
bool same_parameter(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const std::size_t at = a.find('=');
  if (at == std::string::npos || b.compare(0, at + 1, a, 0, at + 1) != 0) return false;
  const auto x = number(std::string_view(a).substr(at + 1)), y = number(std::string_view(b).substr(at + 1));
  return x && y && *x == *y;
}

// A number, or a fraction in quotes: "-2/3".
double read_exponent(const ConfigNode& node, std::string& text) {
  if (!node.text()) {
    const double value = read_number(node, "rates.exponent", -10, 10);
    text = fmt::format("{:g}", value);
    return value;
  }
  text = *node.text();
  const std::size_t slash = text.find('/');
  const auto above = number(std::string_view(text).substr(0, slash));
  const auto below = slash == std::string::npos ? 1.0 : number(std::string_view(text).substr(slash + 1));
  if (!above || !below || *below == 0 || std::abs(*above / *below) > 10)
    throw Error(node.where, fmt::format("rates.exponent: '{}'; expected a number or a fraction such as \"-2/3\"", text));
  return *above / *below;
}

std::string read_choice(TableReader& reader, const char* key, const char* otherwise, const std::vector<std::string>& valid,
                        const std::string& owner = "rates") {
  const auto* node = reader.find(key);
  if (!node) return otherwise;
  const std::string name = read_text(*node, owner + "." + key);
  if (std::find(valid.begin(), valid.end(), name) == valid.end())
    throw Error(node->where, owner + ": " + unknown_name(key, name, valid));
  return name;
}

std::vector<std::string> abscissae() {
  std::vector<std::string> names{"iterations", "time"};
  for (std::size_t i = 0; i < counter_count; ++i) names.emplace_back(counter_name(static_cast<Counter>(i)));
  return names;
}

void read_method(const ConfigNode& table, const ConfigNode* node, const RateContext& context, RateLaw& law) {
  if (!node) throw Error(table.where, "rates: a law without a method; expected method = \"…\"");
  law.method = read_text(*node, "rates.method");
  std::vector<std::string> labels;
  for (const Method& method : context.integrators) labels.push_back(method.label());
  const auto selected =
      std::count_if(labels.begin(), labels.end(), [&](const std::string& label) { return selects(law.method, label); });
  if (selected == 0) throw Error(node->where, "rates: " + unknown_name("method", law.method, labels));
  if (law.across && selected < 3)
    throw Error(node->where,
                fmt::format("rates: '{}' selects {} of the integrators; expected three or more configurations as points",
                            law.method, selected));
}

void read_window(TableReader& reader, RateLaw& law) {
  const auto *from = reader.find("from"), *to = reader.find("to");
  if (from) law.from = read_number(*from, "rates.from", 0, 1e30);
  if (to) law.to = read_number(*to, "rates.to", 0, 1e30);
  if (law.from >= law.to)
    throw Error((to ? to : from)->where, fmt::format("rates: from {} to {}; expected from < to", law.from, law.to));
}

RateLaw read_law(const ConfigNode& node, const RateContext& context) {
  if (!node.table()) wrong_type(node, "rates", "tables { method, exponent, … }");
  TableReader reader(node, "rates");
  RateLaw law;
  law.metric = read_choice(reader, "metric", "mse", {"mse", "rmse", "bias2", "variance"});
  law.x = read_choice(reader, "x", "iterations", abscissae());
  law.across = read_choice(reader, "points", "checkpoints", {"checkpoints", "configurations"}) == "configurations";
  const bool plateau = read_choice(reader, "model", "power", {"power", "plateau"}) == "plateau";
  law.model = plateau ? RateLaw::Model::plateau : RateLaw::Model::power;
  read_place(reader, "rates", context, law.scene, law.region);
  read_method(node, reader.find("method"), context, law);
  read_window(reader, law);
  const auto *exponent = reader.find("exponent"), *source = reader.find("source");
  reader.finish();
  if (!exponent) throw Error(node.where, "rates: a law without an exponent; expected exponent = \"-2/3\" or the like");
  law.exponent = read_exponent(*exponent, law.exponent_text);
  if (!source) throw Error(node.where, "rates: a law without a source; expected source = \"whose theory this is\"");
  law.source = read_text(*source, "rates.source");
  if (std::find(context.metrics.begin(), context.metrics.end(), "mse") == context.metrics.end())
    throw Error(node.where, "rates: mse is not among the metrics; expected metrics = [\"mse\", …]");
  return law;
}

}  // namespace

bool selects(const std::string& method, const std::string& label) {
  const std::vector<std::string> wanted = words(method), present = words(label);
  if (wanted.empty() || present.empty() || wanted.front() != present.front()) return false;
  return std::all_of(wanted.begin() + 1, wanted.end(), [&](const std::string& parameter) {
    return std::any_of(present.begin() + 1, present.end(), [&](const auto& other) { return same_parameter(parameter, other); });
  });
}

void read_place(TableReader& reader, const std::string& owner, const RateContext& context, std::string& scene,
                std::string& region) {
  scene = read_choice(reader, "scene", "", context.scenes, owner);
  const auto* node = reader.find("region");
  if (!node) return;
  region = read_text(*node, owner + ".region");
  std::vector<std::string> names;
  bool of_scene = false;
  for (const RegionChoice& choice : context.regions) {
    names.push_back(choice.name);
    of_scene = of_scene || (choice.name == region && (scene.empty() || choice.of_scene(scene)));
  }
  if (names.empty())
    throw Error(node->where,
                fmt::format("{}: region '{}', but there are no [[regions]]; expected one of that name", owner, region));
  if (std::find(names.begin(), names.end(), region) == names.end())
    throw Error(node->where, owner + ": " + unknown_name("region", region, names));
  if (!of_scene) throw Error(node->where, fmt::format("{}: {} has no region '{}'", owner, scene, region));
}

std::vector<RateLaw> read_rates(const ConfigNode& node, const RateContext& context) {
  std::vector<RateLaw> laws;
  for (const ConfigNode* element : list_elements(node, "rates", "[[rates]] tables { method, exponent, … }"))
    laws.push_back(read_law(*element, context));
  return laws;
}

void RateRecord::merge(const RateRecord& other) {
  for (const RateLaw& law : other.laws)
    if (std::find(laws.begin(), laws.end(), law) == laws.end()) laws.push_back(law);
  for (const RegionChoice& region : other.regions)
    if (std::none_of(regions.begin(), regions.end(),
                     [&](const RegionChoice& r) { return r.name == region.name && r.scene == region.scene; }))
      regions.push_back(region);
  for (const RatioClaim& ratio : other.ratios)
    if (std::find(ratios.begin(), ratios.end(), ratio) == ratios.end()) ratios.push_back(ratio);
}

bool RateRecord::concerns(const std::string& stated_scene, const std::string& region, const std::string& scene) const {
  if (!stated_scene.empty() && stated_scene != scene) return false;
  return region.empty() || std::any_of(regions.begin(), regions.end(), [&](const RegionChoice& choice) {
           return choice.name == region && choice.of_scene(scene);
         });
}

}  // namespace etendue
