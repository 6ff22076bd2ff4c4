// The options of `etendue render`, and of the image that --from repeats.
#include "experiments/command/rendering.h"
#include "experiments/report/report_text.h"
#include "framework/io/image/exr.h"
#include "framework/io/whole_file.h"
#include "integrators/caches/records/cache_file.h"
#include "integrators/registry.h"

#include <fmt/format.h>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace etendue {

namespace {

constexpr std::uint64_t default_samples = 64;
constexpr double default_error_limit_s = 600;  // --error alone: a target out of reach must end some time

// "-p photons=200k" goes to the integrator, "-p accel.bins=32" to the structure.
constexpr std::string_view accel_prefix = "accel.";

// Parameters without a name are those of the structure that every method but `auto` has by default.
Method accel_of(const RenderCommand& command) {
  if (!command.accel.empty()) return {command.accel, {}, {"--accel"}};
  const auto of_accel = [](const std::string& assignment) { return assignment.starts_with(accel_prefix); };
  return default_accel(std::ranges::any_of(command.params, of_accel) ? "" : command.integrator);
}

void read_parameters(const RenderCommand& command, Method& integrator, Method& accel) {
  for (const std::string& assignment : command.params) {
    const Location where{"-p " + assignment};
    const auto equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) throw Error(where, "expected key=value, such as max_depth=8");
    std::string key = assignment.substr(0, equals);
    Method& method = key.starts_with(accel_prefix) ? accel : integrator;
    if (&method == &accel) key.erase(0, accel_prefix.size());
    method.params[key] = parse_param_value(assignment.substr(equals + 1), where);
  }
}

Budget read_budget(const RenderCommand& command) {
  Budget budget;
  budget.checkpoints.linear = 1;
  budget.samples = command.spp;
  budget.time_s = command.time_s;
  budget.error = command.error;
  if (!budget.samples && !budget.time_s) {
    if (budget.error)
      budget.time_s = default_error_limit_s;
    else
      budget.samples = default_samples;
  }
  return budget;
}

std::string output_path(const RenderCommand& command, const std::string& scene, const std::string& integrator) {
  if (!command.output.empty() || command.json) return command.output;
  if (!command.from.empty()) return std::filesystem::path(command.from).stem().string() + "-again.exr";
  return slug(scene) + "-" + slug(integrator) + ".exr";
}

// --- files and caches ---

constexpr std::size_t magic_bytes = 8;  // with which every cache file begins

// Throws Error, with the names of those that do, where an integrator `has` not what an option takes.
template <class Has>
void require(const Method& integrator, const std::string& option, const char* lack, const Has& has) {
  const IntegratorEntry& asked = find_integrator(integrator.name, integrator.where);
  if (has(*asked.make(integrator.params))) return;
  // A method may have it with other parameters alone.
  const bool by_parameters = has(*asked.make({}));
  std::vector<std::string> names;
  for (const IntegratorEntry& entry : integrators())
    if (has(*entry.make({}))) names.push_back(entry.name);
  throw Error(Location{option},
              fmt::format("integrator '{}' {}; those that do{}: {}", by_parameters ? integrator.label() : integrator.name, lack,
                          by_parameters ? ", as they are by default" : "", joined(names, ", ")));
}

void require_savable(const Method& integrator, const std::string& option) {
  require(integrator, option, "keeps no cache that can be saved",
          [](Integrator& i) { return i.cache() && i.cache()->savable(); });
}

void require_cache(const Method& integrator, const std::string& option, const char* lacks) {
  require(integrator, option, lacks, [](Integrator& i) { return i.cache() != nullptr; });
}

// Throws Error where it cannot be read, or does not begin as a cache does.
std::string read_cache_bytes(const std::string& path) {
  const Location where{path};
  std::error_code error;
  const bool regular = std::filesystem::is_regular_file(path, error);  // before it is opened: a FIFO would wait
  std::ifstream file;
  if (regular) file.open(path, std::ios::binary);
  if (!regular || !file) throw Error(where, "cannot be read; expected a file that --save-cache wrote");
  const std::string magic = make_cache_file({}, {}).substr(0, magic_bytes);
  std::string bytes(magic_bytes, '\0');
  if (!file.read(bytes.data(), magic_bytes) || bytes != magic)
    throw Error(where, "not a cache; expected a file that --save-cache wrote");
  bytes.append(std::istreambuf_iterator<char>{file}, std::istreambuf_iterator<char>{});
  if (file.bad()) throw Error(where, "cannot be read to its end");
  return bytes;
}

// The integrator that a cache was made by, where none is named ("" in `integrator`), and each of its parameters that is not
// given. Throws Error where the file is not a whole cache, or of another integrator.
void complete_from_cache(std::string_view bytes, const std::string& path, Method& integrator) {
  const CacheKey key = open_cache_file(bytes, Location{path}).key;
  if (integrator.name.empty()) integrator = {key.integrator, integrator.params, {path}};
  const IntegratorEntry& entry = find_integrator(integrator.name, integrator.where);
  if (key.integrator != entry.name)
    throw Error(Location{path}, fmt::format("a cache of integrator '{}', not of '{}'", key.integrator, entry.name));
  for (const ParamInfo& info : entry.params) {
    if (info.name == "max_depth") continue;  // the scene's, where none is asked for: a view that states another shall be told
    const auto value = key.params.find(info.name);
    if (value != key.params.end() && value->second != info.default_value)
      integrator.params.try_emplace(info.name, parse_param_value(value->second, Location{path}));
  }
}

void check_aovs(const RenderCommand& command, const Rendering& r) {
  const std::vector<std::string> names = aov_names();
  for (const std::string& aov : command.aovs) {
    const Location where{"--aov " + aov};
    require_name(where, "aov", aov, names);
    if (r.output.empty()) throw Error(where, "is written beside the image; expected -o as well");
    if (is_surface_image(aov)) continue;
    require_cache(r.integrator, where.file, aov == records_aov ? "has no records to show" : "does not estimate its own error");
  }
}

// Files are tried before the rendering, not after it: can each be written, and is each another file?
void check_files(const RenderCommand& command, const Rendering& r) {
  std::vector<std::pair<std::string, std::string>> files;  // options and paths
  if (!r.output.empty()) {
    if (!r.output.ends_with(".exr") && !r.output.ends_with(".png"))
      throw Error(Location{"-o " + r.output}, "unknown image format; expected a name that ends in .exr or .png");
    files.emplace_back("-o", r.output);
  }
  if (!command.save_cache.empty()) files.emplace_back("--save-cache", command.save_cache);
  for (const std::string& aov : command.aovs) files.emplace_back("--aov", aov_path(r.output, aov));
  std::map<std::string, std::string> options;  // by file
  for (const auto& [option, path] : files) {
    const Location where{option + " " + path};
    if (const auto [other, is_new] = options.emplace(check_writable(path, where), option); !is_new)
      throw Error(where, fmt::format("the same file as that of {}; expected another", other->second));
  }
}

// Reads what the image to repeat was made of; nothing that is typed may say otherwise.
void read_original(const RenderCommand& command, Rendering& r) {
  const std::pair<const char*, bool> typed[] = {{"-i", !command.integrator.empty()},
                                                {"--accel", !command.accel.empty()},
                                                {"--spp", command.spp.has_value()},
                                                {"--time", command.time_s.has_value()},
                                                {"--error", command.error.has_value()},
                                                {"--seed", command.seed.has_value()},
                                                {"-p", !command.params.empty()},
                                                {"--resolution", command.resolution.has_value()},
                                                {"--crop", !command.crop.empty()},
                                                {"--camera", !command.camera.empty()},
                                                {"--pixel-filter", !command.reading.pixel_filter.empty()}};
  for (const auto& [option, is_typed] : typed)
    if (is_typed)
      throw Error(Location{option},
                  fmt::format("of no use beside --from, which takes it from {}; expected one of them", command.from));
  std::map<std::string, std::string> attributes;
  r.original = read_exr(command.from, &attributes);
  if (const auto aov = attributes.find("etendue_aov"); aov != attributes.end())
    throw Error(Location{command.from}, fmt::format("shows {}; expected the image itself", aov->second));
  r.recipe = read_recipe(attributes, command.from);
  static_cast<Recipe&>(r) = *r.recipe;
  if (const ivec2 size = r.size(); size != r.original.size)
    throw Error(Location{command.from},
                fmt::format("has {} x {} pixels, and says {} x {}", r.original.size.x, r.original.size.y, size.x, size.y));
  r.reading.pixel_filter = r.recipe->pixel_filter;
  if (!command.scene.empty()) r.scene = command.scene;
}

// After the options: a cache that is asked for must be the one that the image began with, and none where there was none.
void check_cache(const Rendering& r) {
  if (!r.recipe || r.recipe->cache == r.cache) return;
  if (r.recipe->cache.empty())
    throw Error(Location{"--load-cache"}, fmt::format("{} was begun without a cache; expected none", r.command.from));
  throw Error(Location{r.command.from},
              fmt::format("was begun with a saved cache (hash {}); expected it as --load-cache FILE{}", r.recipe->cache,
                          r.cache.empty() ? "" : ", and not one with hash " + r.cache));
}

}  // namespace

Budget read_options(const RenderCommand& command, Rendering& r) {
  if (command.scene.empty() && command.from.empty()) throw Error("SCENE is required; see `etendue render --help`");
  r.scene = command.scene;
  r.integrator = {command.integrator, {}, {"--integrator"}};
  r.accel = accel_of(command);
  r.seed = command.seed.value_or(1);
  r.reading = command.reading;
  r.camera = command.camera;
  if (!command.from.empty()) read_original(command, r);
  read_parameters(command, r.integrator, r.accel);
  r.cache.clear();
  if (!command.load_cache.empty()) {
    r.cache_to_load = read_cache_bytes(command.load_cache);
    r.cache = hash_text(r.cache_to_load);
    complete_from_cache(r.cache_to_load, command.load_cache, r.integrator);
    require_savable(r.integrator, "--load-cache");
  } else if (r.integrator.name.empty()) {
    r.integrator.name = "path";
  }
  validate_integrator(r.integrator);
  validate_accel(r.accel);
  if (!command.save_cache.empty()) require_savable(r.integrator, "--save-cache");
  check_cache(r);
  r.output = output_path(command, r.scene, r.integrator.name);
  if (command.resolution) r.resolution = *command.resolution;
  check_aovs(command, r);
  check_files(command, r);
  if (contains(command.aovs, standard_error_aov)) r.states_error = true;
  Budget budget = read_budget(command);
  if (r.recipe) budget.samples = r.recipe->iterations;
  if (!r.recipe) r.budget = budget.text();
  return budget;
}

}  // namespace etendue
