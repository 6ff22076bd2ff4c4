#include "experiments/run/recipe.h"

#include "accel/registry.h"
#include "framework/core/error.h"
#include "framework/io/text.h"
#include "integrators/registry.h"

#include <fmt/format.h>

#include <span>

namespace etendue {

namespace {

std::string resolved(const Method& method, const std::vector<ParamInfo>& infos) {
  Method all = method;
  for (const ParamInfo& info : infos) all.params.try_emplace(info.name, ParamValue{info.default_value, {}});
  return all.label();
}

// Parameters at their default are left so: what is listed may be rounded.
Method parse_method(const std::string& text, const auto& find, const Location& where) {
  const std::vector<std::string> words = words_of(text);
  Method method{words.empty() ? "" : words.front(), {}, where};
  const auto& infos = find(method.name, where).params;
  for (const std::string& word : std::span(words).subspan(std::min<std::size_t>(1, words.size()))) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos) throw Error(where, fmt::format("'{}'; expected key=value", word));
    const std::string key = word.substr(0, equals), value = word.substr(equals + 1);
    const auto same = [&](const ParamInfo& info) { return info.name == key && info.default_value == value; };
    if (std::ranges::none_of(infos, same)) method.params[key] = parse_param_value(value, where);
  }
  return method;
}

std::uint64_t whole(const std::string& text, int base, const Location& where) {
  if (const auto value = parse_whole<std::uint64_t>(text, base)) return *value;
  throw Error(where, fmt::format("'{}' is no number; expected an image as `etendue` wrote it", text));
}

// "8x0 16x16": from and to, in pixels.
Tile read_window(const std::string& text, ivec2 resolution, const Location& where) {
  const std::vector<std::string> words = words_of(text);
  std::vector<int> numbers;
  for (const std::string& word : words)
    for (const std::string_view part : {std::string_view(word).substr(0, word.find('x')),
                                        std::string_view(word).substr(std::min(word.size(), word.find('x') + 1))})
      numbers.push_back(static_cast<int>(std::min<std::uint64_t>(whole(std::string(part), 10, where), 65536)));
  if (numbers.size() != 4 || !(numbers[0] < numbers[2] && numbers[1] < numbers[3]) || numbers[2] > resolution.x ||
      numbers[3] > resolution.y)
    throw Error(where, fmt::format("'{}'; expected two pixels such as 0x0 16x16, the second beyond the first", text));
  return {{numbers[0], numbers[1]}, {numbers[2], numbers[3]}};
}

}  // namespace

std::string resolved_integrator(const Method& integrator) {
  return resolved(integrator, find_integrator(integrator.name, integrator.where).params);
}

std::string resolved_accel(const Method& accel) { return resolved(accel, find_ray_structure(accel.name, accel.where).params); }

std::optional<ivec2> parse_resolution(std::string_view text) {
  const std::size_t cross = text.find('x');
  if (cross == std::string_view::npos) return std::nullopt;
  const auto width = parse_whole<int>(text.substr(0, cross)), height = parse_whole<int>(text.substr(cross + 1));
  return width && height && *width > 0 && *height > 0 ? std::optional(ivec2(*width, *height)) : std::nullopt;
}

std::map<std::string, std::string> recipe_attributes(const Recipe& recipe, ManifestRecord manifest) {
  manifest.experiment.clear();  // that stands in the log
  manifest.date.clear();        // an image is the same on any day
  std::map<std::string, std::string> attributes{
      {"etendue_scene", recipe.scene},
      {"etendue_scene_hash", fmt::format("{:016x}", recipe.scene_hash)},
      {"etendue_integrator", resolved_integrator(recipe.integrator)},
      {"etendue_accel", resolved_accel(recipe.accel)},
      {"etendue_seed", std::to_string(recipe.seed)},
      {"etendue_resolution", fmt::format("{}x{}", recipe.resolution.x, recipe.resolution.y)},
      {"etendue_iterations", std::to_string(recipe.iterations)},
      {"etendue_budget", recipe.budget},
      {"etendue_version", manifest.version},
      {"etendue_commit", manifest.commit},
      {"etendue_manifest", to_json_line(manifest)}};
  if (!recipe.cache.empty()) attributes["etendue_cache"] = recipe.cache;
  if (recipe.states_error) attributes["etendue_states_error"] = "true";
  if (!recipe.camera.empty()) attributes["etendue_camera"] = recipe.camera;
  if (!recipe.pixel_filter.empty()) attributes["etendue_pixel_filter"] = recipe.pixel_filter;
  if (const auto& [begin, end] = recipe.window; end != ivec2(0))
    attributes["etendue_window"] = fmt::format("{}x{} {}x{}", begin.x, begin.y, end.x, end.y);
  return attributes;
}

Recipe read_recipe(const std::map<std::string, std::string>& attributes, const std::string& path) {
  const auto text = [&](const std::string& key) {
    const auto found = attributes.find("etendue_" + key);
    if (found == attributes.end())
      throw Error(Location{path}, fmt::format("no attribute etendue_{}; expected an image that `etendue render` or `etendue "
                                              "run` wrote, with all that it takes to repeat it",
                                              key));
    return found->second;
  };
  const auto at = [&](const char* key) { return Location{fmt::format("{}: etendue_{}", path, key)}; };
  Recipe recipe;
  recipe.scene = text("scene");
  recipe.scene_hash = whole(text("scene_hash"), 16, at("scene_hash"));
  recipe.integrator = parse_method(text("integrator"), find_integrator, at("integrator"));
  recipe.accel = parse_method(text("accel"), find_ray_structure, at("accel"));
  recipe.seed = whole(text("seed"), 10, at("seed"));
  const auto size = parse_resolution(text("resolution"));
  if (!size || std::max(size->x, size->y) > 65536)
    throw Error(at("resolution"), fmt::format("'{}'; expected WxH, each in 1 .. 65536", text("resolution")));
  recipe.resolution = *size;
  recipe.iterations = whole(text("iterations"), 10, at("iterations"));
  if (recipe.iterations < 1) throw Error(at("iterations"), "0 is out of range; expected 1 or more");
  recipe.budget = text("budget");
  recipe.commit = text("commit");
  if (attributes.contains("etendue_cache")) recipe.cache = text("cache");
  recipe.states_error = attributes.contains("etendue_states_error");
  if (attributes.contains("etendue_camera")) recipe.camera = text("camera");
  if (attributes.contains("etendue_pixel_filter")) recipe.pixel_filter = text("pixel_filter");
  if (attributes.contains("etendue_window")) recipe.window = read_window(text("window"), recipe.resolution, at("window"));
  return recipe;
}

}  // namespace etendue
