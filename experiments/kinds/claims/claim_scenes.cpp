#include "experiments/kinds/claims/claim_scenes.h"

#include "framework/core/rng.h"
#include "framework/io/load_scene.h"
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

// A floor, an area light above it and a view of both.
SceneBuilder furnished(const std::string& name) {
  SceneBuilder b(name);
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
Scene strewn(const std::string& name, Strewn what, int count) {
  SceneBuilder b = furnished(name);
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

Scene models(const std::string& name, const ModelsParams& params) {
  SceneBuilder b(name);
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

Scene bars(const std::string& name, const BarsParams& params) {
  Scene scene = furnished(name).finish();
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

// "key=value,…" behind the question mark.
ParamMap parse_params(const std::string& name, const Location& where) {
  ParamMap params;
  const std::size_t question = name.find('?');
  for (std::size_t begin = question; begin != std::string::npos && begin < name.size();) {
    const std::size_t end = std::min(name.find(',', begin + 1), name.size());
    const std::string pair = name.substr(begin + 1, end - begin - 1);
    const std::size_t equals = pair.find('=');
    if (equals == std::string::npos)
      throw Error(where, fmt::format("'{}': '{}': expected key=value, as in claim:spheres?count=500", name, pair));
    params[pair.substr(0, equals)] = parse_param_value(pair.substr(equals + 1), where);
    begin = end;
  }
  return params;
}

template <class Params, class Make>
ClaimScene scene_entry(const char* name, const char* summary, const Make& make) {
  return {name, summary, list_params<Params>(),
          [](const std::string& whole, const ParamMap& map) { read_params<Params>(map, whole); },
          [make](const std::string& whole, const ParamMap& map) { return make(whole, read_params<Params>(map, whole)); }};
}

ClaimScene strewn_entry(const char* name, const char* summary, Strewn what) {
  return scene_entry<CountParams>(
      name, summary, [what](const std::string& whole, const CountParams& params) { return strewn(whole, what, params.count); });
}

const ClaimScene& find_claim_scene(const std::string& name, const Location& where) {
  const std::string kind = name.substr(prefix.size(), name.find('?') - prefix.size());
  std::vector<std::string> names;
  for (const ClaimScene& scene : claim_scenes()) {
    if (scene.name == kind) return scene;
    names.push_back(scene.name);
  }
  throw Error(where, unknown_name("scene", kind, names));
}

}  // namespace

std::span<const ClaimScene> claim_scenes() {
  static const std::vector<ClaimScene> scenes{
      strewn_entry("spheres", "few triangles, many spheres: a floor, a light, spheres of unequal size strewn over it",
                   Strewn::spheres),
      strewn_entry("cylinders", "the same with capped cylinders, turned at random", Strewn::cylinders),
      strewn_entry("triangles", "the same with single triangles", Strewn::triangles),
      strewn_entry("objects", "the same with all three and boxes in turn: what a student's ray tracer is shown", Strewn::all),
      scene_entry<ModelsParams>("models", "a mesh on show, spheres about it, point lights", models),
      scene_entry<BarsParams>("bars", "instances of a bar ten times as long as thick, turned at random", bars)};
  return scenes;
}

Scene load_claim_scene(const std::string& name, const SceneReading& reading) {
  if (!name.starts_with(prefix)) return load_scene(name, {"command line"}, reading);
  return find_claim_scene(name, {name}).make(name, parse_params(name, {name}));
}

void check_claim_scene(const std::string& name, const Location& where) {
  if (name.starts_with(prefix))
    find_claim_scene(name, where).check(name, parse_params(name, where));
  else if (name.starts_with(builtin_prefix))
    check_builtin(name, where);
  else if (!is_file(name))
    throw Error(where,
                fmt::format("no scene '{}'; expected claim:NAME, builtin:NAME or a file in the working directory", name));
}

}  // namespace etendue
