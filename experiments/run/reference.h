// The reference that a scene's error is measured against: its closed form, a cached or given image, or the mean of two
// unrelated unbiased estimators that agree.
#pragma once

#include "experiments/config/config.h"
#include "experiments/log/log.h"
#include "experiments/run/reference_cache.h"
#include "experiments/statistics/agreement.h"
#include "framework/scene/needs.h"

#include <string>

namespace etendue {

struct Reference {
  RenderedReference rendered;
  // Names the scene where the estimators disagree, so that nothing may be judged by this image, or where memory does not hold
  // one, so that there is none; else it is empty.
  std::string failure;
  bool earlier = false;  // it is the file that the request named
};

class RunObserver;  // run.h

struct ReferenceRequest {
  const Scene& scene;
  const SceneNeeds& needs;
  std::string name;  // of the scene, in records
  ivec2 resolution{0};
  ReferenceChoice choice;
  int threads = 1;
  RunObserver* observer = nullptr;  // is told what is being done, and how far it is
  std::string earlier{};            // a file that a run which goes on was measured against; of use if it is rendered, and whole
};

// The default takes a minute or two for a built-in scene. The report warns where the variance this leaves is not small against
// the errors measured.
inline constexpr std::uint64_t default_reference_samples = 1024;

// Makes the log's line; `file` is where the caller stored the image.
ReferenceRecord reference_record(const std::string& scene_name, const Scene& scene, const RenderedReference& rendered,
                                 const std::string& file, const FileStamp& stamp);

// Throws Error where the choice cannot be met: "exact" without a closed form, a file of another size.
Reference make_reference(const ReferenceRequest& request, const ReferenceCache& cache);

// The two estimators a scene's reference is rendered with: path tracing, and bidirectional path tracing with other random
// numbers, which has the same mean only if all densities of its strategies are right. No path tracer finds the caustic of a
// point, spot or directional light: such a scene has the bidirectional one, and vertex connection and merging to check it,
// which also samples what that one cannot: caustics shown again by mirrors and glass. If there are any, the two disagree. The
// same goes where a pilot says that bidirectional paths leave light out (`hides_light`): lamps so small that no path meets them
// behind glass.
struct EstimatorPair {
  Method first, second;
  bool second_checks_only = false;  // it is biased: the reference is the first alone
};
EstimatorPair choose_estimators(const Scene& scene, const SceneNeeds& needs, ivec2 resolution, bool hides_light = false);

// How far a check that is biased may lie off, relative to the image's mean.
inline constexpr double biased_check_indifference = 5e-3;

// Renders both in independent batches and compares them; what is unbiased is weighted by its variance. The more efficient one
// has `samples` per pixel, the other a quarter of them. Where one that merges is the darker, and disagrees, it is asked once
// more with a smaller radius, as it loses light beside what is finer than that. A reference too small to compare them is used
// and called `undecided` in its checks, with a floor taken from how far the two images differ.
Reference render_reference(const ReferenceRequest& request, std::uint64_t samples);

}  // namespace etendue
