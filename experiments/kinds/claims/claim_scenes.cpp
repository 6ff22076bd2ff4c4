#include "experiments/kinds/claims/claim_scenes.h"

#include "framework/core/rng.h"
#include "framework/io/whole_file.h"
#include "framework/scenes/meshes.h"

#include <fmt/format.h>

namespace etendue {

namespace {

constexpr std::string_view prefix = "claim:";
constexpr float span = 10;  // metres along the floor

class Random {
 public:
  explicit Random(std::uint64_t sequence) : pcg_(7, sequence) {}
  float between(float low, float high) { return low + (high - low) * pcg_.next_float(); }
  vec3 direction() {
    const float z = between(-1, 1), phi = between(0, 2 * pi), r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

 private:
  Pcg32 pcg_;
};

MeshData lone_triangle(const vec3& centre, float radius, Random& random) {
  const Frame frame = Frame::from_normal(random.direction());
  MeshData mesh;
  for (int i = 0; i < 3; ++i) {
    const float phi = 2 * pi * static_cast<float>(i) / 3;
    mesh.positions.push_back(centre + radius * (std::cos(phi) * frame.tangent + std::sin(phi) * frame.bitangent));
  }
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

// Every such scene has a floor, an area light above it and a view of both.
SceneBuilder furnished() {
  SceneBuilder b("furnished");
  const std::uint32_t grey = b.material(Diffuse{Rgb(0.6f)});
  b.mesh(quad({-span, 0, span}, {span, 0, span}, {span, 0, -span}, {-span, 0, -span}), grey);
  b.mesh(quad({-2, 8, -2}, {2, 8, -2}, {2, 8, 2}, {-2, 8, 2}), grey, Rgb(20));
  b.camera({0, 5, 12}, {0, 1.2f, 0}, 45, {256, 256});
  return b;
}

struct CountParams {
  int count = 200;
};

template <class Visitor>
void describe(Visitor& v, CountParams& p) {
  v.integer("count", p.count, 1, 1'000'000, "objects", "strewn over the floor");
}

enum class Strewn : std::uint8_t { spheres, cylinders, triangles, all };

// Sizes fall with the number, so that the floor is about as full in any case; within one scene they vary eightfold.
template <Strewn what>
Scene strewn(const CountParams& params) {
  const int count = params.count;
  SceneBuilder b = furnished();
  const std::uint32_t material = b.material(Diffuse{Rgb(0.7f, 0.5f, 0.3f)});
  Random random(1);
  const float size = std::min(1.0f, 6 / std::cbrt(static_cast<float>(count)));
  for (int i = 0; i < count; ++i) {
    const float radius = size * std::exp2(random.between(-3, 0));
    const vec3 centre(random.between(-6, 6), random.between(radius, 4), random.between(-6, 6));
    switch (what == Strewn::all ? i % 4 : static_cast<int>(what)) {
      case 0:
        b.quadric(Sphere{centre, radius}, material);
        break;
      case 1:
        b.quadric(Cylinder{centre, 0.3f * radius, random.direction(), 2 * radius, true}, material);
        break;
      case 2:
        b.mesh(lone_triangle(centre, radius, random), material);
        break;
      default:
        b.mesh(box(centre - 0.5f * radius, centre + 0.5f * radius), material);
    }
  }
  return b.finish();
}

struct ModelsParams {
  int triangles = 15'000, spheres = 5, lights = 1;
  float distance = 1;
};

template <class Visitor>
void describe(Visitor& v, ModelsParams& p) {
  v.integer("triangles", p.triangles, 100, 10'000'000, "triangles", "of the mesh, to within a percent");
  v.integer("spheres", p.spheres, 0, 1000, "spheres", "about the mesh");
  v.integer("lights", p.lights, 1, 16, "lights", "points above");
  v.number("distance", p.distance, 0.5, 100, "times", "of the eye, from where the mesh fills a fifth of the image");
}

Scene models(const ModelsParams& params) {
  SceneBuilder b("models");
  const std::uint32_t grey = b.material(Diffuse{Rgb(0.6f)});
  const float floor = span * std::max(1.0f, params.distance);
  b.mesh(quad({-floor, 0, floor}, {floor, 0, floor}, {floor, 0, -floor}, {-floor, 0, -floor}), grey);
  b.mesh(rough_ball({0, 1.5f, 0}, 1.5f, params.triangles), b.material(Diffuse{Rgb(0.7f, 0.5f, 0.3f)}));
  for (int i = 0; i < params.spheres; ++i) {
    const float phi = 2 * pi * static_cast<float>(i) / static_cast<float>(params.spheres);
    b.quadric(Sphere{{2.6f * std::cos(phi), 0.5f, 2.6f * std::sin(phi)}, 0.5f}, grey);
  }
  for (int i = 0; i < params.lights; ++i) b.light(PointLight{{4 - 8.0f * static_cast<float>(i), 7, 4}, Rgb(60)});
  b.camera(vec3(0, 1.2f, 0) + params.distance * vec3(0, 1.8f, 8), {0, 1.2f, 0}, 40, {256, 256});
  return b.finish();
}

struct BarsParams {
  int count = 200, triangles = 12;
};

template <class Visitor>
void describe(Visitor& v, BarsParams& p) {
  v.integer("count", p.count, 1, 100'000, "bars", "turned at random");
  v.integer("triangles", p.triangles, 12, 100'000, "triangles", "of a bar, at least");
}

// Eight corners make twelve triangles; more of them cut its length into slices.
MeshData bar(int triangles) {
  const int slices = std::max(1, (triangles - 4) / 8);
  MeshData mesh = box({-0.1f, -0.1f, -1}, {0.1f, 0.1f, -1 + 2.0f / static_cast<float>(slices)});
  const MeshData slice = mesh;
  for (int i = 1; i < slices; ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const vec3& p : slice.positions)
      mesh.positions.push_back(p + vec3(0, 0, 2 * static_cast<float>(i) / static_cast<float>(slices)));
    for (const uvec3& t : slice.triangles) mesh.triangles.push_back(t + first);
  }
  return mesh;
}

Scene bars(const BarsParams& params) {
  Scene scene = furnished().finish();
  const MeshData mesh = bar(params.triangles);
  Object& object = scene.objects.emplace_back();
  object.geometry.positions = mesh.positions;
  object.geometry.triangles = mesh.triangles;
  object.shapes.push_back({0, object.geometry.primitive_count(), 0, no_id, false, false, false});
  Random random(2);
  for (int i = 0; i < params.count; ++i) {
    const vec3 centre(random.between(-6, 6), random.between(0.5f, 4), random.between(-6, 6));
    const Transform turned = Transform::rotate(random.between(0, pi), random.direction());
    scene.instances.push_back({1, Transform::translate(centre) * turned * Transform::scale(vec3(0.7f))});
  }
  return scene;
}

template <class Params, Scene (*make)(const Params&)>
constexpr auto entry = scene_with_params<Params, make>;

}  // namespace

std::span<const BuiltinScene> claim_scenes() {
  static const BuiltinScene scenes[] = {
      entry<CountParams, strewn<Strewn::spheres>>(
          prefix, "spheres", "few triangles, many spheres: a floor, a light, spheres of unequal size strewn over it"),
      entry<CountParams, strewn<Strewn::cylinders>>(prefix, "cylinders", "the same with capped cylinders, turned at random"),
      entry<CountParams, strewn<Strewn::triangles>>(prefix, "triangles", "the same with single triangles"),
      entry<CountParams, strewn<Strewn::all>>(
          prefix, "objects", "the same with all three and boxes in turn: what a student's ray tracer is shown"),
      entry<ModelsParams, models>(prefix, "models", "a mesh on show, spheres about it, point lights"),
      entry<BarsParams, bars>(prefix, "bars", "instances of a bar ten times as long as thick, turned at random")};
  return scenes;
}

Scene load_claim_scene(const std::string& name, const SceneReading& reading) {
  if (!name.starts_with(prefix)) return load_scene(name, {"command line"}, reading);
  Scene scene = make_scene_of(claim_scenes(), prefix, name, {name});
  scene.name = name;
  return scene;
}

void check_claim_scene(const std::string& name, const Location& where) {
  if (name.starts_with(prefix))
    check_scene_of(claim_scenes(), prefix, name, where);
  else if (name.starts_with(builtin_prefix))
    check_builtin(name, where);
  else if (!is_file(name))
    throw Error(where,
                fmt::format("no scene '{}'; expected claim:NAME, builtin:NAME or a file in the working directory", name));
}

}  // namespace etendue
