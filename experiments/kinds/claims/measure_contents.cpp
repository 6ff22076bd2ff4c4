// What a scene is spared that lacks a thing: time with that thing in it over time without.
//
// Each thing is added where it changes what the code must do and next to nothing of the image: a sphere below the floor makes
// the leaves ask of every primitive what it is, an infinite plane below it is asked of every ray, an object placed apart puts a
// second level above the first, a faint light makes each vertex choose. A scene that has the thing already gives no figure for
// it.
#include "experiments/config/method.h"
#include "experiments/kinds/claims/claim_scenes.h"
#include "experiments/kinds/claims/measure_tools.h"
#include "experiments/run/run_cell.h"

#include <ctime>
#include <map>

namespace etendue {

namespace {

using FigureKind::factor;

// A thing that a scene may hold.
struct Content {
  const char* name;
  const char* text;
  bool (*held)(const SceneNeeds& needs);
  void (*add)(Scene& scene);
  const char* method = "path";  // whose time it costs
};

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

void add_instance(Scene& scene) {
  Object object;
  const float size = small_size(scene.bounds());
  object.geometry.positions = {vec3(0), vec3(size, 0, 0), vec3(0, 0, size)};
  object.geometry.triangles = {{0, 1, 2}};
  object.shapes = {{.first_primitive = 0, .primitive_count = 1}};
  scene.instances.push_back({static_cast<std::uint32_t>(scene.objects.size()), Transform::translate(beneath(scene))});
  scene.objects.push_back(std::move(object));
}

void add_light(Scene& scene) { scene.lights.push_back(PointLight{beneath(scene), Rgb(1e-6f)}); }

void add_environment(Scene& scene) {
  scene.lights.push_back(EnvironmentLight{.scale = Rgb(1e-6f), .size = ivec2(0), .texels = {}, .light_to_world = {}});
}

// Every diffuse colour from an image of one texel.
void add_textures(Scene& scene) {
  for (Material& material : scene.materials) {
    auto* diffuse = std::get_if<Diffuse>(&material);
    if (!diffuse || !diffuse->reflectance.is_constant()) continue;
    scene.textures.push_back(ImageTexture{.size = ivec2(1), .texels = {diffuse->reflectance.constant}});
    diffuse->reflectance.texture = static_cast<std::uint32_t>(scene.textures.size() - 1);
  }
}

// At each vertex the mean of its triangles' normals.
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
    {"specular", "photon map, a tiny mirror ball, hence a caustic map, over none",
     [](const SceneNeeds& n) { return n.caustic_map; }, add_mirror, "photon-map"}};

// Seconds of this process: what else the machine does at the time is left out. All that is timed here runs on one thread.
double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

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

MeasureResult measure_in_rays(const MeasureTask& task) {
  const Scene bare = load_claim_scene(task.scene, task.reading);
  const ClaimRays rays = record_claim_rays(bare, task.resolution);
  const std::vector<const Content*> contents = absent(in_rays, scene_needs(bare));
  const Method accel = default_accel();
  std::vector<Scene> scenes{bare};  // all of them before the structures, which refer to them
  for (const Content* content : contents) content->add(scenes.emplace_back(bare));
  std::vector<std::unique_ptr<RayQuery>> structures;
  for (const Scene& scene : scenes) structures.push_back(make_structure(scene, accel.name, accel.params));
  MeasureResult result;
  for (const auto& structure : structures)
    for (const Ray& ray : rays.closest)
      result.disagreements += !agree(bare, structures[0]->closest(ray), structure->closest(ray));
  std::vector<std::vector<double>> seconds(structures.size());
  for (int repetition = 0; repetition < task.repetitions; ++repetition) {
    for (std::size_t turn = 0; turn < structures.size(); ++turn) {
      const std::size_t i = (turn + static_cast<std::size_t>(repetition)) % structures.size();  // none is always first
      const double begin = cpu_seconds();
      trace_rays(*structures[i], rays);
      seconds[i].push_back(cpu_seconds() - begin);
    }
    task.progress((repetition + 1.0) / task.repetitions);
  }
  for (std::size_t i = 0; i < contents.size(); ++i) result.add(contents[i]->name, ratio_of(seconds[i + 1], seconds[0]));
  return result;
}

// The time of a few iterations and of what prepares them, without the building of the ray structure.
double render_seconds(const Scene& scene, const std::string& method, const MeasureTask& task) {
  Budget budget;
  budget.samples = 2;
  const SceneNeeds needs = scene_needs(scene);
  const Method accel = default_accel(), integrator{method, {}, {}};
  CellTask cell{scene, needs, accel, integrator, task.seed, ivec2(task.resolution), budget, 1};
  double begin = 0, end = 0;
  cell.before_prepare = [&](Integrator&, RenderContext&) { begin = cpu_seconds(); };
  cell.finished = [&](Integrator&, RenderContext&, const CellResult&) { end = cpu_seconds(); };
  run_cell(cell);
  return end - begin;
}

MeasureResult measure_in_images(const MeasureTask& task) {
  const Scene bare = load_claim_scene(task.scene, task.reading);
  MeasureResult result;
  const std::vector<const Content*> contents = absent(in_images, scene_needs(bare));
  std::vector<Scene> scenes;
  for (const Content* content : contents) content->add(scenes.emplace_back(bare));
  std::map<std::string, std::vector<double>> without;  // by method
  std::vector<std::vector<double>> with(contents.size());
  for (int repetition = 0; repetition < task.repetitions; ++repetition) {
    for (const Content* content : contents) without[content->method];
    const auto bare_ones = [&] {
      for (auto& [method, seconds] : without) seconds.push_back(render_seconds(bare, method, task));
    };
    if (repetition % 2 == 0) bare_ones();
    for (std::size_t i = 0; i < contents.size(); ++i) with[i].push_back(render_seconds(scenes[i], contents[i]->method, task));
    if (repetition % 2 == 1) bare_ones();
    task.progress((repetition + 1.0) / task.repetitions);
  }
  for (std::size_t i = 0; i < contents.size(); ++i)
    result.add(contents[i]->name, ratio_of(with[i], without[contents[i]->method]));
  return result;
}

std::vector<Quantity> quantities_of(std::span<const Content> contents) {
  std::vector<Quantity> quantities;
  for (const Content& content : contents) quantities.push_back({content.name, factor, content.text});
  return quantities;
}

}  // namespace

std::vector<Measurement> content_measurements() {
  return {{"contents-in-rays", "CPU time of rays with a thing in the scene over that without it", quantities_of(in_rays),
           measure_in_rays},
          {"contents-in-images", "CPU time of a render with a thing in the scene over that without it",
           quantities_of(in_images), measure_in_images}};
}

}  // namespace etendue
