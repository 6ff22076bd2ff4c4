// Whole images, in seconds: claims about what a box, then a tree, makes of the time that brute force takes.
//
// An image is what these notes trace: a primary ray through each pixel's centre and a shadow ray from its hit to each light, on
// one thread, without shading; at 1024 x 1024, or scaled to that.
#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/claims/measure_tools.h"
#include "experiments/kinds/claims/naive_loop.h"
#include "experiments/kinds/claims/task_shapes.h"
#include "experiments/run/run_cell.h"
#include "framework/core/units.h"
#include "framework/transport/ray_tools.h"

#include <fmt/format.h>

namespace etendue {

namespace {

using FigureKind::factor;
constexpr auto time_kind = FigureKind::time;
constexpr int image_width = 1024;

struct ImageRays {
  ClaimRays rays;
  double scale = 1;  // of seconds, to an image of 1024 x 1024
};

ImageRays image_rays(const Scene& scene, const RayQuery& tracer, int resolution) {
  const int width = std::min(image_width, 4 * resolution);
  const LightSampler lights(scene);
  ImageRays image{{}, square(static_cast<float>(image_width) / static_cast<float>(width))};
  for (int y = 0; y < width; ++y)
    for (int x = 0; x < width; ++x) {
      const Ray ray = scene.camera.ray(ivec2(width), vec2(x, y) + 0.5f, vec2(0.5f));
      image.rays.closest.push_back(ray);
      const Hit hit = tracer.closest(ray);
      if (!hit) continue;
      const SurfacePoint point = scene.surface_at(ray, hit);
      for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const float u = (static_cast<float>(i) + 0.5f) / static_cast<float>(scene.lights.size());
        if (const auto light = lights.sample(point.position, u, vec2(0.5f)))
          image.rays.shadow.push_back(shadow_ray(point, *light));
      }
    }
  return image;
}

std::vector<double> scaled(std::vector<double> values, double by) {
  for (double& value : values) value *= by;
  return values;
}

MeasureResult measure_image(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const NaiveLoop brute(scene, false), boxes(scene, true);
  const auto rotating = make_structure(scene, "median-round-robin"), simd = make_structure(scene, "brute"),
             best = make_structure(scene, "binned-sah", text_param("layout", "bvh16"));
  const ImageRays image = image_rays(scene, *best, task.resolution);
  const ClaimRays few = affordable_sample(brute, image.rays, 0.15), some = affordable_sample(boxes, image.rays, 0.15);
  const auto count = [](const ClaimRays& rays) { return static_cast<double>(rays.closest.size() + rays.shadow.size()); };
  MeasureResult result;
  result.disagreements += count_disagreements(*best, few.closest, [&](const Ray& ray) { return brute.closest(ray); });
  result.disagreements += count_disagreements(*best, some.closest, [&](const Ray& ray) { return boxes.closest(ray); });
  const auto with = [](const auto& query, const ClaimRays& rays) {
    return std::function<void()>([&query, &rays] { trace_rays(query, rays); });
  };
  const Times times = take_turns(
      task, {with(brute, few), with(boxes, some), with(*rotating, image.rays), with(*best, image.rays), with(*simd, few)});
  const double whole = image.scale * count(image.rays);
  const std::vector<double> brute_s = scaled(times[0], whole / count(few)), boxes_s = scaled(times[1], whole / count(some)),
                            tree_s = scaled(times[2], image.scale), best_s = scaled(times[3], image.scale);
  result.add("brute_s", summarise(brute_s));
  result.add("boxes_s", summarise(boxes_s));
  result.add("tree_s", summarise(tree_s));
  result.add("best_s", summarise(best_s));
  result.add("box_gain", ratio_of(brute_s, boxes_s));
  result.add("tree_gain", ratio_of(boxes_s, tree_s));
  result.add("whole_gain", ratio_of(brute_s, tree_s));
  result.add("best_gain", ratio_of(brute_s, best_s));
  result.add("four_at_once", ratio_of(times[0], times[4]));
  result.remarks.push_back(
      fmt::format("{}: brute force {}, boxes {}, BVH {}, on one thread, without shading; brute force on {} of {} rays and "
                  "boxes on {}, evenly "
                  "spread and scaled.",
                  task.scene, format_seconds(summarise(brute_s).median), format_seconds(summarise(boxes_s).median),
                  format_seconds(summarise(tree_s).median), count(few), count(image.rays), count(some)));
  return result;
}

// Path tracing with light sampling, all of it on the clock: seconds for 512 samples per pixel, from a few at a smaller size.
MeasureResult measure_path_image(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const SceneNeeds needs = scene_needs(scene);
  const Method path{"path", whole_param("max_depth", 5), {}};
  constexpr std::uint64_t samples = 2;
  Budget budget;
  budget.samples = samples;
  // Building is a matter of milliseconds, and not what is asked.
  const auto rendering = [&](const Method& accel, int threads) {
    return run_cell({scene, needs, accel, path, task.seed, ivec2(task.resolution), budget, threads})
        .checkpoints.back()
        .phases_s.at("trace");
  };
  const double scale = 512.0 / samples * square(static_cast<float>(image_width) / static_cast<float>(task.resolution));
  const Method binary{"binned-sah", {}, {}}, wide{"binned-sah", text_param("layout", "bvh16"), {}};
  std::vector<double> one, all, best;
  for (int repetition = 0; repetition < task.repetitions; ++repetition) {
    one.push_back(scale * rendering(binary, 1));
    all.push_back(scale * rendering(binary, task.threads));
    best.push_back(scale * rendering(wide, task.threads));
    task.progress((repetition + 1.0) / task.repetitions);
  }
  MeasureResult result;
  result.add("one_thread", summarise(one));
  result.add("all_threads", summarise(all));
  result.add("wide", summarise(best));
  result.remarks.push_back(fmt::format(
      "Path tracing with light sampling, at most five scattering events; {} samples per pixel at {} x {}, scaled; {} threads.",
      samples, task.resolution, task.resolution, task.threads));
  return result;
}

// --- tasks ---

MeasureResult measure_tasks(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const auto structure = make_structure(scene, "binned-sah");
  constexpr int samples = 4, workers = 16;
  const TaskRenderer renderer(scene, *structure, ivec2(task.resolution), samples, 2, task.seed);
  std::vector<std::function<void()>> works;
  std::vector<double> spans;
  const std::vector<std::uint64_t> costs = renderer.costs();
  for (const TaskShape shape : task_shapes) {
    works.push_back([&, tasks = renderer.cut(shape)] { renderer.run(tasks, task.threads); });
    spans.push_back(renderer.makespan(renderer.cut(shape), costs, workers));
  }
  const Times times = take_turns(task, works);
  MeasureResult result;
  for (std::size_t i = 1; i < std::size(task_shapes); ++i) {
    const std::string name(task_shape_name(task_shapes[i]));
    result.add(("balance_" + name).c_str(), spans[i] / spans[0]);
    result.add(("time_" + name).c_str(), ratio_of(times[i], times[0]));
  }
  result.add("idle_tiles", spans[0] / renderer.ideal(costs, workers));
  result.remarks.push_back(
      fmt::format("Balance: the work of each pixel counted (nodes and primitives), its tasks dealt in order to {} simulated "
                  "workers; time: on "
                  "the {} threads of this run, {} samples per pixel.",
                  workers, task.threads, samples));
  return result;
}

MeasureResult measure_locality(const MeasureTask& task) {
  const Scene scene = load_claim_scene(task.scene, task.reading);
  const auto structure = make_structure(scene, "binned-sah");
  const TaskRenderer renderer(scene, *structure, ivec2(std::min(image_width, 4 * task.resolution)), 2, 1, task.seed);
  std::vector<std::function<void()>> works;
  for (const TaskShape shape : {TaskShape::tiles, TaskShape::rows, TaskShape::samples})
    works.push_back([&, tasks = renderer.cut(shape)] { renderer.run(tasks, 1); });
  MeasureTask fewer = task;
  fewer.repetitions = std::max(1, task.repetitions / 2);
  const Times times = take_turns(fewer, works);
  MeasureResult result;
  result.add("rows", ratio_of(times[1], times[0]));
  result.add("samples", ratio_of(times[2], times[0]));
  return result;
}

}  // namespace

std::vector<Measurement> image_measurements() {
  return {{"image",
           "seconds for an image's primary and shadow rays at 1024 x 1024",
           {{"brute_s", time_kind, "brute force"},
            {"boxes_s", time_kind, "a box around each mesh"},
            {"tree_s", time_kind, "BVH by median on a rotating axis"},
            {"best_s", time_kind, "binned SAH in the bvh16 layout"},
            {"box_gain", factor, "brute force over a box around each mesh"},
            {"tree_gain", factor, "a box around each mesh over BVH"},
            {"whole_gain", factor, "brute force over BVH"},
            {"best_gain", factor, "brute force over binned SAH in the bvh16 layout"},
            {"four_at_once", factor, "brute force, one triangle at a time over four"}},
           measure_image},
          {"path-image",
           "seconds for 512 samples per pixel at 1024 x 1024",
           {{"one_thread", time_kind, "binned SAH on one thread"},
            {"all_threads", time_kind, "binned SAH on all threads"},
            {"wide", time_kind, "the same in the bvh16 layout"}},
           measure_path_image,
           true},
          {"tasks",
           "an image cut into tasks, over tiles of 8 x 8",
           {{"balance_pixels", factor, "balance, pixels over tiles"},
            {"balance_rows", factor, "balance, rows over tiles"},
            {"balance_blocks", factor, "balance, blocks over tiles"},
            {"balance_samples", factor, "balance, single samples over tiles"},
            {"time_pixels", factor, "time, pixels over tiles"},
            {"time_rows", factor, "time, rows over tiles"},
            {"time_blocks", factor, "time, blocks over tiles"},
            {"time_samples", factor, "time, single samples over tiles"},
            {"idle_tiles", factor, "tiles over perfect balance"}},
           measure_tasks,
           true},
          {"task-locality-large",
           "the same, where the mesh outgrows every cache",
           {{"rows", factor, "rows over tiles"}, {"samples", factor, "single samples over tiles"}},
           measure_locality},
          {"task-locality",
           "time on one thread, over that by tiles of 8 x 8",
           {{"rows", factor, "rows over tiles"}, {"samples", factor, "single samples over tiles"}},
           measure_locality}};
}

}  // namespace etendue
