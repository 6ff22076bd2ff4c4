// Findings of a log in words: which method leads on each scene and by how much, which structure is fastest, and reasons for
// doubt. Every sentence is computed; none is written in advance for a method.
#pragma once

#include "experiments/report/report_data.h"

#include <string>
#include <vector>

namespace etendue {

struct Finding {
  std::string topic, lead, text;  // "Accuracy", "path has the least relmse", " at 12 s: ..."; the lead may be empty
};

struct SceneFindings {
  std::string scene;
  std::vector<Finding> findings;
};

struct Conclusions {
  std::vector<SceneFindings> scenes;
  std::vector<std::string> warnings;
};

Conclusions conclude(const ReportData& data);
std::vector<std::string> warnings_of(const ReportData& data);

// The answer of a log of images or of ray structures, in one sentence; empty where nobody leads.
std::string images_answer(const ReportData& data);
std::string structures_answer(const RunLog& log);

inline constexpr std::size_t answer_width = 200;  // about as much as a reader takes in at once

// Says who leads where, most first: "path is fastest on 2 of 3 scenes (room, box), sppm on 1 (glass)". The places' names are
// left out where the sentence would grow longer than answer_width.
struct Lead {
  std::string who, where;
};
std::string who_leads(const std::vector<Lead>& leads, std::string_view does, std::string_view places);

// Writes "a, b and 3 more".
std::string enumerate(const std::vector<std::string>& names, std::string_view separator, std::size_t most);

// Writes the centre, with its interval where there is one: "1.23e-3 (1.1e-3–1.4e-3)".
std::string describe(const Estimate& estimate);
// Writes "1.20 s", "≤ 0.10 s" (below the target at the first checkpoint) or "> 60 s, 3 of 10" (never, and how many seeds
// arrived).
std::string describe(const ArrivalMedian& arrival);

// The reference's own variance as a share of the smallest mean squared error drawn for a scene; 0 where unknown.
double floor_share(const SceneData& scene);
inline constexpr double floor_share_limit = 0.01;

}  // namespace etendue
