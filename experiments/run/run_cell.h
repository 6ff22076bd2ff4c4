// One cell: build, prepare, iterate within the budget, measure at checkpoints. This is the only budget loop; `run` and `render`
// both use it.
#pragma once

#include "experiments/config/budget.h"
#include "experiments/config/method.h"
#include "experiments/config/regions.h"
#include "experiments/log/log.h"
#include "experiments/run/live.h"
#include "framework/image/film.h"
#include "framework/integrator.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace etendue {

struct CellResult;

struct CellTask {
  const Scene& scene;
  const SceneNeeds& needs;
  const Method& accel;
  const Method& integrator;
  std::uint64_t seed = 1;
  ivec2 resolution{0};
  const Budget& budget;
  int threads = 1;
  const Image* reference = nullptr;       // no metrics without one
  std::vector<std::string> metrics = {};  // names
  std::vector<Region> regions = {};       // whose metrics are measured beside the image's
  bool keep_images = false;               // of every checkpoint
  // Called about ten times a second, off the clock.
  std::function<void(std::uint64_t iterations, double time_s)> progress = {};
  // Asked after each iteration: true makes it the last.
  std::function<bool()> stop = {};
  // Before the integrator is prepared (on the clock), and after its last iteration (off it).
  std::function<void(Integrator&, RenderContext&)> before_prepare = {};
  std::function<void(Integrator&, RenderContext&, const CellResult&)> finished = {};
  bool confidence = false;            // held against the reference: what the method takes its error to be
  std::optional<Effort> effort = {};  // what the method is told; empty: the budget
  // Called before `progress`, off the clock. Where given, one ray in 256 is counted.
  std::function<void(const LiveFigures& figures)> live = {};
  std::function<void(const Film& film)> preview = {};  // called with `progress`, off the clock
  Tile window = {};                 // the part of the image that is wanted, in pixels; empty: all. Metrics take the whole
  bool looks_for_left_out = false;  // light that the method leaves out, in the end, off the clock: often a pilot
};

struct CellResult {
  Image image;
  std::uint64_t image_hash = 0;
  std::vector<CheckpointRecord> checkpoints;  // at least one; `cell` and `manifest` are the caller's to fill
  Expectation expectation;
  std::string fallback;                     // of the ray structure: RayStructureStats::fallback
  std::optional<Method> chosen = {};        // what the integrator chose to stand for it,
  std::string why = {};                     // and why
  std::optional<Method> chosen_accel = {};  // likewise what stands for the structure `auto`,
  std::string accel_why = {};
  std::vector<std::string> out_of_reach = {};  // light that the method practically never finds, and what does
  std::vector<NonFiniteSample> non_finite;     // the first few, for replay
  bool reached_error = false;                  // of a budget with an error target
  bool stopped = false;                        // by the task's `stop`, short of the budget
  std::vector<Image> checkpoint_images;        // where they are to be kept
};

// A context whose structures are those of accel/registry.h. Everything must outlive it.
RenderContext context_of(const Scene& scene, const SceneNeeds& needs, const RayQuery& rays, LightSampler& lights,
                         std::uint64_t seed, ivec2 resolution, PhaseTimes& phases);

// The effort that a method is told of a budget.
Effort effort_of(const Budget& budget);
// The ray structure that suits the rays which an effort lets a method trace.
MethodChoice structure_for(const Scene& scene, ivec2 resolution, const Effort& effort);

// Throws an Error where an image of this size is too large: more pixels than there are keys for them, or more memory than is
// free for its film and the copies of it that stand beside that in the end (of all of them: `copies` times 24 bytes a pixel).
// `scene` is its name, for the message.
void require_room_for_image(const std::string& scene, ivec2 resolution, int copies);

// Throws what building, preparing or iterating throws, and what require_room_for_image does.
CellResult run_cell(const CellTask& task);

std::string_view bias_name(Bias bias);

}  // namespace etendue
