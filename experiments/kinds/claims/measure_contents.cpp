// The time that a scene is spared if it lacks a thing: time with that thing in it over time without.
//
// Each thing is added where it changes what the code must do and next to nothing of the image: a sphere below the floor makes
// the leaves ask of every primitive what it is, an infinite plane below it is asked of every ray, an object placed apart puts a
// second level above the first, a faint light makes each vertex choose. A scene that has the thing already gives no figure for
// it.
#include "experiments/config/method.h"
#include "experiments/kinds/claims/measurement.h"
#include "experiments/kinds/second_level.h"
#include "experiments/run/run_cell.h"

#include <map>

namespace etendue {

namespace {

// A thing that a scene may hold.
struct Content {
  const char* name;
  const char* text;
  bool (*held)(const SceneNeeds& needs);
  void (*add)(Scene& scene);
  const char* method = "path";  // whose time it costs, in images
};

// Such is the name of what takes no thing in.
std::string bare_name(const std::string& method) { return "bare " + method; }

// Below what the bounds hold, by a hundredth of their diagonal.
vec3 beneath(const Bounds& bounds) {
  const vec3 centre = bounds.centre();
  return {centre.x, bounds.lower.y - 0.01f * glm::length(bounds.diagonal()), centre.z};
}
vec3 beneath(const Scene& scene) { return beneath(scene.bounds()); }
float small_size(const Bounds& bounds) { return 0.001f * glm::length(bounds.diagonal()); }

Bounds primitive_bounds(const Geometry& geometry) {
  Bounds bounds;
  for (std::uint32_t id = 0; id < geometry.primitive_count(); ++id) bounds.extend(geometry.primitive_bounds(id));
  return bounds;
}

void add_sphere(Object& object, const Sphere& sphere, std::uint32_t material) {
  const auto shape = static_cast<std::uint32_t>(object.shapes.size());
  object.shape_of.resize(object.geometry.primitive_count(), 0);
  object.shapes.push_back({.first_primitive = object.geometry.primitive_count(), .primitive_count = 1, .material = material});
  object.geometry.quadrics.push_back(sphere);
  object.shape_of.push_back(shape);
}

// One in each object that holds anything, instances' too: it is their leaves that then ask of every primitive what it is.
void add_spheres(Scene& scene) {
  for (Object& object : scene.objects)
    if (const Bounds bounds = primitive_bounds(object.geometry); !bounds.empty())
      add_sphere(object, {beneath(bounds), small_size(bounds)}, 0);
}

void add_plane(Scene& scene) { scene.planes.push_back({beneath(scene), {0, 1, 0}, 0}); }

void add_instance(Scene& scene) { scene = with_second_level(scene); }

void add_light(Scene& scene) { scene.lights.push_back(PointLight{beneath(scene), Rgb(1e-6f)}); }

void add_environment(Scene& scene) {
  scene.lights.push_back(EnvironmentLight{.scale = Rgb(1e-6f), .size = ivec2(0), .texels = {}, .light_to_world = {}});
}

// Every diffuse colour comes from an image of one texel then.
void add_textures(Scene& scene) {
  for (Material& material : scene.materials) {
    auto* diffuse = std::get_if<Diffuse>(&material);
    if (!diffuse || !diffuse->reflectance.is_constant()) continue;
    scene.textures.push_back(ImageTexture{.size = ivec2(1), .texels = {diffuse->reflectance.constant}});
    diffuse->reflectance.texture = static_cast<std::uint32_t>(scene.textures.size() - 1);
  }
}

// Each vertex gets the mean of its triangles' normals.
void add_normals(Scene& scene) {
  for (Object& object : scene.objects) {
    const Geometry& geometry = object.geometry;
    object.normals.assign(geometry.positions.size(), vec3(0));
    for (const uvec3& v : geometry.triangles) {
      const vec3 a = geometry.positions[v.x];
      const vec3 normal = glm::cross(geometry.positions[v.y] - a, geometry.positions[v.z] - a);
      for (int i = 0; i < 3; ++i) object.normals[v[i]] += normal;
    }
    for (vec3& normal : object.normals)
      if (const float length = glm::length(normal); length > 0) normal /= length;
    for (Shape& shape : object.shapes) shape.has_normals = geometry.is_triangle(shape.first_primitive);
  }
}

void add_lens(Scene& scene) { scene.camera.lens_radius = 1e-6f; }

// A mirror small enough to be met by next to no photon: the caustic map is there, and nearly empty.
void add_mirror(Scene& scene) {
  const auto material = static_cast<std::uint32_t>(scene.materials.size());
  const Bounds bounds = scene.bounds();
  add_sphere(scene.objects[0], {bounds.centre(), small_size(bounds)}, material);
  scene.materials.emplace_back(Conductor{.ideal = true});
}

const Content in_rays[] = {
    {"quadrics", "rays, a sphere beside the triangles over triangles alone", [](const SceneNeeds& n) { return n.quadrics; },
     add_spheres},
    {"planes", "rays, an infinite plane over none", [](const SceneNeeds& n) { return n.planes; }, add_plane},
    {"instances", "rays, an instance (two levels) over none (one level)", [](const SceneNeeds& n) { return n.two_levels; },
     add_instance}};

const Content in_images[] = {
    {"lights", "path tracing, a second light to choose from over one", [](const SceneNeeds& n) { return n.light_choice; },
     add_light},
    {"environment", "path tracing, a light at infinity over none", [](const SceneNeeds& n) { return n.environment; },
     add_environment},
    {"textures", "path tracing, colours from textures over constants", [](const SceneNeeds& n) { return n.textures; },
     add_textures},
    {"normals", "path tracing, vertex normals over flat triangles", [](const SceneNeeds& n) { return n.shading_normals; },
     add_normals},
    {"lens", "path tracing, a lens over a pinhole", [](const SceneNeeds& n) { return n.thin_lens; }, add_lens},
    {"specular", "photon cache, a tiny mirror ball, hence a caustic map, over none",
     [](const SceneNeeds& n) { return n.caustic_map; }, add_mirror, "photon-cache"}};

std::vector<const Content*> absent(std::span<const Content> contents, const SceneNeeds& needs) {
  std::vector<const Content*> kept;
  for (const Content& content : contents)
    if (!content.held(needs)) kept.push_back(&content);
  return kept;
}

// Rays that what was added stops have another answer, and should.
bool is_added(const Scene& bare, const Hit& hit) {
  return hit && (hit.instance == plane_instance || hit.instance >= bare.instances.size() ||
                 hit.primitive >= bare.objects[bare.instances[hit.instance].object].geometry.primitive_count());
}
bool agree(const Scene& scene, const Hit& bare, const Hit& with) {
  return is_added(scene, with) || (bare.t == with.t && bare.primitive == with.primitive);
}

// Makes the bare scene, and beside it one with each content that it lacks.
std::vector<Scene> scenes_of(const Scene& bare, const std::vector<const Content*>& contents) {
  std::vector<Scene> scenes{bare};
  for (const Content* content : contents) content->add(scenes.emplace_back(bare));
  return scenes;
}

void measure_in_rays(Trial& t) {
  const TrialRays rays = t.record_rays();
  const std::vector<const Content*> contents = absent(in_rays, scene_needs(t.scene));
  const std::vector<Scene> scenes = scenes_of(t.scene, contents);
  const Method accel = default_accel();
  std::vector<std::unique_ptr<RayQuery>> structures;
  std::vector<Contender> contenders;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    structures.push_back(find_ray_structure(accel.name, {}).make(scenes[i], accel.params));
    const RayQuery &bare = *structures.front(), &with = *structures.back();
    for (const Ray& ray : rays.closest) t.disagree(!agree(t.scene, bare.closest(ray), with.closest(ray)));
    contenders.push_back({i == 0 ? bare_name("path") : contents[i - 1]->name, tracing_all(with, rays, Clock::thread)});
  }
  t.race(contenders);
}

// The time of a few iterations and of what prepares them, without the building of the ray structure.
double render_seconds(const Scene& scene, const std::string& method, const MeasureTask& task) {
  const Budget budget{.samples = 2};
  const SceneNeeds needs = scene_needs(scene);
  const Method accel = default_accel(), integrator{method, {}, {}};
  CellTask cell{scene, needs, accel, integrator, task.seed, ivec2(task.resolution), budget, 1};
  double begin = 0, end = 0;
  cell.before_prepare = [&](Integrator&, RenderContext&) { begin = now_s(Clock::thread); };
  cell.finished = [&](Integrator&, RenderContext&, const CellResult&) { end = now_s(Clock::thread); };
  run_cell(cell);
  return end - begin;
}

void measure_in_images(Trial& t) {
  const std::vector<const Content*> contents = absent(in_images, scene_needs(t.scene));
  const std::vector<Scene> scenes = scenes_of(t.scene, contents);
  std::map<std::string, Contender> contenders;  // by name
  const auto add = [&](const std::string& name, const Scene& scene, const std::string& method) {
    contenders[name] = {name, [&scene, &t, method] { return render_seconds(scene, method, t.task); }};
  };
  for (std::size_t i = 0; i < contents.size(); ++i) {
    add(contents[i]->name, scenes[i + 1], contents[i]->method);
    add(bare_name(contents[i]->method), t.scene, contents[i]->method);
  }
  t.race(values_of(contenders));
}

std::vector<Quantity> quantities_of(std::span<const Content> contents) {
  return mapped(contents, [](const Content& content) {
    return Quantity{content.name, FigureKind::factor, content.text, content.name, bare_name(content.method)};
  });
}

}  // namespace

std::vector<Measurement> content_measurements() {
  return {{"contents-in-rays", "CPU time of rays with a thing in the scene over that without it", quantities_of(in_rays),
           measure_in_rays},
          {"contents-in-images", "CPU time of a render with a thing in the scene over that without it",
           quantities_of(in_images), measure_in_images}};
}

}  // namespace etendue
