// Images cut into tasks: claims about balance between workers, and about locality.
#include "experiments/kinds/claims/measurement.h"
#include "experiments/kinds/claims/task_shapes.h"
#include "experiments/report/report_text.h"

#include <fmt/format.h>

namespace etendue {

namespace {

Contender running(const TaskRenderer& renderer, TaskShape shape, int threads) {
  return {std::string(task_shape_name(shape)),
          timed([&renderer, threads, tasks = renderer.cut(shape)] { renderer.run(tasks, threads); })};
}

void measure_tasks(Trial& t) {
  constexpr int samples = 4, workers = 16;
  const TaskRenderer renderer(t.scene, t.make("binned-sah"), ivec2(t.task.resolution), samples, 2, t.task.seed);
  const std::vector<std::uint64_t> costs = renderer.costs();
  const auto span = [&](TaskShape shape) { return renderer.makespan(renderer.cut(shape), costs, workers); };
  std::vector<Contender> contenders;
  for (const TaskShape shape : task_shapes) {
    contenders.push_back(running(renderer, shape, t.task.threads));
    t.count(fmt::format("balance_{}", task_shape_name(shape)), span(shape) / span(TaskShape::tiles));
  }
  t.race(contenders);
  t.count("idle_tiles", span(TaskShape::tiles) / renderer.ideal(costs, workers));
  t.remark(
      fmt::format("Balance: the work of each pixel counted (nodes and primitives), its tasks dealt in order to {} simulated "
                  "workers; time: on the {} of this run, {} samples per pixel.",
                  workers, counted(static_cast<std::size_t>(t.task.threads), "thread"), samples));
}

void measure_locality(Trial& t) {
  const TaskRenderer renderer(t.scene, t.make("binned-sah"), ivec2(std::min(1024, 4 * t.task.resolution)), 2, 1, t.task.seed);
  t.race(
      {running(renderer, TaskShape::tiles, 1), running(renderer, TaskShape::rows, 1), running(renderer, TaskShape::samples, 1)},
      std::max(1, t.task.repetitions / 2));
}

}  // namespace

std::vector<Measurement> task_measurements() {
  constexpr auto factor = FigureKind::factor;
  const std::vector<Quantity> locality{{"rows", factor, "rows over tiles", "rows", "tiles"},
                                       {"samples", factor, "single samples over tiles", "samples", "tiles"}};
  return {{"tasks",
           "an image cut into tasks, over tiles of 8 x 8",
           {{"balance_pixels", factor, "balance, pixels over tiles"},
            {"balance_rows", factor, "balance, rows over tiles"},
            {"balance_blocks", factor, "balance, blocks over tiles"},
            {"balance_samples", factor, "balance, single samples over tiles"},
            {"time_pixels", factor, "time, pixels over tiles", "pixels", "tiles"},
            {"time_rows", factor, "time, rows over tiles", "rows", "tiles"},
            {"time_blocks", factor, "time, blocks over tiles", "blocks", "tiles"},
            {"time_samples", factor, "time, single samples over tiles", "samples", "tiles"},
            {"idle_tiles", factor, "tiles over perfect balance"}},
           measure_tasks,
           true},
          {"task-locality-large", "the same, where the mesh outgrows every cache", locality, measure_locality},
          {"task-locality", "time on one thread, over that by tiles of 8 x 8", locality, measure_locality}};
}

}  // namespace etendue
