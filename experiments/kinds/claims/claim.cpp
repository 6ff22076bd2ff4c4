#include "experiments/kinds/claims/claim.h"

#include <algorithm>

namespace etendue {

const Quantity* Measurement::quantity(std::string_view quantity_name) const {
  const auto found =
      std::find_if(quantities.begin(), quantities.end(), [&](const Quantity& q) { return q.name == quantity_name; });
  return found == quantities.end() ? nullptr : &*found;
}

std::span<const Measurement> measurements() {
  static const std::vector<Measurement> all = [] {
    std::vector<Measurement> rows;
    for (const auto& group : {builder_measurements(), traversal_measurements(), change_measurements(), space_measurements(),
                              object_measurements(), image_measurements(), sampling_measurements(), content_measurements()})
      rows.insert(rows.end(), group.begin(), group.end());
    return rows;
  }();
  return all;
}

const Measurement& find_measurement(const std::string& name, const Location& where) {
  std::vector<std::string> names;
  for (const Measurement& measurement : measurements()) {
    if (measurement.name == name) return measurement;
    names.push_back(measurement.name);
  }
  throw Error(where, unknown_name("measurement", name, names));
}

}  // namespace etendue
