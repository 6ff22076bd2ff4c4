#include "experiments/command/advice.h"

#include "experiments/config/method.h"
#include "experiments/kinds/structures/stage.h"
#include "experiments/run/run_cell.h"
#include "framework/core/parallel.h"
#include "framework/image/metrics.h"
#include "framework/transport/ray_tools.h"
#include "integrators/warnings/out_of_reach.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

constexpr double trial_s = 0.5;

// --- hazards ---

// Photons gather over kernels of about this share of the scene's diagonal (PhotonMaps).
constexpr float kernel_share = 0.007f;

// How thick what is seen is, behind each of 64 x 64 points: infinity where nothing lies behind.
std::vector<float> thicknesses(const RenderContext& context) {
  constexpr int lines = 64;
  std::vector<float> found(lines * lines, infinity);
  parallel_for(found.size(), 64, [&](std::size_t i) {
    const vec2 place = (vec2(i % lines, i / lines) + 0.5f) / static_cast<float>(lines);
    const Ray ray = context.scene.camera.ray(context.resolution, place * vec2(context.resolution), vec2(0.5f));
    const Hit hit = trace(context, ray);
    if (!hit) return;
    const SurfacePoint point = context.scene.surface_at(ray, hit);
    const vec3 inwards = glm::dot(point.normal, ray.direction) > 0 ? point.normal : -point.normal;
    if (const Hit behind = trace(context, spawn_ray(point, inwards))) found[i] = behind.t;
  });
  return found;
}

void find_hazards(const RenderContext& context, Advice& advice) {
  const PilotFindings& found = advice.findings;
  const auto warn = [&](std::string text) { advice.hazards.push_back(std::move(text)); };
  if (const std::string missed = light_out_of_reach(context, "path"); !missed.empty()) warn(missed);
  const float kernel = kernel_share * glm::length(context.bounds.diagonal());
  const std::vector<float> all = thicknesses(context);
  const auto thin = std::ranges::count_if(all, [&](float thickness) { return thickness < 2 * kernel; });
  if (thin > 0)
    warn(fmt::format(
        "{:.1f} % of what is seen is thinner than photons' kernels are wide ({:.2g} m; the thinnest {:.2g} m): density "
        "estimates may leak through it",
        100.0 * static_cast<double>(thin) / static_cast<double>(all.size()), 2 * kernel, *std::ranges::min_element(all)));
  if (found.photons_seen > 0 && found.photons_seen < 0.05)
    warn(fmt::format(
        "one photon in {:.0f} lands where the camera sees it: photons are wasted unless emission = \"importance\" or "
        "\"visibility\" guides them",
        1 / found.photons_seen));
  if (found.direct_error > 0 && found.path_error > 50 * found.direct_error)
    warn("indirect light is hard to find: one bright path in many carries it");
}

// --- a short render, twice ---

// The relMSE of one of two images by noise. What light there is at a pixel is read from those about it, in both images: its own
// mean is large where a rare bright path met it, and small in all the pixels that such paths have not met yet.
double noise_of(const Image& a, const Image& b) {
  constexpr int side = 16;
  double sum = 0;
  for (int y = 0; y < a.size.y; y += side)
    for (int x = 0; x < a.size.x; x += side) {
      const ivec2 begin(x, y), end = glm::min(begin + side, a.size);
      const Image of_a = part_of(a, begin, end), of_b = part_of(b, begin, end);
      dvec3 light(0);
      for (std::size_t i = 0; i < of_a.pixels.size(); ++i) light += of_a.pixels[i] + of_b.pixels[i];
      const double others = std::max(1.0, 2.0 * static_cast<double>(of_a.pixels.size() - 1));
      for (std::size_t i = 0; i < of_a.pixels.size(); ++i) {
        const dvec3 own = of_a.pixels[i] + of_b.pixels[i], difference = of_a.pixels[i] - of_b.pixels[i];
        const dvec3 level = (light - own) / others;
        const dvec3 errors = difference * difference / (level * level + relmse_epsilon);
        sum += 0.5 * (errors.x + errors.y + errors.z);
      }
    }
  return sum / (3 * static_cast<double>(a.pixels.size()));
}

std::optional<MeasuredNoise> try_out(const Scene& scene, const SceneNeeds& needs, const Advice& advice, int threads) {
  const Method accel{advice.structure.name, advice.structure.params}, method{advice.method.name, advice.method.params};
  const Budget budget{.time_s = trial_s};
  const CellResult one = run_cell({scene, needs, accel, method, 1, scene.resolution, budget, threads});
  // The other goes on to a second iteration at least: the first alone does not tell its time from that of preparation.
  const std::uint64_t iterations = one.checkpoints.back().iterations;
  const Budget same{.samples = std::max<std::uint64_t>(2, iterations)};
  CellTask again{scene, needs, accel, method, 2, scene.resolution, same, threads};
  again.keep_images = iterations == 1;
  const CellResult two = run_cell(again);
  const Image& other = iterations == 1 ? two.checkpoint_images.front() : two.image;
  const CheckpointRecord &first = two.checkpoints.front(), &last = two.checkpoints.back();
  MeasuredNoise noise{noise_of(one.image, other), static_cast<double>(iterations)};
  noise.iteration_s = (last.time_s - first.time_s) / static_cast<double>(last.iterations - first.iterations);
  noise.prepare_s = std::max(0.0, first.time_s - noise.iteration_s);
  noise.exponent = std::min(one.expectation.mse_exponent, -0.1);
  noise.memory_bytes = std::max(one.checkpoints.back().peak_memory_bytes, last.peak_memory_bytes);
  return noise.relmse > 0 ? std::optional(noise) : std::nullopt;
}

}  // namespace

double MeasuredNoise::seconds_to(double wanted) const {
  return prepare_s + iteration_s * std::max(1.0, iterations * std::pow(wanted / relmse, 1 / exponent));
}

Advice advise(const Scene& scene, const SceneNeeds& needs, const Budget& budget, int threads) {
  Advice advice;
  const Effort effort = effort_of(budget);
  advice.budget = budget.text();
  with_threads(threads, [&] {
    advice.structure = structure_for(scene, scene.resolution, effort);
    std::unique_ptr<RayQuery> rays;
    advice.build_s =
        seconds_of([&] { rays = find_ray_structure(advice.structure.name, {}).make(scene, advice.structure.params); });
    advice.structure_bytes = rays->stats().bytes;
    Stage stage(scene, *rays, scene.resolution, 1);
    RenderContext& context = stage.context();
    context.effort = effort;
    advice.findings = run_pilot_within_effort(context);
    advice.method = choose_method(context, advice.findings);
    find_hazards(context, advice);
  });
  advice.noise = try_out(scene, needs, advice, threads);
  return advice;
}

}  // namespace etendue
