#ifdef ETENDUE_HAS_EMBREE

#include "accel/ray/embree.h"

#include "framework/core/error.h"
#include "framework/scene/intersect.h"

#include <embree3/rtcore.h>

#include <atomic>

namespace etendue {

static_assert(RayStructure<Embree>);

namespace {

template <class Handle, void (*release)(Handle)>
struct Releaser {
  using pointer = Handle;
  void operator()(Handle handle) const { release(handle); }
};
using Device = std::unique_ptr<RTCDevice, Releaser<RTCDevice, rtcReleaseDevice>>;
using SceneHandle = std::unique_ptr<RTCScene, Releaser<RTCScene, rtcReleaseScene>>;
using GeometryHandle = std::unique_ptr<RTCGeometry, Releaser<RTCGeometry, rtcReleaseGeometry>>;

void check_device(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE) throw Error("Embree failed with error code " + std::to_string(error));
}

// An object's valid primitives: Embree's numbers to ours, per kind.
struct ObjectPrimitives {
  const Geometry* geometry;
  std::vector<std::uint32_t> triangles, quadrics;
};

// Geometry ids within the scene of an object.
constexpr unsigned triangles_id = 0, quadrics_id = 1;

void quadric_bounds_callback(const RTCBoundsFunctionArguments* args) {
  const auto& object = *static_cast<const ObjectPrimitives*>(args->geometryUserPtr);
  const Bounds b = object.geometry->primitive_bounds(object.quadrics[args->primID]);
  *args->bounds_o = {b.lower.x, b.lower.y, b.lower.z, 0, b.upper.x, b.upper.y, b.upper.z, 0};
}

bool test_quadric(const void* user, unsigned primitive, const RTCRay& r, float& t, vec2& uv) {
  const auto& object = *static_cast<const ObjectPrimitives*>(user);
  const Ray ray{{r.org_x, r.org_y, r.org_z}, r.tnear, {r.dir_x, r.dir_y, r.dir_z}, r.tfar};
  return intersect_quadric(ray, object.geometry->quadric(object.quadrics[primitive]), r.tfar, t, uv);
}

// Single rays only (N = 1): no packet query is ever made.
void quadric_intersect_callback(const RTCIntersectFunctionNArguments* args) {
  auto& ray_hit = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  float t;
  vec2 uv;
  if (args->valid[0] == 0 || !test_quadric(args->geometryUserPtr, args->primID, ray_hit.ray, t, uv)) return;
  ray_hit.ray.tfar = t;
  ray_hit.hit.u = uv.x;
  ray_hit.hit.v = uv.y;
  ray_hit.hit.geomID = args->geomID;
  ray_hit.hit.primID = args->primID;
  ray_hit.hit.instID[0] = args->context->instID[0];
}

void quadric_occluded_callback(const RTCOccludedFunctionNArguments* args) {
  auto& ray = *reinterpret_cast<RTCRay*>(args->ray);
  float t;
  vec2 uv;
  if (args->valid[0] != 0 && test_quadric(args->geometryUserPtr, args->primID, ray, t, uv)) ray.tfar = -infinity;
}

void attach(RTCDevice device, RTCScene scene, RTCGeometry geometry, unsigned id) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  check_device(device);
}

void attach_triangles(RTCDevice device, RTCScene scene, const ObjectPrimitives& object, RTCBuildQuality quality) {
  if (object.triangles.empty()) return;
  const GeometryHandle geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  rtcSetGeometryBuildQuality(geometry.get(), quality);  // the scene's is not enough for the low one
  const auto& positions = object.geometry->positions;
  auto* const vertices = static_cast<vec3*>(
      rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(vec3), positions.size()));
  auto* const indices = static_cast<uvec3*>(rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                    sizeof(uvec3), object.triangles.size()));
  check_device(device);
  std::copy(positions.begin(), positions.end(), vertices);
  for (std::size_t i = 0; i < object.triangles.size(); ++i) indices[i] = object.geometry->triangles[object.triangles[i]];
  attach(device, scene, geometry.get(), triangles_id);
}

void attach_quadrics(RTCDevice device, RTCScene scene, ObjectPrimitives& object) {
  if (object.quadrics.empty()) return;
  const GeometryHandle geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER));
  rtcSetGeometryUserPrimitiveCount(geometry.get(), static_cast<unsigned>(object.quadrics.size()));
  rtcSetGeometryUserData(geometry.get(), &object);
  rtcSetGeometryBoundsFunction(geometry.get(), quadric_bounds_callback, nullptr);
  rtcSetGeometryIntersectFunction(geometry.get(), quadric_intersect_callback);
  rtcSetGeometryOccludedFunction(geometry.get(), quadric_occluded_callback);
  attach(device, scene, geometry.get(), quadrics_id);
}

void attach_instance(RTCDevice device, RTCScene scene, RTCScene object, const Transform& to_world, unsigned id) {
  const GeometryHandle geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE));
  rtcSetGeometryInstancedScene(geometry.get(), object);
  const vec3 columns[4] = {to_world.vector({1, 0, 0}), to_world.vector({0, 1, 0}), to_world.vector({0, 0, 1}),
                           to_world.point({0, 0, 0})};
  rtcSetGeometryTransform(geometry.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
  attach(device, scene, geometry.get(), id);
}

RTCBuildQuality build_quality(const std::string& name) {
  return name == "low" ? RTC_BUILD_QUALITY_LOW : name == "high" ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM;
}

// What Embree holds. Asked before it takes more, it can be refused.
struct Allotted {
  std::atomic<std::int64_t> bytes = 0;
  std::atomic<bool> refused = false;
  const MemoryWatch* watch = nullptr;
};

bool count_bytes(void* user, ssize_t bytes, bool done) {
  auto& allotted = *static_cast<Allotted*>(user);
  const std::int64_t sum = allotted.bytes += bytes;
  if (done || bytes <= 0 || allotted.watch == nullptr || allotted.watch->allows(static_cast<std::uint64_t>(sum))) return true;
  allotted.bytes -= bytes;
  allotted.refused = true;
  return false;
}

// Embree ends the program at a ray beyond its own range.
bool is_within_embree(const Ray& ray) {
  constexpr float largest = 1.844e18f;  // FLT_LARGE in Embree's common/math/constants.h
  const auto within = [](const vec3& v) {
    return std::abs(v.x) <= largest && std::abs(v.y) <= largest && std::abs(v.z) <= largest;
  };
  return within(ray.origin) && within(ray.direction) && ray.direction != vec3(0) && ray.t_min <= ray.t_max;
}

RTCRay to_embree(const Ray& ray) {
  return {ray.origin.x,
          ray.origin.y,
          ray.origin.z,
          ray.t_min,
          ray.direction.x,
          ray.direction.y,
          ray.direction.z,
          0,
          ray.t_max,
          ~0u,
          0,
          0};
}

}  // namespace

struct Embree::State {
  Allotted allotted;
  Device device;
  std::vector<ObjectPrimitives> objects;
  std::vector<SceneHandle> scenes;  // by object, then the top level where there are instances
  std::vector<std::uint32_t> object_of_instance;

  State(const Scene& scene, const EmbreeParams& params);
  void build(const Scene& scene, const EmbreeParams& params);
  SceneHandle new_scene(const EmbreeParams& params) const;
  RTCScene root() const { return (object_of_instance.empty() ? scenes.front() : scenes.back()).get(); }
};

SceneHandle Embree::State::new_scene(const EmbreeParams& params) const {
  SceneHandle handle(rtcNewScene(device.get()));
  check_device(device.get());
  rtcSetSceneBuildQuality(handle.get(), build_quality(params.quality));
  if (params.robust) rtcSetSceneFlags(handle.get(), RTC_SCENE_FLAG_ROBUST);
  return handle;
}

Embree::State::State(const Scene& scene, const EmbreeParams& params) : device(rtcNewDevice(nullptr)) {
  if (!device) throw Error("Embree failed with error code " + std::to_string(rtcGetDeviceError(nullptr)));
  allotted.watch = params.watch;
  rtcSetDeviceMemoryMonitorFunction(device.get(), count_bytes, &allotted);
  try {
    build(scene, params);
  } catch (const Error&) {
    if (allotted.refused) throw OverMemory();
    throw;
  }
  allotted.watch = nullptr;  // it need not outlive the build
}

void Embree::State::build(const Scene& scene, const EmbreeParams& params) {
  objects.reserve(scene.objects.size());  // their addresses are given to Embree
  for (const Object& object : scene.objects) {
    ObjectPrimitives& primitives = objects.emplace_back(ObjectPrimitives{&object.geometry, {}, {}});
    for (const std::uint32_t id : object.geometry.valid_primitives())
      (object.geometry.is_triangle(id) ? primitives.triangles : primitives.quadrics).push_back(id);
    scenes.push_back(new_scene(params));
    attach_triangles(device.get(), scenes.back().get(), primitives, build_quality(params.quality));
    attach_quadrics(device.get(), scenes.back().get(), primitives);
    rtcCommitScene(scenes.back().get());
  }
  if (scene.has_instances()) {
    SceneHandle top = new_scene(params);
    for (std::uint32_t id = 0; id < scene.instances.size(); ++id) {
      const Instance& instance = scene.instances[id];
      object_of_instance.push_back(instance.object);
      attach_instance(device.get(), top.get(), scenes[instance.object].get(), instance.to_world, id);
    }
    rtcCommitScene(top.get());
    scenes.push_back(std::move(top));
  }
  check_device(device.get());
}

Embree::Embree(const Scene& scene, const EmbreeParams& params) : state_(std::make_shared<const State>(scene, params)) {}

Hit Embree::closest(const Ray& ray) const {
  if (!is_within_embree(ray)) return {};
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray_hit;
  ray_hit.ray = to_embree(ray);
  ray_hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray_hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(state_->root(), &context, &ray_hit);
  const RTCHit& hit = ray_hit.hit;
  if (hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const std::uint32_t instance = state_->object_of_instance.empty() ? 0 : hit.instID[0];
  const ObjectPrimitives& object =
      state_->objects[state_->object_of_instance.empty() ? 0 : state_->object_of_instance[instance]];
  const auto& ids = hit.geomID == triangles_id ? object.triangles : object.quadrics;
  return {ray_hit.ray.tfar, {hit.u, hit.v}, instance, ids[hit.primID]};
}

bool Embree::occluded(const Ray& ray) const {
  if (!is_within_embree(ray)) return false;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay embree_ray = to_embree(ray);
  rtcOccluded1(state_->root(), &context, &embree_ray);
  return embree_ray.tfar < 0;
}

RayStructureStats Embree::stats() const { return {static_cast<std::uint64_t>(state_->allotted.bytes.load()), 0, 0, 0, 0}; }

}  // namespace etendue

#endif
