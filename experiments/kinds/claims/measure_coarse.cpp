// What would indirect rays gain from a mesh no finer than they need?
//
// Large meshes are made coarser by edge collapse (accel/thirdparty/collapse.h). Methods then render the scene so that rays from
// the eye meet the full mesh and all others a level of it: bounces, photons, gather rays and shadow rays. Two variants:
//
//   near   a ray that leaves the full mesh, or what stands about it, meets that mesh within a reach, a multiple of the level's
//          distance from it, and the level beyond: contacts are kept, and no ray meets the level where it left the full mesh
//   alone  it meets nothing within that reach: contacts are lost. No variant asks less of the structures, so that this is the
//          most that can be gained.
//
// A ray that starts on the level, as a path's later bounces do, meets the level alone in both. Where a ray starts is looked up
// among the points that were met lately; what that takes is measured by a variant whose level is the full mesh, and left out of
// the figures.
//
// A level has neither vertex normals nor texture coordinates, so that textured scenes are measured for their time at most.
#include "accel/registry.h"
#include "accel/thirdparty/collapse.h"
#include "experiments/kinds/claims/measurement.h"
#include "experiments/kinds/structures/stage.h"
#include "framework/transport/ray_tools.h"
#include "integrators/registry.h"

#include <fmt/format.h>

#include <array>

namespace etendue {

namespace {

constexpr std::array levels{4, 16, 64};          // of the triangles, one in so many is left
constexpr std::uint32_t least_triangles = 1000;  // of a mesh that is made coarser
constexpr float reach_of_distance = 4;
constexpr std::int64_t photons_per_pixel = 4;

struct MeasuredMethod {
  const char *name, *text, *label;
};
constexpr MeasuredMethod methods[] = {{"path", "path tracing", "path"},
                                      {"irradiance_cache", "irradiance cache", "irradiance-cache"},
                                      {"photon_map", "photon map", "photon-map"},
                                      {"final_gather", "photon map with 16 gather rays", "photon-map final_gather=16"}};

std::string work_name(const MeasuredMethod& method, int level, bool near) {
  return fmt::format("{} {}{}", method.name, level, near ? " near" : "");
}

std::string error_name(int level, bool near) { return fmt::format("error{}_{}", near ? "_near" : "", level); }

std::string looked_up_name(const MeasuredMethod& method) { return fmt::format("{} looked up", method.name); }

std::string gain_name(const MeasuredMethod& method, int level, bool near) {
  return fmt::format("{}{}_{}", method.name, near ? "_near" : "", level);
}

std::string earned_name(const MeasuredMethod& method) { return std::string("earned_") + method.name; }

// --- the scene with a level beside it ---

struct Level {
  Scene both;          // object 0 holds the scene's primitives, then those of `alone`
  Scene alone;         // the scene with its large meshes made coarser
  float distance = 0;  // metres
  std::unique_ptr<RayQuery> rays = {};

  Level(const Scene& whole, const Scene& coarse) : both(whole), alone(coarse) {}
};

bool is_large(const Scene& scene, const Shape& shape) {
  return scene.objects[0].geometry.is_triangle(shape.first_primitive) && shape.primitive_count >= least_triangles &&
         shape.first_light == no_id && shape.mask == no_id;
}

// Adds the triangles of a mesh as a shape like `model`.
void append(Object& object, std::span<const vec3> positions, std::span<const uvec3> triangles, const Shape& model) {
  Geometry& geometry = object.geometry;
  const auto vertex = static_cast<std::uint32_t>(geometry.positions.size());
  Shape shape = model;
  shape.first_primitive = geometry.primitive_count();
  shape.primitive_count = static_cast<std::uint32_t>(triangles.size());
  shape.has_normals = shape.has_uvs = shape.uses_uvs = false;
  shape.relief = no_id;
  geometry.positions.insert(geometry.positions.end(), positions.begin(), positions.end());
  for (const uvec3& t : triangles) geometry.triangles.push_back(t + vertex);
  object.shape_of.resize(geometry.primitive_count(), static_cast<std::uint32_t>(object.shapes.size()));
  object.shapes.push_back(shape);
}

std::vector<Level> make_levels(const Scene& scene) {
  const Object& fine = scene.objects[0];
  if (scene.has_instances() || !fine.geometry.quadrics.empty())
    throw Error("coarser meshes are measured in scenes of triangles without instances alone");
  std::vector<double> shares;
  for (const int level : levels) shares.push_back(1.0 / level);
  std::vector<Level> made;
  while (made.size() < levels.size()) {
    Level& level = made.emplace_back(scene, scene);
    level.alone.objects[0] = Object{};
    level.both.objects[0].shape_of.resize(fine.geometry.primitive_count(), 0);
  }
  for (const Shape& shape : fine.shapes) {
    const std::span triangles(fine.geometry.triangles.begin() + shape.first_primitive, shape.primitive_count);
    const bool large = is_large(scene, shape);
    std::vector<CoarseMesh> meshes;
    if (large) meshes = collapse_edges(fine.geometry.positions, triangles, shares);
    std::vector<vec3> corners;  // of a small mesh, triangle by triangle
    std::vector<uvec3> kept;
    for (const uvec3& t : triangles) {
      if (large) break;
      const auto v = static_cast<std::uint32_t>(corners.size());
      for (int i = 0; i < 3; ++i) corners.push_back(fine.geometry.positions[t[i]]);
      kept.emplace_back(v, v + 1, v + 2);
    }
    for (std::size_t i = 0; i < made.size(); ++i)
      for (Scene* of : {&made[i].both, &made[i].alone}) {
        append(of->objects[0], large ? meshes[i].positions : corners, large ? meshes[i].triangles : kept, shape);
        if (large) made[i].distance = std::max(made[i].distance, meshes[i].distance);
      }
  }
  for (Level& level : made) {
    Object& both = level.both.objects[0];
    if (!both.normals.empty()) both.normals.resize(both.geometry.positions.size(), vec3(0));
    if (!both.uvs.empty()) both.uvs.resize(both.geometry.positions.size(), vec2(0));
  }
  return made;
}

// --- rays by where they come from ---

class CoarseForIndirect final : public RayQuery {
 public:
  // `near`: the full mesh is asked within reach of where rays leave it.
  CoarseForIndirect(const Scene& scene, const RayQuery& full, const Level& level, bool near)
      : CoarseForIndirect(scene, full, *level.rays, scene.objects[0].geometry.primitive_count(),
                          reach_of_distance * level.distance, near) {}
  // Looks up where rays start, and sends them all to the full mesh.
  CoarseForIndirect(const Scene& scene, const RayQuery& full) : CoarseForIndirect(scene, full, full, 0, 0, false) {}

  Hit closest(const Ray& ray) const override {
    Hit hit;
    closest(std::span(&ray, 1), std::span(&hit, 1));
    return hit;
  }
  bool occluded(const Ray& ray) const override {
    bool answer = false;
    occluded(std::span(&ray, 1), std::span(&answer, 1));
    return answer;
  }
  void closest(std::span<const Ray> rays, std::span<Hit> hits) const override {
    ask(rays, hits, [](const RayQuery& of, const std::vector<Ray>& some, std::span<Hit> found) { of.closest(some, found); });
    for (std::size_t i = 0; i < rays.size(); ++i)
      if (by_level_[i] && hits[i]) {
        hits[i].primitive += first_;
        mark_of(rays[i].at(hits[i].t)) = key_of(rays[i].at(hits[i].t));
      }
  }
  void occluded(std::span<const Ray> rays, std::span<bool> answers) const override {
    ask(rays, answers,
        [](const RayQuery& of, const std::vector<Ray>& some, std::span<bool> found) { of.occluded(some, found); });
  }
  Hit passed_light(const Ray& ray) const override { return full_.passed_light(ray); }
  Hit closest_counted(const Ray& ray, TraversalCounters&) const override { return closest(ray); }
  bool occluded_counted(const Ray& ray, TraversalCounters&) const override { return occluded(ray); }
  RayStructureStats stats() const override { return full_.stats(); }

 private:
  static constexpr std::size_t mark_count = 1 << 13;

  CoarseForIndirect(const Scene& scene, const RayQuery& full, const RayQuery& level, std::uint32_t first, float reach,
                    bool near)
      : full_(full),
        level_(level),
        first_(first),
        eye_(scene.camera.ray(ivec2(1), vec2(0.5f), vec2(0.5f)).origin),
        reach_(reach),
        near_(near),
        cells_per_metre_(1e4f / glm::length(scene.bounds().diagonal())),
        marks_(mark_count, 0) {}

  // Cells of a ten thousandth of the scene tell whether a ray starts where another one met the level lately.
  std::uint32_t key_of(const vec3& p) const {
    const vec3 cell = glm::floor(p * cells_per_metre_);
    const auto whole = [](float c) { return static_cast<std::uint32_t>(static_cast<std::int64_t>(c)); };
    const std::uint32_t x = whole(cell.x), y = whole(cell.y), z = whole(cell.z);
    return (x * 0x9e3779b1u ^ y * 0x85ebca77u ^ z * 0xc2b2ae3du) | 1u;
  }
  std::uint32_t& mark_of(const vec3& p) const { return marks_[key_of(p) >> 19]; }

  // First the full mesh for all of a ray from the eye, or for the part within reach; then, for what has no answer, the level.
  template <class Answer, class Ask>
  void ask(std::span<const Ray> rays, std::span<Answer> answers, const Ask& ask_of) const {
    by_level_.assign(rays.size(), 0);
    parts_.clear();
    places_.clear();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      answers[i] = Answer{};
      const bool from_eye = rays[i].origin == eye_, from_level = mark_of(rays[i].origin) == key_of(rays[i].origin);
      by_level_[i] = from_eye ? 0 : from_level ? 2 : 1;
      if (by_level_[i] == 2 || (by_level_[i] == 1 && !near_)) continue;
      parts_.push_back(rays[i]);
      if (by_level_[i] == 1) parts_.back().t_max = std::min(rays[i].t_max, reach_ / glm::length(rays[i].direction));
      places_.push_back(i);
    }
    answer_parts(full_, answers, ask_of);
    parts_.clear();
    places_.clear();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (answers[i]) by_level_[i] = 0;
      if (by_level_[i] == 0) continue;
      parts_.push_back(rays[i]);
      if (by_level_[i] == 1) parts_.back().t_min = std::max(rays[i].t_min, reach_ / glm::length(rays[i].direction));
      places_.push_back(i);
    }
    answer_parts(level_, answers, ask_of);
  }

  template <class Answer, class Ask>
  void answer_parts(const RayQuery& of, std::span<Answer> answers, const Ask& ask_of) const {
    if (parts_.empty()) return;
    static thread_local std::unique_ptr<Answer[]> found;
    static thread_local std::size_t room = 0;
    if (room < parts_.size()) found.reset(new Answer[room = 2 * parts_.size()]);
    ask_of(of, parts_, std::span(found.get(), parts_.size()));
    for (std::size_t k = 0; k < parts_.size(); ++k) answers[places_[k]] = found[k];
  }

  const RayQuery &full_, &level_;
  std::uint32_t first_;  // primitive of the level
  vec3 eye_;
  float reach_;
  bool near_;
  float cells_per_metre_;
  mutable std::vector<std::uint32_t> marks_;  // of one thread, as all that follows
  mutable std::vector<Ray> parts_;
  mutable std::vector<std::size_t> places_;     // of the parts among the rays
  mutable std::vector<std::uint8_t> by_level_;  // 0: by the full mesh; the level answers, 1: beyond the reach, 2: all
};

// --- what is measured ---

Image render(const Scene& scene, const RayQuery& rays, const std::string& label, const MeasureTask& task,
             std::uint64_t iterations, std::uint64_t seed) {
  const std::string name = label.substr(0, label.find(' '));
  ParamMap params = params_of(label.substr(name.size()));
  if (name == "photon-map") params["photons"] = {photons_per_pixel * task.resolution * task.resolution, {}};
  const auto integrator = find_integrator(name, {}).make(params);
  Stage stage(scene, rays, ivec2(task.resolution), seed);
  Film film(stage.context().resolution);
  integrator->prepare(stage.context());
  for (std::uint64_t i = 0; i < iterations; ++i) integrator->iteration(stage.context(), i, film);
  return film.mean();
}

// The square of what the level adds to the image, over the image's: of two pairs of renders, so that noise cancels.
double added_error(const Trial& t, const RayQuery& full, const Level& level, const RayQuery& rays) {
  constexpr std::uint64_t samples = 32;
  std::array<Image, 2> exact, coarse;
  for (const std::size_t i : {0, 1}) {
    exact[i] = render(t.scene, full, "path", t.task, samples, t.task.seed + i);
    coarse[i] = render(level.both, rays, "path", t.task, samples, t.task.seed + i);
  }
  double added = 0, all = 0;
  for (std::size_t p = 0; p < exact[0].pixels.size(); ++p) {
    const dvec3 a(exact[0].pixels[p]), b(exact[1].pixels[p]);
    added += glm::dot(dvec3(coarse[0].pixels[p]) - a, dvec3(coarse[1].pixels[p]) - b);
    all += glm::dot(a, b);
  }
  return added / all;
}

// The time with the full mesh over that with the level; of the latter what looking up takes is left out.
Measured gain_of(const Trial& t, const MeasuredMethod& method, int level, bool near) {
  const Measured with = t.ratio(work_name(method, level, near), method.name),
                 lookups = t.ratio(looked_up_name(method), method.name);
  const auto gain = [](double time, double looking) { return 1 / std::max(0.01, time - (looking - 1)); };
  return {gain(with.median, lookups.median), gain(with.high, lookups.low), gain(with.low, lookups.high)};
}

void measure_coarse(Trial& t) {
  const RayQuery& full = t.make("binned-sah");
  const double begin = now_s(Clock::thread);
  std::vector<Level> made = make_levels(t.scene);
  const double collapse = now_s(Clock::thread) - begin;
  t.count("collapse", collapse);
  std::deque<CoarseForIndirect> variants;
  std::vector<Contender> contenders;
  const auto add = [&](const std::string& name, const Scene& scene, const RayQuery& rays, const MeasuredMethod& method) {
    contenders.push_back(
        {name, timed([&scene, &rays, &t, &method] { keep_answer(render(scene, rays, method.label, t.task, 1, t.task.seed)); },
                     Clock::thread)});
  };
  const RayQuery& looked_up = variants.emplace_back(t.scene, full);
  for (const MeasuredMethod& method : methods) {
    add(method.name, t.scene, full, method);
    add(looked_up_name(method), t.scene, looked_up, method);
  }
  for (std::size_t i = 0; i < made.size(); ++i) {
    made[i].rays = find_ray_structure("binned-sah", {}).make(made[i].alone, {});
    t.remark(fmt::format("1/{}: {} triangles, {:.2g} of the scene's diagonal off.", levels[i], made[i].alone.triangle_count(),
                         made[i].distance / glm::length(t.scene.bounds().diagonal())));
    for (const bool near : {false, true}) {
      const RayQuery& rays = variants.emplace_back(t.scene, full, made[i], near);
      for (const MeasuredMethod& method : methods) add(work_name(method, levels[i], near), made[i].both, rays, method);
      t.count(error_name(levels[i], near), added_error(t, full, made[i], rays));
    }
  }
  t.race(contenders);
  for (const MeasuredMethod& method : methods) {
    double best = 1;
    for (const int level : levels)
      for (const bool near : {false, true}) {
        const Measured gain = gain_of(t, method, level, near);
        t.count(gain_name(method, level, near), gain);
        if (near) best = std::max(best, gain.median);
      }
    if (best > 1) t.count(earned_name(method), collapse / (1 - 1 / best));
  }
}

const char* kept(bool near) { return near ? " with contacts" : " without contacts"; }

std::vector<Quantity> coarse_quantities() {
  std::vector<Quantity> quantities;
  for (const MeasuredMethod& method : methods)
    for (const bool near : {false, true})
      for (const int level : levels)
        quantities.push_back(
            {gain_name(method, level, near), FigureKind::factor, fmt::format("{}, 1/{}{}", method.text, level, kept(near))});
  for (const bool near : {false, true})
    for (const int level : levels)
      quantities.push_back(
          {error_name(level, near), FigureKind::plain, fmt::format("squared error that 1/{} adds{}", level, kept(near))});
  quantities.push_back({"collapse", FigureKind::time, "collapse to all levels"});
  for (const MeasuredMethod& method : methods)
    quantities.push_back({earned_name(method), FigureKind::time,
                          fmt::format("{}, full renders until that is earned, with contacts", method.text)});
  return quantities;
}

}  // namespace

std::vector<Measurement> coarse_measurements() {
  return {{"coarse-indirect", "CPU time of a render, over that with indirect rays on a coarser mesh", coarse_quantities(),
           measure_coarse}};
}

}  // namespace etendue
