#include "experiments/harness/accel_comparison.h"

#include "accel/ray/exact.h"
#include "experiments/harness/accel_rays.h"
#include "experiments/harness/method.h"
#include "framework/core/check.h"
#include "framework/core/parallel.h"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <set>

namespace etendue {

namespace {

// Two distances to the same surface, found in different arithmetic (Embree's own test, ours), agree to a few epsilon, but at
// grazing incidence rounding moves them further apart. What differs by more than this is not yet wrong: double precision
// decides.
constexpr float agreement = 1e-4f;

// Rays that are put to double precision at most, per kind; beyond, whoever differs from the referee is counted.
constexpr std::size_t most_arbitrations = 1000;

double seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

std::unique_ptr<RayQuery> make_structure(const Scene& scene, const StructureChoice& choice) {
  return find_ray_structure(choice.name, {}).make(scene, choice.params);
}

// Indices spread evenly over the rays of a kind.
std::vector<std::size_t> sample_indices(std::size_t rays, std::size_t count) {
  std::vector<std::size_t> indices(std::min(rays, count));
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = i * rays / indices.size();
  return indices;
}

// An answer to a ray of any kind: of shadow rays only whether anything is hit counts.
Hit answer(const RayQuery& structure, RayKind kind, const Ray& ray) {
  if (kind != RayKind::shadow) return structure.closest(ray);
  Hit hit;
  if (structure.occluded(ray)) hit.primitive = 0;
  return hit;
}

bool differ(RayKind kind, const Hit& a, const Hit& b) {
  if (static_cast<bool>(a) != static_cast<bool>(b)) return true;
  return a && kind != RayKind::shadow && std::abs(a.t - b.t) > agreement * std::max(std::abs(a.t), std::abs(b.t));
}

struct Contender {
  StructureRecord record;
  std::unique_ptr<RayQuery> structure;
  const RaysByKind* rays = nullptr;  // those it traces: all, or a sample where it is too slow for all
  std::vector<double> build_times;
  std::array<std::vector<double>, ray_kinds.size()> trace_times;
};

class Comparison {
 public:
  Comparison(const Scene& scene, const std::vector<StructureChoice>& choices, const ComparisonOptions& options,
             const std::function<void(const std::string&)>& progress)
      : scene_(scene), choices_(choices), options_(options), progress_(progress), contenders_(choices.size()) {}

  std::vector<StructureRecord> run() {
    build();
    record();
    time();
    count_work();
    for (const RayKind kind : ray_kinds) judge(kind);
    std::vector<StructureRecord> records;
    for (Contender& contender : contenders_) records.push_back(std::move(contender.record));
    return records;
  }

 private:
  void build() {
    for (int repetition = 0; repetition < options_.repetitions; ++repetition) {
      for (std::size_t i = 0; i < choices_.size(); ++i) {
        Contender& contender = contenders_[i];
        contender.structure.reset();
        progress_(fmt::format("building {}, {} of {}", choices_[i].name, repetition + 1, options_.repetitions));
        contender.build_times.push_back(
            seconds([&] { with_threads(1, [&] { contender.structure = make_structure(scene_, choices_[i]); }); }));
      }
    }
    for (std::size_t i = 0; i < choices_.size(); ++i) {
      const RayStructureStats stats = contenders_[i].structure->stats();
      StructureRecord& record = contenders_[i].record;
      record.scene = scene_.name;
      ParamMap params = choices_[i].params;
      params.erase("layout");  // the structure itself says which it took
      record.structure = Method{choices_[i].name, params, {}}.label();
      record.layout = stats.layout;
      record.triangles = scene_.triangle_count();
      record.bytes = stats.bytes;
      record.nodes = stats.nodes;
      record.depth = stats.depth;
      record.sah_cost = stats.sah_cost;
      record.build_s = median(contenders_[i].build_times);
    }
    brute_ = make_structure(scene_, {"brute", {}});
  }

  // The referee is Embree where it is available, or else the first structure.
  void record() {
    const auto entries = ray_structures();
    const auto embree = std::find_if(entries.begin(), entries.end(), [](const RayEntry& e) { return e.name == "embree"; });
    if (embree != entries.end() && embree->available) own_referee_ = embree->make(scene_, {});
    referee_ = own_referee_ ? own_referee_.get() : contenders_[0].structure.get();
    progress_("recording rays");
    rays_ = record_rays(scene_, *referee_, options_.resolution);
    for (std::size_t k = 0; k < ray_kinds.size(); ++k)
      for (const std::size_t i : sample_indices(rays_[k].size(), options_.brute_force_rays)) samples_[k].push_back(rays_[k][i]);
    for (std::size_t i = 0; i < choices_.size(); ++i) contenders_[i].rays = choices_[i].name == "brute" ? &samples_ : &rays_;
  }

  // One indirect call per batch of closest hits, one per shadow ray. The first round warms up and is not kept.
  void time() {
    for (int repetition = 0; repetition <= options_.repetitions; ++repetition) {
      for (Contender& contender : contenders_) {
        progress_(fmt::format("timing {}, {} of {}", contender.record.structure, repetition, options_.repetitions));
        for (std::size_t k = 0; k < ray_kinds.size(); ++k) {
          const double time = trace_time(*contender.structure, ray_kinds[k], (*contender.rays)[k]);
          if (repetition > 0) contender.trace_times[k].push_back(time);
        }
      }
    }
    double StructureRecord::*const rates[] = {&StructureRecord::primary_mrays_per_s, &StructureRecord::diffuse_mrays_per_s,
                                              &StructureRecord::shadow_mrays_per_s};
    for (Contender& contender : contenders_)
      for (std::size_t k = 0; k < ray_kinds.size(); ++k) {
        const double time = median(contender.trace_times[k]);
        contender.record.*rates[k] = time > 0 ? 1e-6 * static_cast<double>((*contender.rays)[k].size()) / time : 0;
      }
  }

  double trace_time(const RayQuery& structure, RayKind kind, const std::vector<Ray>& rays) {
    if (kind != RayKind::shadow) {
      hits_.resize(rays.size());
      return seconds([&] { structure.closest(rays, hits_); });
    }
    std::uint64_t occluded = 0;
    const double time = seconds([&] {
      for (const Ray& ray : rays) occluded += structure.occluded(ray);
    });
    CHECK_LE(occluded, rays.size());  // the answers are used, so the loop cannot be left out
    return time;
  }

  void count_work() {
    for (Contender& contender : contenders_) {
      TraversalCounters counters;
      double traced = 0;
      for (std::size_t k = 0; k < ray_kinds.size(); ++k) {
        for (const Ray& ray : (*contender.rays)[k]) {
          if (ray_kinds[k] == RayKind::shadow)
            contender.structure->occluded_counted(ray, counters);
          else
            contender.structure->closest_counted(ray, counters);
        }
        traced += static_cast<double>((*contender.rays)[k].size());
      }
      contender.record.nodes_per_ray = traced > 0 ? static_cast<double>(counters.nodes) / traced : 0;
      contender.record.primitives_per_ray = traced > 0 ? static_cast<double>(counters.primitives) / traced : 0;
    }
  }

  // Every ray on which a structure differs from the referee, or on the sample from brute force, goes to double precision, and
  // all structures whose answer that finds wrong are counted: a hit that Embree lost through an edge is Embree's disagreement.
  void judge(RayKind kind) {
    progress_(fmt::format("comparing {} hits", ray_kind_name(kind)));
    const std::vector<Ray>& rays = rays_[static_cast<std::size_t>(kind)];
    std::set<std::size_t> disputed;
    const auto compare = [&](std::size_t i, const RayQuery& measure, const auto& takes_part) {
      const Hit expected = answer(measure, kind, rays[i]);
      const bool differs = std::any_of(contenders_.begin(), contenders_.end(), [&](const Contender& c) {
        return takes_part(c) && differ(kind, answer(*c.structure, kind, rays[i]), expected);
      });
      if (differs) disputed.insert(i);
    };
    for (std::size_t i = 0; i < rays.size(); ++i) compare(i, *referee_, [&](const Contender& c) { return c.rays == &rays_; });
    for (const std::size_t i : sample_indices(rays.size(), options_.brute_force_rays))
      compare(i, *brute_, [](const Contender&) { return true; });
    std::size_t arbitrations = 0;
    for (const std::size_t i : disputed) arbitrate(kind, rays[i], arbitrations++ < most_arbitrations);
  }

  void arbitrate(RayKind kind, const Ray& ray, bool exactly) {
    const auto exact = exactly && kind != RayKind::shadow ? exact_closest(scene_, ray) : std::nullopt;
    const Hit referees = exactly ? Hit{} : answer(*referee_, kind, ray);
    for (Contender& contender : contenders_) {
      const Hit given = answer(*contender.structure, kind, ray);
      const bool right = !exactly                  ? !differ(kind, given, referees)
                         : kind == RayKind::shadow ? is_right(scene_, ray, static_cast<bool>(given))
                                                   : is_right(scene_, ray, given, exact);
      contender.record.disagreements += !right;
    }
  }

  const Scene& scene_;
  const std::vector<StructureChoice>& choices_;
  const ComparisonOptions& options_;
  const std::function<void(const std::string&)>& progress_;
  std::vector<Contender> contenders_;
  std::unique_ptr<RayQuery> brute_, own_referee_;
  const RayQuery* referee_ = nullptr;
  RaysByKind rays_, samples_;
  std::vector<Hit> hits_;
};

}  // namespace

std::vector<StructureRecord> compare_structures(const Scene& scene, const std::vector<StructureChoice>& choices,
                                                const ComparisonOptions& options,
                                                const std::function<void(const std::string&)>& progress) {
  CHECK(!choices.empty());
  CHECK_GT(options.repetitions, 0);
  return Comparison(scene, choices, options, progress).run();
}

}  // namespace etendue
