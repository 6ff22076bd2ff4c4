#include "experiments/config/config_quick.h"

#include "experiments/kind.h"

namespace etendue {

void apply_quick(ConfigNode& root) {
  const ConfigNode* own = find_key(root, "quick");
  if (own == nullptr) {
    for (const std::string& assignment : kind_of(root).quick(root)) apply_override(root, assignment);
    return;
  }
  if (!own->table()) wrong_type(*own, "quick", "a table of keys to replace");
  const ConfigNode::Table replaced = *own->table();
  auto& table = std::get<ConfigNode::Table>(root.value);
  for (const auto& [key, value] : replaced) {
    if (key == "quick") throw Error(value.key_where, "quick: a [quick] inside [quick]; expected keys of the experiment");
    table.insert_or_assign(key, value);
  }
}

}  // namespace etendue
