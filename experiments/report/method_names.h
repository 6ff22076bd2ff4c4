// The names that a report gives to methods and structures: the label that the experiment gives one, else its full name ("ppm
// alpha=0.7 photons=1000"). Charts, which have less room, shorten full names to what tells them apart:
//
//   ppm alpha=0.7 photons=1000     photons=1000         and once, beneath: "Left out of names: ppm alpha=0.7."
//   ppm alpha=0.7 photons=2000     photons=2000
//
// Parameters that all methods of one name have alike are left out, and the name itself where there is no other.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace etendue {

struct ReportData;

struct ChartNames {
  std::map<std::string, std::string> by_full_name;
  std::vector<std::string> left_out;  // "ppm alpha=0.7"
};

// `labels`: by full name, of those that have one. No two names are shortened to the same, or to another's label.
ChartNames chart_names(const std::vector<std::string>& full_names, const std::map<std::string, std::string>& labels);

// Fills in the names of all configurations, and what charts leave out of them.
void name_methods(ReportData& data);

}  // namespace etendue
