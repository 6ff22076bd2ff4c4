#include "experiments/kinds/structures/accel_comparison.h"

#include "accel/bvh/build/epo_cost.h"
#include "accel/registry.h"
#include "experiments/config/method.h"
#include "experiments/kinds/structures/accel_check.h"
#include "experiments/kinds/structures/accel_rays.h"
#include "experiments/kinds/timing.h"
#include "framework/core/check.h"
#include "framework/core/error.h"
#include "framework/core/parallel.h"
#include "framework/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace etendue {

namespace {

constexpr std::uint32_t epo_sample = 20'000;        // triangles
constexpr std::uint64_t trial_triangles = 200'000;  // scenes above it try a builder on a part first
constexpr std::size_t trial_part = 32;
constexpr std::size_t check_block = std::size_t{1} << 17;
constexpr std::uint64_t check_bytes = std::uint64_t{1} << 30;  // of structures held at once while they are checked
constexpr double check_budgets = 15;                           // of a structure's budget, for its aimed rays
constexpr std::size_t least_rays = 16;                         // a figure from fewer says nothing

std::string label_of(Method choice) {
  choice.params.erase("layout");  // the structure itself says which it took
  return choice.label();
}

struct Contender {
  Method choice;
  Isa isa = Isa::scalar;
  StructureRecord record;
  bool skipped = false;
  int repetitions = 0;  // that fit the budget
  RaysByKind samples;   // in the place of rays that are too many
  ByRayKind<bool> sampled{};
  std::vector<double> build_times, parallel_build_times;
  ByRayKind<std::vector<double>> speeds, batched_speeds;

  std::unique_ptr<RayQuery> make(const Scene& scene) const {
    const WithIsa with(isa);
    return find_ray_structure(choice.name, {}).make(scene, choice.params);
  }
  void note(const std::string& text) { record.note += (record.note.empty() ? "" : "; ") + text; }
};

// Takes every trial_part-th triangle of a scene without instances.
Scene part_of(const Scene& scene) {
  Scene part;
  Geometry& g = part.objects[0].geometry;
  const Geometry& whole = scene.objects[0].geometry;
  for (std::size_t i = 0; i < whole.triangles.size(); i += trial_part) {
    const auto first = static_cast<std::uint32_t>(g.positions.size());
    for (int corner = 0; corner < 3; ++corner) g.positions.push_back(whole.positions[whole.triangles[i][corner]]);
    g.triangles.emplace_back(first, first + 1, first + 2);
  }
  return part;
}

// Takes the larger of two figures, repetition by repetition.
std::vector<double> larger_of(std::span<const double> a, std::span<const double> b) {
  std::vector<double> larger(std::min(a.size(), b.size()));
  std::transform(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(larger.size()), b.begin(), larger.begin(),
                 [](double x, double y) { return std::max(x, y); });
  return larger;
}

class Comparison {
 public:
  Comparison(const Scene& scene, const std::vector<Method>& choices, const StructureTiming& options,
             const std::function<void(const std::string&)>& progress)
      : scene_(scene), options_(options), progress_(progress), exact_tracer_(scene) {
    if (options_.isas.empty()) options_.isas = {chosen_isa()};
    wanted_ = choices.size() * options_.isas.size();
    for (const Isa isa : options_.isas)
      for (const Method& choice : choices) add(choice, isa);
    if (!find_ray_structure("embree", {}).available) return;
    for (const Isa isa : options_.isas)
      embrees_[isa] = {position_of({"embree", {}, {}}, isa), position_of({"embree", {{"robust", {true, {}}}}, {}}, isa),
                       position_of({"embree", {{"batches", {std::string("coherent"), {}}}}, {}}, isa)};
  }

  std::vector<StructureRecord> run() {
    record();
    for (int repetition = 0; repetition < options_.repetitions; ++repetition)
      for (Contender& contender : contenders_)
        if (!contender.skipped && repetition < contender.repetitions) visit(contender, repetition);
    for (Contender& contender : contenders_) summarise_times(contender);
    contenders_.resize(wanted_);
    if (options_.check_rays > 0) {
      for (const CheckFrame& frame : check_frames(scene_)) check(frame);
      for (Contender& contender : contenders_)
        if (const std::uint64_t most = 4 * most_checked(contender); !contender.skipped && most < options_.check_rays)
          contender.note(fmt::format("checked on {} aimed rays of {}", format_count(static_cast<double>(most)),
                                     format_count(static_cast<double>(options_.check_rays))));
    }
    return mapped(contenders_, &Contender::record);
  }

 private:
  // Records name it so.
  std::string name_of(const Method& choice, Isa isa) const {
    return label_of(choice) + (options_.isas.size() > 1 ? fmt::format(" isa={}", isa_option(isa)) : "");
  }

  void add(const Method& choice, Isa isa) {
    Contender contender;
    contender.choice = choice;
    contender.isa = isa;
    contender.repetitions = options_.repetitions;
    contender.record.scene = scene_.name;
    contender.record.structure = name_of(choice, isa);
    if (const auto layout = choice.params.find("layout"); layout != choice.params.end())
      contender.record.layout = to_text(layout->second);  // of one that is never built
    contender.record.triangles = scene_.triangle_count();
    contender.record.threads = options_.threads;
    contenders_.push_back(std::move(contender));
  }

  // The position of a structure among the contenders, which it joins where it is not yet.
  std::size_t position_of(const Method& choice, Isa isa) {
    const auto same = [&](const Contender& c) { return c.record.structure == name_of(choice, isa); };
    const auto found = std::ranges::find_if(contenders_, same);
    const auto position = static_cast<std::size_t>(found - contenders_.begin());
    if (found == contenders_.end()) add(choice, isa);
    return position;
  }

  void record() {
    progress_("recording rays");
    rays_ = record_rays(scene_, *find_ray_structure("binned-sah", {}).make(scene_, {}), options_.resolution);
    progress_("tracing them in double precision");
    for (const RayKind kind : ray_kinds) exact_[index_of(kind)] = exact_hits(exact_tracer_, rays_[index_of(kind)]);
  }

  std::span<const Ray> rays_of(const Contender& contender, RayKind kind) const {
    const std::size_t k = index_of(kind);
    return contender.sampled[k] ? contender.samples[k] : rays_[k];
  }

  void visit(Contender& contender, int repetition) {
    progress_(fmt::format("{}, {} of {}", contender.record.structure, repetition + 1, contender.repetitions));
    if (repetition == 0 && too_slow_to_build(contender)) return;
    const double used = seconds_of([&] {
      if (options_.threads > 1) contender.parallel_build_times.push_back(build(contender, options_.threads).second);
    });
    const auto built = build(contender, 1);
    const auto& structure = built.first;
    contender.build_times.push_back(built.second);
    if (repetition == 0) choose_rays(contender, *structure);
    const double traced = seconds_of([&] { trace(contender, *structure); });
    if (repetition > 0) return;
    describe(contender, *structure);
    judge(contender, *structure);
    const double round = used + built.second + traced;
    contender.repetitions = std::clamp(static_cast<int>(options_.budget_s / round), 1, options_.repetitions);
    if (contender.repetitions < options_.repetitions)
      contender.note(
          fmt::format("{} of {} repetitions, of {} each", contender.repetitions, options_.repetitions, format_seconds(round)));
  }

  // What is built quickly is built once to warm up caches and threads, as rays are traced, then three times, of which the
  // shortest counts: a few milliseconds on all threads are often disturbed, and only ever made longer.
  std::pair<std::unique_ptr<RayQuery>, double> build(const Contender& contender, int threads) const {
    constexpr double quick_s = 0.3;
    std::unique_ptr<RayQuery> structure;
    std::vector<double> times;
    with_threads(threads, [&] {  // once, or they would sleep in between
      do {
        structure.reset();
        times.push_back(seconds_of([&] { structure = contender.make(scene_); }));
      } while (times.front() <= quick_s && times.size() < 4);
    });
    const auto timed = times.begin() + (times.size() > 1);
    return {std::move(structure), *std::min_element(timed, times.end())};
  }

  bool too_slow_to_build(Contender& contender) const {
    if (scene_.triangle_count() < trial_triangles || scene_.has_instances()) return false;
    const Scene part = part_of(scene_);
    const auto try_part = [&] { return seconds_of([&] { with_threads(1, [&] { contender.make(part); }); }); };
    const double enough = 0.5 * options_.budget_s / trial_part;
    double trial = try_part();
    if (trial >= enough) trial = std::min(trial, try_part());  // the first one warms up: libraries, threads, memory
    if (trial < enough) return false;
    const double likely = trial * trial_part;
    contender.skipped = true;
    contender.note(fmt::format("not built: one in {} of the triangles took {}, all would take {} or more", trial_part,
                               format_seconds(trial), format_seconds(likely)));
    return true;
  }

  // A ray is traced three times a round: to warm up, singly, and in a batch.
  void choose_rays(Contender& contender, const RayQuery& structure) const {
    const double share = 0.5 * options_.budget_s / (3.0 * options_.repetitions * static_cast<double>(ray_kinds.size()));
    std::vector<std::string> sampled;
    for (const RayKind kind : ray_kinds) {
      const std::size_t k = index_of(kind), count = affordable_rays(structure, kind, rays_[k], share);
      if (count == rays_[k].size()) continue;
      contender.sampled[k] = true;
      if (count >= least_rays) contender.samples[k] = spread_runs(rays_[k], count);
      sampled.push_back(fmt::format("{} of {} {}", contender.samples[k].size(), rays_[k].size(), ray_kind_name(kind)));
    }
    if (!sampled.empty()) contender.note("a sample of rays: " + joined(sampled, ", "));
  }

  void trace(Contender& contender, const RayQuery& structure) const {
    for (const RayKind kind : ray_kinds) {
      const std::span<const Ray> rays = rays_of(contender, kind);
      if (rays.empty()) continue;
      const auto warming = rays.first(std::min(rays.size(), std::max<std::size_t>(1024, rays.size() / 8)));
      mrays_per_s(structure, kind, warming);
      batched_mrays_per_s(structure, kind, warming);
      contender.speeds[index_of(kind)].push_back(mrays_per_s(structure, kind, rays));
      contender.batched_speeds[index_of(kind)].push_back(batched_mrays_per_s(structure, kind, rays));
    }
  }

  // The log tells structures apart by name and layout, and one of them may have chosen the layout of another.
  void refuse_twin_of(const Contender& contender) const {
    const StructureRecord& record = contender.record;
    const auto same = [&](const Contender& other) {
      return &other != &contender && other.record.structure == record.structure && other.record.layout == record.layout;
    };
    if (std::ranges::any_of(contenders_, same))
      throw Error(contender.choice.where,
                  fmt::format("'{}' has the layout {} on {}, and so has another of these structures; expected one of the two",
                              contender.choice.label(), record.layout, record.scene));
  }

  // Fills in what needs no clock.
  void describe(Contender& contender, const RayQuery& structure) {
    StructureRecord& record = contender.record;
    const RayStructureStats stats = structure.stats();
    record.layout = stats.layout;
    refuse_twin_of(contender);
    record.fallback = stats.fallback;
    record.bytes = stats.bytes;
    record.nodes = stats.nodes;
    record.depth = stats.depth;
    record.sah_cost = stats.sah_cost;
    const RayEntry& entry = find_ray_structure(contender.choice.name, {});
    // No tree of a structure that something else stands in for: it may be too large.
    if (entry.tree && !scene_.has_instances() && stats.fallback.empty()) {
      const Geometry& geometry = scene_.objects[0].geometry;
      auto [cost, fresh] = epo_.try_emplace(record.structure);
      if (fresh) cost->second = epo_cost(entry.tree(geometry, contender.choice.params), geometry, epo_sample);
      record.epo_cost = cost->second.value;
      record.epo_triangles = cost->second.triangles;
    }
    ByRayKind<std::uint64_t> nodes{}, primitives{};
    ByRayKind<std::size_t> traced{};
    for (const RayKind kind : ray_kinds) {
      TraversalCounters counters;
      const std::span<const Ray> rays = rays_of(contender, kind);
      for (const Ray& ray : rays) {
        if (kind == RayKind::shadow)
          structure.occluded_counted(ray, counters);
        else
          structure.closest_counted(ray, counters);
      }
      nodes[index_of(kind)] = counters.nodes;
      primitives[index_of(kind)] = counters.primitives;
      traced[index_of(kind)] = rays.size();
    }
    record.nodes_per_ray = mean_over_kinds(nodes, traced, rays_);
    record.primitives_per_ray = mean_over_kinds(primitives, traced, rays_);
  }

  void judge(Contender& contender, const RayQuery& structure) const {
    for (const RayKind kind : ray_kinds) {
      const std::size_t k = index_of(kind);
      const std::span<const Ray> rays = rays_of(contender, kind);
      const auto& exact = contender.sampled[k] ? exact_hits(exact_tracer_, rays) : exact_[k];
      contender.record.checked += rays.size();
      contender.record.disagreements += kind == RayKind::shadow ? wrong_occlusions(exact_tracer_, structure, rays, exact)
                                                                : wrong_hits(exact_tracer_, structure, rays, exact);
    }
  }

  void summarise_times(Contender& contender) const {
    StructureRecord& record = contender.record;
    record.build_s = summarise(contender.build_times);
    record.parallel_build_s = summarise(contender.parallel_build_times);
    for (std::size_t k = 0; k < ray_kinds.size(); ++k) {
      record.mrays_per_s[k] = summarise(contender.speeds[k]);
      record.batched_mrays_per_s[k] = summarise(contender.batched_speeds[k]);
      const auto found = embrees_.find(contender.isa);
      if (found == embrees_.end()) continue;
      const auto& [embree, robust, coherent] = found->second;
      record.to_embree[k] = summarise(ratios(contender.speeds[k], contenders_[embree].speeds[k]));
      record.to_robust_embree[k] = summarise(ratios(contender.speeds[k], contenders_[robust].speeds[k]));
      if (!scene_.has_instances())  // which Embree is asked for ray by ray (embree.h)
        record.batched_to_embree[k] =
            summarise(ratios(contender.batched_speeds[k],
                             larger_of(contenders_[embree].batched_speeds[k], contenders_[coherent].batched_speeds[k])));
    }
  }

  // Asks every structure the same aimed rays about the scene, moved and scaled; as many structures stand at a time as fit the
  // memory.
  void check(const CheckFrame& frame) {
    const Scene moved = moved_scene(scene_, frame);
    const ExactTracer tracer(moved);
    const std::uint64_t rays = (options_.check_rays + 3) / 4;
    for (std::size_t next = 0; next < contenders_.size();) {
      std::vector<std::pair<Contender*, std::unique_ptr<RayQuery>>> group;
      for (std::uint64_t bytes = 0; next < contenders_.size() && bytes < check_bytes; ++next) {
        if (contenders_[next].skipped) continue;
        group.emplace_back(&contenders_[next], contenders_[next].make(moved));
        bytes += group.back().second->stats().bytes;
      }
      for (std::uint64_t first = 0; first < rays; first += check_block) {
        progress_(fmt::format("checking {}: {} of {} rays", frame.name, format_count(static_cast<double>(first)),
                              format_count(static_cast<double>(rays))));
        check_rays(moved, tracer, first, std::min<std::uint64_t>(check_block, rays - first), group);
      }
    }
  }

  void check_rays(const Scene& moved, const ExactTracer& tracer, std::uint64_t first, std::uint64_t count,
                  const std::vector<std::pair<Contender*, std::unique_ptr<RayQuery>>>& group) const {
    const std::vector<Ray> rays = aimed_rays(moved, first, count);
    const auto exact = exact_hits(tracer, rays);
    for (const auto& [contender, structure] : group) {
      const std::uint64_t most = most_checked(*contender), own = std::min(count, most > first ? most - first : 0);
      const auto asked = std::span(rays).first(own);
      const auto known = std::span(exact).first(own);
      contender->record.checked += 2 * own;  // answers
      contender->record.disagreements +=
          wrong_hits(tracer, *structure, asked, known) + wrong_occlusions(tracer, *structure, asked, known);
    }
  }

  // Aimed rays of a frame that a structure is asked at most: three queries each, in four frames, at the pace of its usual kind
  // of ray, in a few times its budget. Only what is far too slow is cut short: a check is there to be whole. What was too slow
  // for a single sample has no pace.
  std::uint64_t most_checked(const Contender& contender) const {
    std::vector<double> speeds;
    for (const Measured& speed : contender.record.mrays_per_s)
      if (speed.median > 0) speeds.push_back(speed.median);
    if (speeds.empty()) return std::ranges::count(contender.sampled, true) > 0 ? least_rays : std::uint64_t{1} << 50;
    return static_cast<std::uint64_t>(1e6 * summarise(speeds).median * check_budgets * options_.budget_s / 12);
  }

  const Scene& scene_;
  StructureTiming options_;
  const std::function<void(const std::string&)>& progress_;
  std::size_t wanted_ = 0;  // contenders whose records are asked for, the first ones
  const ExactTracer exact_tracer_;
  std::vector<Contender> contenders_;
  struct Embrees {
    std::size_t embree, robust, coherent;  // positions
  };
  std::map<Isa, Embrees> embrees_;  // none where Embree is not built in
  RaysByKind rays_;
  ByRayKind<std::vector<std::optional<ExactHit>>> exact_;
  std::map<std::string, EpoCost> epo_;  // by structure; layouts share their builder's tree
};

}  // namespace

std::vector<StructureRecord> compare_structures(const Scene& scene, const std::vector<Method>& choices,
                                                const StructureTiming& options,
                                                const std::function<void(const std::string&)>& progress) {
  CHECK(!choices.empty());
  CHECK_GT(options.repetitions, 0);
  if (!scene.has_masks()) return Comparison(scene, choices, options, progress).run();
  Scene opaque = scene;  // masks are decided above the structures, and the judge knows of none
  for (Object& object : opaque.objects)
    for (Shape& shape : object.shapes) shape.mask = no_id;
  return Comparison(opaque, choices, options, progress).run();
}

bool is_third_party(const StructureRecord& record) {
  return record.structure.starts_with("embree") || record.structure.starts_with("cgal");
}

}  // namespace etendue
