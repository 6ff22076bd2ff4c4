// Whole images, in seconds: claims about what a box, then a tree, makes of the time that brute force takes.
//
// An image is what these notes trace: a primary ray through each pixel's centre and a shadow ray from its hit to each light, on
// one thread, without shading; at 1024 x 1024, or scaled to that.
#include "experiments/kinds/claims/measurement.h"
#include "experiments/kinds/claims/naive_loop.h"
#include "experiments/report/report_text.h"
#include "experiments/run/run_cell.h"
#include "framework/core/units.h"
#include "framework/transport/ray_tools.h"

#include <fmt/format.h>

namespace etendue {

namespace {

constexpr int image_width = 1024;

// Seconds times this are those of an image of 1024 x 1024.
double scale_from(int width) { return square(static_cast<float>(image_width) / static_cast<float>(width)); }

TrialRays image_rays(const Scene& scene, const RayQuery& tracer, int width) {
  const LightSampler lights(scene);
  TrialRays rays;
  for (int y = 0; y < width; ++y)
    for (int x = 0; x < width; ++x) {
      const Ray ray = scene.camera.ray(ivec2(width), vec2(x, y) + 0.5f, vec2(0.5f));
      rays.closest.push_back(ray);
      const Hit hit = tracer.closest(ray);
      if (!hit) continue;
      const SurfacePoint point = scene.surface_at(ray, hit);
      for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const float u = (static_cast<float>(i) + 0.5f) / static_cast<float>(scene.lights.size());
        if (const auto light = lights.sample(point.position, u, vec2(0.5f))) rays.shadow.push_back(shadow_ray(point, *light));
      }
    }
  return rays;
}

void measure_image(Trial& t) {
  const NaiveLoop brute(t.scene, false), boxes(t.scene, true);
  const RayQuery &tree = t.make("median-round-robin"), &simd = t.make("brute"), &wide = t.make("binned-sah layout=bvh16");
  const int width = std::min(image_width, 4 * t.task.resolution);
  const TrialRays all = image_rays(t.scene, wide, width), few = affordable_sample(brute, all, 0.15),
                  some = affordable_sample(boxes, all, 0.15);
  t.hold_to(wide, few.closest, [&](const Ray& ray) { return brute.closest(ray); });
  t.hold_to(wide, some.closest, [&](const Ray& ray) { return boxes.closest(ray); });
  struct Entry {
    Contender contender;
    const TrialRays& rays;
  };
  const Entry entries[] = {{{"brute", tracing_all(brute, few)}, few},
                           {{"boxes", tracing_all(boxes, some)}, some},
                           {{"tree", tracing_all(tree, all)}, all},
                           {{"best", tracing_all(wide, all)}, all},
                           {{"four at once", tracing_all(simd, few)}, few}};
  t.race(mapped(entries, &Entry::contender));
  for (const auto& [contender, rays] : entries)
    t.scale(contender.name, scale_from(width) * static_cast<double>(all.size()) / static_cast<double>(rays.size()));
  const auto seconds = [&](const char* name) { return format_seconds(t.time(name).median); };
  t.remark(
      fmt::format("{}: brute force {}, boxes {}, BVH {}, on one thread, without shading; brute force on {} of {} rays and "
                  "boxes on {}, evenly spread and scaled.",
                  t.task.scene, seconds("brute"), seconds("boxes"), seconds("tree"), few.size(), all.size(), some.size()));
}

// Path tracing with light sampling, all of it on the clock, gives seconds for 512 samples per pixel from a few at a smaller
// size.
void measure_path_image(Trial& t) {
  constexpr std::uint64_t samples = 2;
  const SceneNeeds needs = scene_needs(t.scene);
  const int resolution = t.task.resolution;
  const Method path{"path", params_of("max_depth=5"), {}};
  const Budget budget{.samples = samples};
  // Building is a matter of milliseconds, and not what is asked.
  const auto rendering = [&](const char* name, const Method& accel, int threads) {
    return Contender{name, [&, accel, threads] {
                       const CellTask task{t.scene, needs, accel, path, t.task.seed, ivec2(resolution), budget, threads};
                       return 512.0 / samples * scale_from(resolution) * run_cell(task).checkpoints.back().phases_s.at("trace");
                     }};
  };
  const Method binary{"binned-sah", {}, {}}, wide{"binned-sah", params_of("layout=bvh16"), {}};
  t.race({rendering("one", binary, 1), rendering("all", binary, t.task.threads), rendering("wide", wide, t.task.threads)});
  t.remark(fmt::format(
      "Path tracing with light sampling, at most five scattering events; {} samples per pixel at {} x {}, scaled; {}.", samples,
      resolution, resolution, counted(static_cast<std::size_t>(t.task.threads), "thread")));
}

}  // namespace

std::vector<Measurement> image_measurements() {
  constexpr auto factor = FigureKind::factor, time = FigureKind::time;
  return {{"image",
           "seconds for an image's primary and shadow rays at 1024 x 1024",
           {{"brute_s", time, "brute force", "brute"},
            {"boxes_s", time, "a box around each mesh", "boxes"},
            {"tree_s", time, "BVH by round-robin-axis median", "tree"},
            {"best_s", time, "binned SAH in the bvh16 layout", "best"},
            {"box_gain", factor, "brute force over a box around each mesh", "brute", "boxes"},
            {"tree_gain", factor, "a box around each mesh over BVH", "boxes", "tree"},
            {"whole_gain", factor, "brute force over BVH", "brute", "tree"},
            {"best_gain", factor, "brute force over binned SAH in the bvh16 layout", "brute", "best"},
            {"four_at_once", factor, "brute force, one triangle at a time over four", "brute", "four at once"}},
           measure_image},
          {"path-image",
           "seconds for 512 samples per pixel at 1024 x 1024",
           {{"one_thread", time, "binned SAH on one thread", "one"},
            {"all_threads", time, "binned SAH on all threads", "all"},
            {"wide", time, "the same in the bvh16 layout", "wide"}},
           measure_path_image,
           true}};
}

}  // namespace etendue
