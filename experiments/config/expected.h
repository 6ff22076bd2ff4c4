// What is expected of a quantity, in the one spelling that all kinds of experiments share:
//
//   expect = { median = [1.2, 1.3], overlap = [1, inf], exponent = "-2/3", ratio = 12.7 }
//
// It is an interval, whose ends may be infinite, or a value: a number, or a fraction in quotes.
#pragma once

#include "experiments/config/config_tree.h"

#include <limits>
#include <map>
#include <string>
#include <vector>

namespace etendue {

struct Expected {
  double low = 0, high = 0;  // the same where a value is expected
  std::string text = {};     // of a value, as it was written: "-2/3"

  bool is_value() const { return low == high; }
  bool contains(double x) const { return low <= x && x <= high; }
  bool operator==(const Expected&) const = default;
};

inline constexpr double endless = std::numeric_limits<double>::infinity();

// The value of the key `expect`: at least one of these quantities. Throws Error; `owner` names the table in messages.
std::map<std::string, Expected> read_expectations(const ConfigNode& node, const std::string& owner,
                                                  const std::vector<std::string>& quantities);

}  // namespace etendue
