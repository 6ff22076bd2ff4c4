#include "experiments/kinds/animation/animation.h"

#include "accel/bvh/bvh.h"
#include "accel/bvh/dynamic/dynamic_bvh.h"
#include "accel/registry.h"
#include "experiments/kinds/structures/accel_rays.h"
#include "experiments/kinds/timing.h"
#include "experiments/statistics/statistics.h"
#include "framework/core/parallel.h"
#include "framework/core/sampler.h"
#include "framework/scene/motion.h"

#include <fmt/format.h>

namespace etendue {

namespace {

constexpr std::size_t ray_grain = 512;

class AnimationRunner {
 public:
  explicit AnimationRunner(const AnimationTask& task) : task_(task) {
    const Geometry& geometry = task.scene.objects[0].geometry;
    if (task.scene.has_instances())
      throw Error(fmt::format("{}: has instances; expected a scene of one object, whose primitives move", task.scene.name));
    if (geometry.primitive_count() == 0) throw Error(fmt::format("{}: nothing to move; expected primitives", task.scene.name));
    motion_ =
        find_motion(task.motion.name, task.motion.where).make({geometry, task.choice.frames, task.seed}, task.motion.params);
    // Its own shading plays no part: it becomes one shape without attributes.
    scene_ = task.scene;
    scene_.objects[0] = {motion_->rest(), {}, {}, {{0, geometry.primitive_count(), 0, no_id, false, false, false}}, {}};
    scene_.planes.clear();
    build_ = find_ray_structure(task.builder.name, task.builder.where).builder(task.builder.params);
  }

  AnimationRecord run() {
    record_.primitives = geometry().primitive_count();
    for (const Method& policy : task_.choice.policies) {
      const ChangePolicy change = find_change_policy(policy.name, policy.where).make(policy.params);
      record_.policies.emplace_back().policy = policy.label();
      const double time = seconds_of([&] { trees_.push_back(std::make_unique<DynamicBvh>(geometry(), build_, change)); });
      record_.policies.back().update_s.push_back(time);
      record_.policies.back().rebuilt.push_back(1);
    }
    record_.changed.push_back(0);
    trace_frame(0);
    for (int frame = 1; frame <= task_.choice.frames; ++frame) {
      if (task_.progress) task_.progress(frame);
      const std::vector<std::uint32_t> changed = motion_->pose(frame, geometry());
      record_.changed.push_back(share(changed.size()));
      for (std::size_t i = 0; i < trees_.size(); ++i) {
        TreeUpdate done;
        record_.policies[i].update_s.push_back(seconds_of([&] { done = trees_[i]->update(changed); }));
        record_.policies[i].rebuilt.push_back(share(done.rebuilt));
      }
      trace_frame(frame);
    }
    return std::move(record_);
  }

 private:
  Geometry& geometry() { return scene_.objects[0].geometry; }
  double share(std::uint64_t count) const { return static_cast<double>(count) / static_cast<double>(record_.primitives); }

  // A tree built anew says which rays there are, what they hit, and what a tree could cost.
  void trace_frame(int frame) {
    const Bvh anew(geometry(), build_(build_items(geometry())));
    record_.rebuilt_sah_cost.push_back(anew.stats().sah_cost);
    record_rays(anew, frame);
    record_.rays.push_back(static_cast<double>(rays_.size()));
    const auto tracing = mapped(trees_, [&](const auto& tree) { return timed([&] { trace(*tree, hits_); }); });
    const Times times = take_turns(tracing, task_.choice.repetitions);
    for (std::size_t i = 0; i < trees_.size(); ++i) {
      record_.policies[i].trace_s.push_back(median(times[i]));
      record_.policies[i].sah_cost.push_back(trees_[i]->stats().sah_cost);
      trace(*trees_[i], hits_);
      for (std::size_t r = 0; r < rays_.size(); ++r)
        record_.policies[i].disagreements += hits_[r].t != expected_[r].t || hits_[r].primitive != expected_[r].primitive;
    }
  }

  template <class Structure>
  void trace(const Structure& structure, std::vector<Hit>& hits) const {
    hits.resize(rays_.size());
    parallel_for(rays_.size(), ray_grain, [&](std::size_t i) { hits[i] = structure.closest(rays_[i]); });
  }

  // Records primary rays pixel by pixel, then a cosine-weighted bounce from each of their hits.
  void record_rays(const Bvh& anew, int frame) {
    const int resolution = task_.choice.resolution;
    rays_.clear();
    std::vector<Ray> bounces;
    for (int y = 0; y < resolution; ++y)
      for (int x = 0; x < resolution; ++x) {
        const std::size_t pixel = pixel_index({x, y}, ivec2(resolution));
        Sampler sampler(SamplerKind::independent, task_.seed, Stream::test, pixel, static_cast<std::uint32_t>(frame));
        const vec2 film = vec2(x, y) + sampler.get_2d();
        const Ray ray = scene_.camera.ray(ivec2(resolution), film, sampler.get_2d());
        rays_.push_back(ray);
        if (const Hit hit = anew.closest(ray)) bounces.push_back(cosine_bounce(scene_, ray, hit, sampler));
      }
    rays_.insert(rays_.end(), bounces.begin(), bounces.end());
    trace(anew, expected_);
  }

  const AnimationTask& task_;
  std::unique_ptr<Motion> motion_;
  Scene scene_;
  TreeBuilder build_;
  std::vector<std::unique_ptr<DynamicBvh>> trees_;
  std::vector<Ray> rays_;
  std::vector<Hit> hits_, expected_;
  AnimationRecord record_;
};

}  // namespace

AnimationChoice read_animation(const ConfigNode& node) {
  TableReader reader(node, "dynamic");
  AnimationChoice choice;
  reader.whole("frames", choice.frames, 1, 1'000'000);
  reader.whole("resolution", choice.resolution, 1, 8192);
  reader.whole("repetitions", choice.repetitions, 1, 1000);
  const auto names = [](const auto& entries) {
    return mapped(entries, [](const auto& entry) { return Method{entry.name, {}, {}}; });
  };
  const auto *moving = reader.find("motions"), *policies = reader.find("policies");
  choice.motions = moving ? read_motions(*moving) : names(motions());
  choice.policies = policies ? read_policies(*policies) : names(change_policies());
  reader.finish();
  return choice;
}

std::vector<Method> read_builders(const ConfigNode* node) {
  std::vector<std::string> names;
  std::vector<Method> all;
  for (const RayEntry& entry : ray_structures()) {
    if (!entry.builder) continue;
    names.push_back(entry.name);
    all.push_back({entry.name, {}, node ? node->where : Location{}});
  }
  if (!node) return {{"binned-sah", {}, {}}};
  if (node->text() && *node->text() == "all") return all;
  std::vector<Method> builders = read_accels(*node);
  for (const Method& method : builders) {
    const RayEntry& entry = find_ray_structure(method.name, method.where);
    if (!entry.builder)
      throw Error(method.where,
                  fmt::format("accels: '{}' cannot change over time; expected one of {}", method.name, fmt::join(names, ", ")));
    entry.builder(method.params);
  }
  return builders;
}

AnimationRecord run_animation(const AnimationTask& task) {
  AnimationRecord record;
  with_threads(task.threads, [&] { record = AnimationRunner(task).run(); });
  return record;
}

}  // namespace etendue
