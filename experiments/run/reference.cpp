#include "experiments/run/reference.h"

#include "accel/registry.h"
#include "experiments/run/closed_form.h"
#include "experiments/run/file_lock.h"
#include "experiments/run/run.h"
#include "framework/core/counters.h"
#include "framework/core/parallel.h"
#include "framework/core/rng.h"
#include "framework/image/metrics.h"
#include "integrators/registry.h"
#include "integrators/warnings/out_of_reach.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <optional>

namespace etendue {

namespace {

// Seeds of references share no bits with those of experiments, which are small numbers.
constexpr std::uint64_t reference_seed = 0x7265666572656e63ull;

constexpr int fewest_light_paths = 65536;  // of a check that merges: its radius blurs small images little

// The method gets the independent sampler where it has a choice.
Method independent(const std::string& name, ParamMap params = {}) {
  for (const ParamInfo& info : find_integrator(name, {}).params)
    if (info.name == "sampler") params["sampler"] = {std::string("independent"), {}};
  return {name, std::move(params), {}};
}

std::ptrdiff_t undefined_pixels(const Image& image) {
  return std::ranges::count_if(image.pixels, [](const dvec3& p) { return !std::isfinite(p.x + p.y + p.z); });
}

Reference from_closed_form(const ReferenceRequest& request) {
  Image image;
  with_threads(request.threads, [&] { image = integrate_closed_form(request.scene, request.resolution); });
  if (const auto undefined = undefined_pixels(image); undefined > 0)
    return {{},
            fmt::format("no reference of {}: its closed form has no finite value in {} of {} pixels; expected "
                        "reference = {{ samples = N }}, or a view that it holds for",
                        request.name, undefined, image.pixels.size())};
  return {{std::move(image), 0, 0, "closed form: " + request.scene.closed_form->source,
           "integrated over each pixel by Gauss-Legendre quadrature"},
          {}};
}

Reference from_file(const ReferenceRequest& request) {
  const std::string& path = request.choice.files.front();
  RenderedReference rendered = read_reference(path);
  if (rendered.source.empty()) rendered.source = path;
  if (rendered.checks.empty()) rendered.checks = "none: given by the experiment, its variance unknown";
  const ivec2 size = rendered.image.size;
  auto reduced = reduce(rendered, request.resolution);
  if (!reduced)
    throw Error(request.choice.where, fmt::format("{} is {} x {}; expected {} x {} or a whole multiple", path, size.x, size.y,
                                                  request.resolution.x, request.resolution.y));
  if (size != request.resolution && request.scene.filter)
    throw Error(request.choice.where,
                fmt::format("{} is {} x {}, and means of its pixels are not filtered by the scene's {}; expected {} x {}", path,
                            size.x, size.y, request.scene.filter->shape().text(), request.resolution.x, request.resolution.y));
  if (const auto undefined = undefined_pixels(rendered.image); undefined > 0)
    throw Error(request.choice.where, fmt::format("{} has no finite value in {} of {} pixels; expected one in each", path,
                                                  undefined, rendered.image.pixels.size()));
  return {std::move(*reduced), {}};
}

// Holds what independent batches of an estimator give, and the rays that they took.
struct Batches {
  BatchStatistics statistics;
  double rays = 0;
};

// Each batch has as many, and one at least.
std::uint64_t samples_of_batch(std::uint64_t samples, std::uint64_t batches) {
  return std::max<std::uint64_t>(1, (samples + batches - 1) / batches);
}

Batches run_batches(const ReferenceRequest& request, const Method& method, std::uint64_t samples, std::uint64_t stream,
                    int batches = reference_batches) {
  const Method accel = default_accel();
  const auto count = static_cast<std::uint64_t>(batches);
  const auto budget = Budget::of_iterations(samples_of_batch(samples, count));
  Batches made{BatchStatistics(request.resolution, *budget.samples)};
  const std::string what =
      fmt::format("reference of {}: {} samples per pixel of {}", request.name, count * *budget.samples, method.label());
  for (int batch = 0; batch < batches; ++batch) {
    const std::string status = fmt::format("{}, {} of {} batches", what, batch, batches);
    if (request.observer) request.observer->status(status);
    const std::uint64_t seed = hash_keys(reference_seed, stream, batch);
    CellTask task{request.scene, request.needs, accel, method, seed, request.resolution, budget, request.threads};
    // An observer may end what takes long by throwing.
    if (request.observer) task.progress = [&](std::uint64_t, double) { request.observer->status(status); };
    const CellResult cell = run_cell(task);
    made.statistics.add(cell.image);
    for (const auto& [name, value] : cell.checkpoints.back().counters)
      if (name == counter_name(Counter::rays) || name == counter_name(Counter::shadow_rays))
        made.rays += static_cast<double>(value);
  }
  return made;
}

// Samples per pixel of either estimator.
struct Shares {
  std::uint64_t first, second;
};

// The one whose error falls faster with its work has all of the samples, and the other a quarter, which checks it. A pilot
// tells them apart by variance times rays, which are counted: time would make each reference another. Beside a ray a
// bidirectional path has more to do: in results/throughput it takes 1.3 to 2.6 times as long for each. Where the pilot's two
// images do not agree, one may have missed what is bright, and seem better for it: then both have all samples.
Shares share_samples(const ReferenceRequest& request, const EstimatorPair& pair, const AgreementOptions& options,
                     std::uint64_t samples) {
  constexpr std::uint64_t pilot_share = 64, check_share = 4;
  constexpr int pilot_batches = 4;
  constexpr double bidirectional_ray = 2;
  if (pair.second_checks_only) return {samples, samples};
  const std::uint64_t few = std::max<std::uint64_t>(1, samples / pilot_share);
  const Batches first = run_batches(request, pair.first, few, 3, pilot_batches);
  const Batches second = run_batches(request, pair.second, few, 4, pilot_batches);
  const double a = first.statistics.mean_variance() * first.rays;
  const double b = second.statistics.mean_variance() * second.rays * bidirectional_ray;
  const Agreement agreement = compare_means(first.statistics, second.statistics, options);
  const bool agree = agreement.verdict == Agreement::Verdict::agree || agreement.may_lack > 0;  // a pilot sees little light
  if (!agree || a == 0 || b == 0) return {samples, samples};
  const std::uint64_t check = std::max<std::uint64_t>(1, samples / check_share);
  return a <= b ? Shares{samples, check} : Shares{check, samples};
}

// Rounds to what a file holds: a run is measured against the same bits whether it rendered its reference or found it in the
// cache. (By way of an array, as GCC 12 leaves out a conversion to float and back where it vectorises.)
void round_as_stored(Image& image) {
  const std::vector<vec3> stored(image.pixels.begin(), image.pixels.end());
  std::copy(stored.begin(), stored.end(), image.pixels.begin());
}

std::optional<Reference> from_cache(const ReferenceRequest& request, const ReferenceCache& cache) {
  // The reference of an experiment must not depend on what others left in the cache: it is at least as good as the experiment
  // would render it.
  const std::uint64_t samples = request.choice.samples > 0 ? request.choice.samples : default_reference_samples;
  auto found = cache.find(request.scene, request.resolution, samples);
  if (!found) return std::nullopt;
  round_as_stored(found->image);  // one that was reduced is finer
  return Reference{std::move(*found), {}};
}

// A run goes on with the reference it began with, whatever the cache has got since.
std::optional<Reference> from_earlier(const ReferenceRequest& request) {
  if (request.earlier.empty()) return std::nullopt;
  try {
    RenderedReference rendered = read_reference(request.earlier);
    if (rendered.checks.empty() || rendered.image.size != request.resolution) return std::nullopt;
    return Reference{std::move(rendered), {}, true};
  } catch (const Error&) {
    return std::nullopt;  // lost or damaged
  }
}

bool has_delta_light(const Scene& scene) {
  return std::ranges::any_of(scene.lights, [](const Light& light) {
    return !std::holds_alternative<AreaLight>(light) && !std::holds_alternative<EnvironmentLight>(light);
  });
}

// Says why there is no room for a reference that needs so many copies of the image; "" where there is.
std::string refuse_for_memory(const ReferenceRequest& request, int copies) {
  try {
    require_room_for_image(request.name, request.resolution, copies);
    return {};
  } catch (const Error& e) {
    return std::string("no reference of ") + e.what();
  }
}

// Gives the radiance of the brightest light that has one.
double brightest_light(const Scene& scene) {
  Rgb brightest(0);
  for (const Light& light : scene.lights) {
    if (const auto* area = std::get_if<AreaLight>(&light)) brightest = glm::max(brightest, area->radiance);
    if (const auto* environment = std::get_if<EnvironmentLight>(&light)) {
      Rgb texel(environment->texels.empty() ? 1.0f : 0.0f);
      for (const Rgb& t : environment->texels) texel = glm::max(texel, t);
      brightest = glm::max(brightest, environment->scale * texel);
    }
  }
  return std::max({brightest.x, brightest.y, brightest.z});
}

// The part of a squared error that is noise of its reference: a mean of two estimators' images, the first with this weight.
struct Floors {
  double mse, relmse;
};

Floors find_floors(const BatchStatistics& first, const BatchStatistics& second, double weight, const Image& mean) {
  const double a = weight * weight, b = (1 - weight) * (1 - weight);
  return {a * first.mean_variance() + b * second.mean_variance(),
          a * first.relative_variance(mean) + b * second.relative_variance(mean)};
}

// The same where variances are not to be trusted: as if all that the images differ by were noise of one, of the greater weight.
Floors floors_by_difference(const Image& first, const Image& second, double weight) {
  const double greater = std::max(weight, 1 - weight);
  return {greater * greater * mse(first, second), greater * greater * relmse(first, second)};
}

// Gives the same where all pixels may lack so much light.
Floors floors_of_missed(const Image& image, double radiance) {
  Image lit = image;
  for (dvec3& pixel : lit.pixels) pixel += dvec3(radiance);
  return {mse(lit, image), relmse(lit, image)};
}

// A check that merges among four times the light paths in small images, and within the distance to the first light vertex, not
// to the fourth: its radius is about a quarter of what it was, and half of it in large images.
Method sharper(Method check, ivec2 resolution) {
  check.params["neighbours"] = {std::int64_t{1}, {}};
  check.params["paths"] = {std::int64_t{std::max(4 * fewest_light_paths, resolution.x * resolution.y)}, {}};
  return check;
}

// Says what to do about estimators that disagree.
std::string remedy(const ReferenceRequest& request, const EstimatorPair& pair, std::uint64_t samples) {
  const std::string closed = request.scene.closed_form ? ", or \"auto\", which takes the scene's closed form" : "";
  if (pair.second_checks_only)
    return "only merging finds caustics that mirrors or glass show, of delta lights and of tiny lamps; expected reference = { "
           "file = \"...\" } "
           "with an image made otherwise" +
           closed;
  return fmt::format(
      "one of them is wrong on this scene, unless reference = {{ samples = {} }} lets them agree; expected reference = "
      "{{ file = \"...\" }} with an image made otherwise{}",
      4 * samples, closed);
}

// Writes the reference that would do, as an experiment has it.
std::string expected_instead(std::uint64_t samples, const Agreement& agreement) {
  constexpr double most = 1e9;
  const double needed = agreement.times_the_samples * static_cast<double>(samples);
  if (!(needed < most)) return "file = \"...\"";
  return fmt::format("samples = {}", samples_needed(static_cast<double>(samples), agreement.times_the_samples));
}

// Does light get where the camera sees it in ways that bidirectional paths do not have, or hardly ever find?
bool hides_light(const ReferenceRequest& request) {
  if (!request.needs.caustic_map || has_delta_light(request.scene)) return false;
  const Method accel = default_accel(), bdpt = independent("bdpt");
  const Budget budget = Budget::of_iterations(1);
  CellTask task{request.scene, request.needs, accel, bdpt, reference_seed, request.resolution, budget, request.threads};
  bool hides = false;
  task.finished = [&](Integrator&, RenderContext& context, const CellResult&) {
    hides = !light_out_of_reach(context, bdpt.name, bdpt.params).empty();
  };
  run_cell(task);
  return hides;
}

}  // namespace

EstimatorPair choose_estimators(const Scene& scene, const SceneNeeds& needs, ivec2 resolution, bool hides_light) {
  if (!needs.caustic_map || !(has_delta_light(scene) || hides_light)) return {{"path", {}, {}}, independent("bdpt")};
  const std::int64_t paths = std::max(fewest_light_paths, resolution.x * resolution.y);
  return {{"bdpt", {}, {}}, independent("vcm", {{"paths", {paths, {}}}}), true};
}

Reference render_reference(const ReferenceRequest& request, std::uint64_t samples) {
  EstimatorPair pair = choose_estimators(request.scene, request.needs, request.resolution, hides_light(request));
  AgreementOptions options;
  options.brightest = brightest_light(request.scene);
  if (pair.second_checks_only) options.indifference = biased_check_indifference;
  const Shares shares = share_samples(request, pair, options, samples);
  const auto render = [&](const Method& method, std::uint64_t share, std::uint64_t stream) {
    if (request.observer)
      request.observer->narrate(fmt::format("reference of {}: {} samples per pixel of {}", request.name,
                                            reference_batches * samples_of_batch(share, reference_batches), method.label()));
    return run_batches(request, method, share, stream).statistics;
  };
  const BatchStatistics first = render(pair.first, shares.first, 1);
  BatchStatistics second = render(pair.second, shares.second, 2);
  Agreement agreement = compare_means(first, second, options);
  // The first one may leave light out and finds none that there is not. What merging loses beside fine geometry is not its
  // fault.
  if (pair.second_checks_only && agreement.verdict == Agreement::Verdict::disagree && !agreement.first_lacks) {
    pair.second = sharper(std::move(pair.second), request.resolution);
    second = render(pair.second, shares.second, 2);
    agreement = compare_means(first, second, options);
  }
  const bool told = agreement.verdict != Agreement::Verdict::cannot_tell;

  // All pixels have one weight, so that the variances' own noise biases nothing. Where the test cannot tell, an estimator's
  // variance is small perhaps because it has missed what is bright: all samples get the same weight.
  const double a = first.mean_variance(), b = second.mean_variance();
  const double equal = static_cast<double>(first.samples()) / static_cast<double>(first.samples() + second.samples());
  const double weight = pair.second_checks_only ? 1 : told && a + b > 0 ? b / (a + b) : equal;
  RenderedReference rendered;
  rendered.image = first.mean();
  const Image other = second.mean();
  const Floors differ = floors_by_difference(rendered.image, other, weight);
  for (std::size_t i = 0; i < other.pixels.size(); ++i)
    rendered.image.pixels[i] = weight * rendered.image.pixels[i] + (1 - weight) * other.pixels[i];
  round_as_stored(rendered.image);
  const Floors vary = find_floors(first, second, weight, rendered.image);
  const Floors lacks = floors_of_missed(rendered.image, agreement.may_lack);
  rendered.mse_floor = told ? vary.mse : std::max({vary.mse, differ.mse, lacks.mse});
  rendered.relmse_floor = told ? vary.relmse : std::max({vary.relmse, differ.relmse, lacks.relmse});
  rendered.samples = samples;
  rendered.source =
      pair.second_checks_only
          ? fmt::format("{} alone ({} samples per pixel), checked by {} ({}) to {:g} % of the image's mean", pair.first.label(),
                        first.samples(), pair.second.label(), second.samples(), 100 * biased_check_indifference)
          : fmt::format("{:.3g} of {} ({} samples per pixel) and {:.3g} of {} ({})", weight, pair.first.label(),
                        first.samples(), 1 - weight, pair.second.label(), second.samples());
  rendered.checks = agreement.text;
  Reference reference{std::move(rendered), {}};
  if (agreement.verdict == Agreement::Verdict::disagree)
    reference.failure = fmt::format("no reference of {}: {} and {} disagree ({}): {}", request.name, pair.first.label(),
                                    pair.second.label(), remedy(request, pair, samples), agreement.text);
  if (!told && request.observer)
    request.observer->warn(fmt::format(
        "the reference of {} is used, but unproven: {} samples per pixel are too few to tell whether {} and {} {}; expected "
        "reference = {{ {} }}",
        request.name, first.samples(), pair.first.label(), pair.second.label(),
        agreement.may_lack > 0 ? "both lack light" : "agree",
        expected_instead(std::max(first.samples(), second.samples()), agreement)));
  return reference;
}

ReferenceRecord reference_record(const std::string& scene_name, const Scene& scene, const RenderedReference& rendered,
                                 const std::string& file, const FileStamp& stamp) {
  const bool is_filtered = scene.filter && !rendered.checks.starts_with("none");
  const std::string filter = is_filtered ? "; pixels are filtered by a " + scene.filter->shape().text() : "";
  const ivec2 size = rendered.image.size;
  return {scene_name,
          fmt::format("{:016x}", scene.hash()),
          rendered.source,
          file,
          rendered.checks + filter,
          rendered.mse_floor,
          size.x,
          size.y,
          stamp,
          scene.warnings,
          rendered.relmse_floor};
}

Reference make_reference(const ReferenceRequest& request, const ReferenceCache& cache) {
  using Kind = ReferenceChoice::Kind;
  const Kind kind = request.choice.kind;
  if (kind == Kind::file) return from_file(request);
  if (kind == Kind::exact && !request.scene.closed_form)
    throw Error(request.choice.where,
                fmt::format("reference \"exact\": scene {} has no closed form; expected \"auto\", {{ samples = N }} "
                            "or {{ file = \"ref.exr\" }}",
                            request.name));
  if (kind != Kind::samples && request.scene.closed_form) {
    // Beside the film stand it and the two images of the cells that are measured against it.
    const std::string refusal = refuse_for_memory(request, 3);
    return refusal.empty() ? from_closed_form(request) : Reference{{}, refusal};
  }
  if (auto earlier = from_earlier(request)) return std::move(*earlier);
  if (auto cached = from_cache(request, cache)) return std::move(*cached);
  // Another shard may be rendering the same one: wait for it, then look again.
  std::optional<FileLock> lock;
  if (const auto path = cache.lock_path(request.scene, request.resolution)) {
    lock.emplace(*path);
    if (auto cached = from_cache(request, cache)) return std::move(*cached);
  }
  if (request.scene.closed_form && request.observer)
    request.observer->narrate(
        fmt::format("{}: a reference is rendered, as the experiment asks, although the scene has a closed form", request.name));
  // A cell has two images, and two estimators have sums, those of squares, and the largest values.
  if (const std::string refusal = refuse_for_memory(request, 8); !refusal.empty()) return {{}, refusal};
  Reference reference = render_reference(request, kind == Kind::samples ? request.choice.samples : default_reference_samples);
  // One that is unproven is none for others.
  if (reference.failure.empty() && reference.rendered.checks.find(undecided) == std::string::npos) {
    const auto stored = cache.store(request.scene, reference.rendered);
    if (request.observer)
      request.observer->narrate(stored ? "reference kept in " + *stored
                                       : "the reference cache cannot be written; the reference is not kept");
  }
  return reference;
}

}  // namespace etendue
