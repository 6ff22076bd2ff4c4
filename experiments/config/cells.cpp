#include "experiments/config/cells.h"

#include "experiments/kind.h"
#include "framework/io/text.h"

#include <fmt/format.h>
#include <cstdlib>
#include <regex>

namespace etendue {

namespace {

// A Slurm variable; `fallback` where it is not set.
int slurm_number(const char* name, std::optional<int> fallback) {
  const char* text = std::getenv(name);
  if (!text && fallback) return *fallback;
  const auto value = parse_whole<int>(text ? text : "");
  if (!value)
    throw Error(Location{name},
                fmt::format("'{}' is no whole number; expected what Slurm sets in a job array", text ? text : ""));
  return *value;
}

}  // namespace

std::vector<Cell> make_matrix(const ExperimentConfig& config, const std::vector<Method>& methods) {
  std::vector<Cell> cells;
  for (const std::uint64_t seed : config.seeds)
    for (std::size_t s = 0; s < config.scenes.size(); ++s)
      for (std::size_t a = 0; a < config.accels.size(); ++a)
        for (std::size_t i = 0; i < methods.size(); ++i)
          cells.push_back({s, a, i, {config.scenes[s].name, config.accels[a].label(), methods[i].label(), seed}});
  return cells;
}

std::vector<Cell> make_cells(const ExperimentConfig& config) { return config.kind->cells(config); }

std::vector<Cell> filter_cells(const std::vector<Cell>& cells, const std::string& regex) {
  constexpr std::size_t longest = 1000;  // the library's compiler recurses
  if (regex.size() > longest)
    throw Error(Location{"--filter"}, fmt::format("{} characters; expected {} at most", regex.size(), longest));
  std::vector<Cell> kept;
  try {
    auto syntax = std::regex::ECMAScript;
#ifdef __GLIBCXX__
    // That library's matcher without backtracking, so that no expression takes for ever; it has no back-references.
    syntax |= std::regex_constants::__polynomial;
#endif
    const std::regex expression(regex, syntax);
    for (const Cell& cell : cells)
      if (std::regex_search(cell.name.key(), expression)) kept.push_back(cell);
  } catch (const std::regex_error& e) {
    if (e.code() == std::regex_constants::error_complexity || e.code() == std::regex_constants::error_backref)
      throw Error(Location{"--filter"}, fmt::format("'{}': back-references are not supported", regex));
    throw Error(Location{"--filter"}, fmt::format("'{}' is no regular expression: {}", regex, e.what()));
  }
  if (kept.empty() && !cells.empty())
    throw Error(Location{"--filter"},
                fmt::format("'{}' matches no cell; the first one is '{}'", regex, cells.front().name.key()));
  return kept;
}

Shard Shard::parse(const std::string& text) {
  const Location where{"--shard"};
  if (text == "slurm") {
    if (const auto shard = from_slurm()) return *shard;
    throw Error(where, "no SLURM_ARRAY_TASK_ID in the environment; expected to run in a Slurm job array (sbatch --array=0-7)");
  }
  const auto slash = text.find('/');
  if (slash == std::string::npos) throw Error(where, fmt::format("'{}'; expected i/n such as 0/4, or slurm", text));
  const int index = parse_whole<int>(text.substr(0, slash)).value_or(-1);
  const int count = parse_whole<int>(text.substr(slash + 1)).value_or(-1);
  if (index < 0 || index >= count) throw Error(where, fmt::format("'{}'; expected i/n with i in 0 .. n-1, or slurm", text));
  return {index, count};
}

std::optional<Shard> Shard::from_slurm() {
  if (!std::getenv("SLURM_ARRAY_TASK_ID")) return std::nullopt;
  const int id = slurm_number("SLURM_ARRAY_TASK_ID", std::nullopt);
  const int lowest = slurm_number("SLURM_ARRAY_TASK_MIN", 0);
  const int step = slurm_number("SLURM_ARRAY_TASK_STEP", 1);
  if (step < 1) throw Error(Location{"SLURM_ARRAY_TASK_STEP"}, fmt::format("{} is out of range; expected 1 or more", step));
  // Without COUNT (an old Slurm) the highest index tells it.
  const int count = std::getenv("SLURM_ARRAY_TASK_COUNT")
                        ? slurm_number("SLURM_ARRAY_TASK_COUNT", std::nullopt)
                        : (slurm_number("SLURM_ARRAY_TASK_MAX", std::nullopt) - lowest) / step + 1;
  const int index = (id - lowest) / step;
  // An array such as 1,5,7 has no step: its indices reach past its count, and tasks would run the wrong cells or none.
  if (index < 0 || index >= count || (id - lowest) % step != 0)
    throw Error(Location{"SLURM_ARRAY_TASK_ID"},
                fmt::format("{} is not one of {} evenly spaced tasks from {}; expected an array such as --array=0-7", id, count,
                            lowest));
  return Shard{index, count};
}

bool in_shard(std::size_t position, const Shard& shard) {
  const auto count = static_cast<std::size_t>(shard.count);
  return (position + position / count) % count == static_cast<std::size_t>(shard.index);
}

std::vector<Cell> shard_cells(const std::vector<Cell>& cells, const Shard& shard) {
  std::vector<Cell> kept;
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (in_shard(i, shard)) kept.push_back(cells[i]);
  return kept;
}

}  // namespace etendue
