// What a report says of experiments on change over time: time per frame, quality of the tree, speed of tracing, by policy.
#pragma once

#include "experiments/kinds/animation/animation_record.h"
#include "experiments/report/kind_report.h"

#include <string>
#include <vector>

namespace etendue {

// The seeds of one (scene, motion, builder).
struct AnimationData {
  std::string scene, motion, builder;
  std::string name;                           // "builtin:mesh · twist turns=2", with the builder where the log has several
  std::string file_stem;                      // unique
  std::vector<const AnimationRecord*> seeds;  // done
  std::size_t frames = 0;                     // that all of them have, the rest position included

  std::size_t policy_count() const { return seeds.front()->policies.size(); }
  const std::string& policy(std::size_t index) const { return seeds.front()->policies[index].policy; }
};

// Those that finished, in order of first appearance; keeps pointers into `log`.
std::vector<AnimationData> arrange_animations(const RunLog& log);

Table animations_table(const RunLog& log);

// Time per frame; cost of the tree relative to one built anew; Mrays/s.
std::vector<Figure> animation_figures(const AnimationData& animation);

// Which policy takes the least time, and what refitting costs in the end.
std::string animation_finding(const AnimationData& animation);

KindReport animation_report(const RunLog& log);

// What `etendue run` prints at its end.
std::string animation_summary(const RunLog& log);

}  // namespace etendue
