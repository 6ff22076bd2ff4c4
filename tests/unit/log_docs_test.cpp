// docs/log.md names every field of every line of the log with its type, and no other.
#include "experiments/kind.h"
#include "experiments/log/field_list.h"
#include "experiments/log/values.h"
#include "tests/places.h"
#include "tests/unit/harness_process.h"

#include <gtest/gtest.h>

#include <map>
#include <sstream>

namespace etendue {
namespace {

using Types = std::map<std::string, std::string>;  // by name of the field; "?" behind the type of an optional one

// The text between the first two backticks; the rest of the line goes on behind them.
std::string quoted(std::string& line) {
  const std::size_t begin = line.find('`') + 1, end = line.find('`', begin);
  const std::string text = line.substr(begin, end - begin);
  line.erase(0, end + 1);
  return text;
}

// The first two columns of the table below each heading "### `type`". A name with RAYS in it stands for one of each kind.
std::map<std::string, Types> documented_lines() {
  std::map<std::string, Types> lines;
  std::istringstream text(read_text_file(std::string(project_folder) + "docs/log.md"));
  std::string type;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("#")) type = line.starts_with("### `") ? quoted(line) : "";
    if (type.empty() || !line.starts_with("| `")) continue;
    const std::string name = quoted(line), value = line.substr(3, line.find(" |", 3) - 3);
    const std::size_t rays = name.find("RAYS");
    if (rays == std::string::npos)
      lines[type][name] = value;
    else
      for (const RayKind kind : ray_kinds) lines[type][std::string(name).replace(rays, 4, ray_kind_name(kind))] = value;
  }
  return lines;
}

Types types_of(const std::vector<Field>& fields) {
  Types types;
  for (const Field& field : fields) types[field.name] = field.type + (field.optional ? "?" : "");
  return types;
}

TEST(LogDocs, NameEveryFieldOfEveryLine) {
  std::map<std::string, Types> lines;
  for (const LineFields& line : log_line_fields()) lines[line.type] = types_of(line.fields);
  for (const ExperimentKind* kind : experiment_kinds())
    if (const std::string type = kind->record_type(); !type.empty() && type != "loading")  // which another test adds
      lines[type] = types_of(kind->record_fields());
  const std::map<std::string, Types> documented = documented_lines();
  for (const auto& [type, fields] : documented) EXPECT_TRUE(lines.contains(type)) << type;
  for (const auto& [type, fields] : lines) {
    ASSERT_TRUE(documented.contains(type)) << type;
    EXPECT_EQ(documented.at(type), fields) << type;
  }
}

// What a list names is what a line holds.
TEST(LogDocs, ListsWhatIsWritten) {
  CheckpointRecord record;
  record.counters = {{"rays", 1}, {"lookups", 0}};
  record.non_finite = 1;
  record.regions = {{"left", {{"mse", 1}}}};
  record.confidence = {{"true", 1}};
  Types types;
  for (const LineFields& line : log_line_fields())
    if (line.type == CheckpointRecord::line_type) types = types_of(line.fields);
  const Json json = Json::parse(to_json_line(record));
  EXPECT_EQ(json.size(), types.size() + 1);  // beside its type
  EXPECT_EQ(json["counters"].size(), 1u);    // without those that are 0
  for (const auto& [name, type] : types) EXPECT_TRUE(json.contains(name)) << name;
}

}  // namespace
}  // namespace etendue
