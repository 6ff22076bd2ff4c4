#include "integrators/caches/cache_fill.h"

#include "framework/transport/ray_tools.h"
#include "integrators/caches/records/irradiance_hessian.h"
#include "integrators/paths/path_event.h"

namespace etendue {

namespace {

constexpr int path_batch = 2048;                // paths traced together: as many rays at once as still pays
constexpr float coarsest = 64, finest = 1e-3f;  // accuracies between which a number of records is looked for

}  // namespace

std::span<const HemisphereSample> trace_hemisphere(const RenderContext& context, SamplerKind kind, const CachePoint& point,
                                                   const Frame& frame, int depth, std::uint64_t key, std::uint32_t pass,
                                                   const HemisphereStrata& strata, bool even,
                                                   const HemisphereRadiance& radiance) {
  static thread_local std::vector<HemisphereSample> samples;
  static thread_local std::vector<PathSample> paths;
  static thread_local std::vector<int> strata_of;  // of the paths
  samples.assign(static_cast<std::size_t>(strata.count()), {});
  const std::uint32_t begin = pass * static_cast<std::uint32_t>(strata.count());
  Sampler numbers(kind, context.seed, Stream::cache_record, key, begin);
  for (int first = 0; first < strata.count(); first += path_batch) {
    const int last = std::min(first + path_batch, strata.count());
    paths.clear();
    strata_of.clear();
    for (int i = first; i < last; ++i) {
      numbers.index = begin + static_cast<std::uint32_t>(i);  // all hashes of a Sobol sequence are those of its first point
      if (kind == SamplerKind::independent) numbers = {kind, context.seed, Stream::cache_record, key, numbers.index};
      paths.push_back({{}, numbers});
    }
    path_kernels().start_hemisphere({strata, even, frame, point.origin, first, paths});
    for (int i = first; i < last; ++i) {
      const PathSample& path = paths[static_cast<std::size_t>(i - first)];
      samples[i].direction = path.ray.direction;
      if (glm::dot(path.ray.direction, point.geometric) <= 0) continue;  // below, where shading normals disagree
      if (strata_of.size() < static_cast<std::size_t>(i - first)) paths[strata_of.size()] = path;
      strata_of.push_back(i);
    }
    paths.erase(paths.begin() + static_cast<std::ptrdiff_t>(strata_of.size()), paths.end());
    radiance(paths, depth);
    for (std::size_t i = 0; i < paths.size(); ++i) {
      HemisphereSample& sample = samples[strata_of[i]];
      sample.radiance = paths[i].radiance;
      sample.distance = paths[i].first_distance;
      sample.normal = paths[i].first_normal;
      sample.photon_footprint = paths[i].first_photon_footprint;
    }
  }
  return samples;
}

IrradianceEstimate sample_hemisphere(const RenderContext& context, const CacheSettings& settings, const CachePoint& point,
                                     int depth, std::uint64_t key, std::uint32_t pass, const HemisphereRadiance& radiance) {
  const HemisphereStrata& strata = settings.strata;
  const Frame frame = Frame::from_normal(point.normal);
  const auto samples = trace_hemisphere(context, settings.sampler, point, frame, depth, key, pass, strata, false, radiance);
  IrradianceEstimate estimate = estimate_irradiance(strata, samples, frame);
  estimate.shared_variance = photon_variance(strata, samples, frame);
  if (settings.gradients == Gradients::mesh || is_hessian(settings.metric))
    estimate_hessian(settings.metric, strata, samples, frame, settings.gradients == Gradients::mesh, estimate);
  return estimate;
}

CacheLevels::CacheLevels(const RenderContext& context, const CacheSettings& settings, std::vector<CachePoint> pixels,
                         bool one_level)
    : settings_(settings) {
  start(context, std::move(pixels), one_level, settings.accuracy);
  RecordLevels::overture(settings.overture);
  Bounds whole = context.bounds;
  if (whole.empty()) whole = bounds();
  if (!whole.empty()) settings_.scene_size = glm::length(whole.diagonal());
}

IrradianceRecords CacheLevels::make_records(const RenderContext& context) const {
  const CacheWeight weight = settings_.metric == CacheMetric::tabellion ? CacheWeight::tabellion : CacheWeight::ward;
  // The split sphere's radius is a mean distance, which grows by no more than the distance moved ([Krivanek2006]). Radii from
  // Hessians have no such bound; there the radius that a record serves at the usual accuracy may grow by the distance.
  const float clamp = is_hessian(settings_.metric) ? 1 / usual_accuracy : 1;
  return {context.make_records(settings_.structure, bounds()),
          accuracy(),
          settings_.clamping ? clamp : 0.0f,
          weight,
          settings_.stretch,
          std::clamp(settings_.accuracy / accuracy(), 1.0f, settings_.overlap)};
}

void CacheLevels::insert(IrradianceRecords& records, const RecordHistory& history) const {
  const MetricContext metric{.accuracy = settings_.accuracy,
                             .scene_size = settings_.scene_size,
                             .pixel_width = history.point.pixel_width,
                             .min_spacing = settings_.min_spacing,
                             .max_spacing = settings_.max_spacing,
                             .extrapolates = settings_.gradients >= Gradients::both};
  records.insert(
      make_record(history.point.position, history.point.normal, history.mean, settings_.gradients, settings_.metric, metric));
}

IrradianceEstimate CacheLevels::estimate(const RenderContext& context, const HemisphereRadiance& radiance,
                                         const RecordHistory& history, int depth, std::uint32_t pass) const {
  const auto sampled = [&] {
    IrradianceEstimate out = sample_hemisphere(context, settings_, history.point, depth, history.key, pass, radiance);
    out.source = source_;
    return out;
  };
  if (!settings_.at_point) return sampled();
  IrradianceEstimate exact = settings_.at_point(history.point, depth);
  if (settings_.judges_by_rays) {
    const IrradianceEstimate seen = sampled();
    exact.inverse_distance = seen.inverse_distance;
    exact.nearest = seen.nearest;
    exact.hessian = seen.hessian;
    exact.geometric = seen.geometric;
  }
  return exact;
}

void CacheLevels::fill_to(const RenderContext& context, const HemisphereRadiance& radiance, std::size_t records) {
  float coarse = coarsest, fine = finest, accuracy = settings_.accuracy;
  const auto fill_at = [&](float tried) {
    settings_.accuracy = tried;
    clear(context);
    fill(context, radiance, tried);
  };
  limit(records + 1);  // one too many shows that an accuracy is too fine
  for (int step = 0; step < 20; ++step) {
    fill_at(accuracy);
    if (size() <= records && size() >= records - records / 50) break;
    (size() > records ? fine : coarse) = accuracy;
    if (coarse / fine < 1.0005f) break;
    accuracy = std::sqrt(coarse * fine);
  }
  if (size() > records) {
    limit(records);
    fill_at(coarse);
  }
  limit(0);
}

std::vector<RecordShape> CacheLevels::shapes() const {
  std::vector<RecordShape> shapes;
  for (std::size_t level = 0; const IrradianceRecords* records = records_in(level); ++level)
    for (const IrradianceRecord& record : records->all())
      shapes.push_back({record.position, record.normal, accuracy() * record.validity_radius, record.anisotropy});
  return shapes;
}

std::optional<Interpolated> CacheLevels::interpolate(int depth, const vec3& position, const vec3& normal,
                                                     bool states_error) const {
  const IrradianceRecords* records = records_at(depth);
  if (!records) return std::nullopt;
  count(Counter::lookups);
  return records->interpolate(position, normal, states_error);
}

}  // namespace etendue
