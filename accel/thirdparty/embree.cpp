#ifdef ETENDUE_HAS_EMBREE

#include "accel/thirdparty/embree.h"

#include "accel/kernels/primitive_test.h"
#include "framework/core/error.h"
#include "framework/core/isa.h"

#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <algorithm>
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

// Embree calls this for one ray, or for the packet that it makes of a stream.
void quadric_intersect_callback(const RTCIntersectFunctionNArguments* args) {
  RTCRayN* const rays = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* const hits = RTCRayHitN_HitN(args->rayhit, args->N);
  for (unsigned i = 0; i < args->N; ++i) {
    float t;
    vec2 uv;
    if (args->valid[i] == 0 || !test_quadric(args->geometryUserPtr, args->primID, rtcGetRayFromRayN(rays, args->N, i), t, uv))
      continue;
    RTCRayN_tfar(rays, args->N, i) = t;
    const RTCHit hit{0, 0, 0, uv.x, uv.y, args->primID, args->geomID, {args->context->instID[0]}};
    rtcCopyHitToHitN(hits, &hit, args->N, i);
  }
}

void quadric_occluded_callback(const RTCOccludedFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) {
    float t;
    vec2 uv;
    if (args->valid[i] != 0 &&
        test_quadric(args->geometryUserPtr, args->primID, rtcGetRayFromRayN(args->ray, args->N, i), t, uv))
      RTCRayN_tfar(args->ray, args->N, i) = -infinity;
  }
}

void attach(RTCDevice device, RTCScene scene, RTCGeometry geometry, unsigned id) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  check_device(device);
}

// Vertices are copied, as Embree reads beyond the last one.
void attach_triangles(RTCDevice device, RTCScene scene, const ObjectPrimitives& object, RTCBuildQuality quality) {
  if (object.triangles.empty()) return;
  const GeometryHandle geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  rtcSetGeometryBuildQuality(geometry.get(), quality);  // the scene's is not enough for the low one
  const auto& positions = object.geometry->positions;
  const auto& triangles = object.geometry->triangles;
  const std::size_t count = object.triangles.size();
  auto* const vertices = static_cast<vec3*>(
      rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(vec3), positions.size()));
  if (count == triangles.size()) {
    rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0, sizeof(uvec3),
                               count);
  } else {
    auto* const indices = static_cast<uvec3*>(
        rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(uvec3), count));
    check_device(device);
    for (std::size_t i = 0; i < count; ++i) indices[i] = triangles[object.triangles[i]];
  }
  check_device(device);
  std::copy(positions.begin(), positions.end(), vertices);
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

// Counts the bytes that Embree holds. It is called before Embree allocates, and can refuse.
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

RTCRayHit to_ray_hit(const Ray& ray) {
  RTCRayHit ray_hit;
  ray_hit.ray = to_embree(ray);
  ray_hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  ray_hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return ray_hit;
}

RTCIntersectContext new_context(RTCIntersectContextFlags flags) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = flags;
  return context;
}

// A ray of a stream which Embree skips (t_min above t_max).
Ray skipped_ray() { return {vec3(0), 1, vec3(0, 0, 1), 0}; }

// `ask` hands Embree one stream after the other, of what `convert` makes of the rays; `take` is given each ray's answer.
template <class Asked, class Ask, class Take>
void in_streams(std::span<const Ray> rays, RTCIntersectContextFlags flags, Asked (*convert)(const Ray&), const Ask& ask,
                const Take& take) {
  constexpr std::size_t stream_size = 256;  // their 20 KiB stay in the first-level cache
  Asked stream[stream_size];
  for (std::size_t begin = 0; begin < rays.size(); begin += stream_size) {
    const std::size_t size = std::min(stream_size, rays.size() - begin);
    for (std::size_t i = 0; i < size; ++i)
      stream[i] = convert(is_within_embree(rays[begin + i]) ? rays[begin + i] : skipped_ray());
    RTCIntersectContext context = new_context(flags);
    ask(&context, stream, static_cast<unsigned>(size));
    for (std::size_t i = 0; i < size; ++i) take(begin + i, stream[i]);
  }
}

}  // namespace

struct Embree::State {
  Allotted allotted;
  Device device;
  std::vector<ObjectPrimitives> objects;
  std::vector<SceneHandle> scenes;  // by object, then the top level where there are instances
  std::vector<std::uint32_t> object_of_instance;
  bool in_streams;
  RTCIntersectContextFlags stream_flags;

  State(const Scene& scene, const EmbreeParams& params);
  void build(const Scene& scene, const EmbreeParams& params);
  SceneHandle new_scene(const EmbreeParams& params) const;
  RTCScene root() const { return (object_of_instance.empty() ? scenes.front() : scenes.back()).get(); }
  Hit to_hit(const RTCRayHit& answer) const;
};

Hit Embree::State::to_hit(const RTCRayHit& answer) const {
  const RTCHit& hit = answer.hit;
  if (hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  const std::uint32_t instance = object_of_instance.empty() ? 0 : hit.instID[0];
  const ObjectPrimitives& object = objects[object_of_instance.empty() ? 0 : object_of_instance[instance]];
  const auto& ids = hit.geomID == triangles_id ? object.triangles : object.quadrics;
  return {answer.ray.tfar, {hit.u, hit.v}, instance, ids[hit.primID]};
}

SceneHandle Embree::State::new_scene(const EmbreeParams& params) const {
  SceneHandle handle(rtcNewScene(device.get()));
  check_device(device.get());
  rtcSetSceneBuildQuality(handle.get(), build_quality(params.quality));
  if (params.robust) rtcSetSceneFlags(handle.get(), RTC_SCENE_FLAG_ROBUST);
  return handle;
}

namespace {

// It takes no instruction that we leave out: it needs SSE2 at least.
std::string device_config() {
  return fmt::format("max_isa={}", chosen_isa() == Isa::scalar ? "sse2"
                                   : chosen_isa() == Isa::sse  ? "sse4.2"
                                                               : isa_option(chosen_isa()));
}

}  // namespace

Embree::State::State(const Scene& scene, const EmbreeParams& params)
    : device(rtcNewDevice(device_config().c_str())),
      in_streams(params.batches != "single" && !scene.has_instances()),
      stream_flags(params.batches == "coherent" ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT) {
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
  RTCIntersectContext context = new_context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  RTCRayHit ray_hit = to_ray_hit(ray);
  rtcIntersect1(state_->root(), &context, &ray_hit);
  return state_->to_hit(ray_hit);
}

bool Embree::occluded(const Ray& ray) const {
  if (!is_within_embree(ray)) return false;
  RTCIntersectContext context = new_context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
  RTCRay embree_ray = to_embree(ray);
  rtcOccluded1(state_->root(), &context, &embree_ray);
  return embree_ray.tfar < 0;
}

void Embree::closest(std::span<const Ray> rays, std::span<Hit> hits) const {
  if (!state_->in_streams) {
    for (std::size_t i = 0; i < rays.size(); ++i) hits[i] = closest(rays[i]);
    return;
  }
  const auto ask = [&](RTCIntersectContext* context, RTCRayHit* stream, unsigned size) {
    rtcIntersect1M(state_->root(), context, stream, size, sizeof(RTCRayHit));
  };
  in_streams(rays, state_->stream_flags, to_ray_hit, ask,
             [&](std::size_t i, const RTCRayHit& answer) { hits[i] = state_->to_hit(answer); });
}

void Embree::occluded(std::span<const Ray> rays, std::span<bool> occluded) const {
  if (!state_->in_streams) {
    for (std::size_t i = 0; i < rays.size(); ++i) occluded[i] = this->occluded(rays[i]);
    return;
  }
  const auto ask = [&](RTCIntersectContext* context, RTCRay* stream, unsigned size) {
    rtcOccluded1M(state_->root(), context, stream, size, sizeof(RTCRay));
  };
  in_streams(rays, state_->stream_flags, to_embree, ask,
             [&](std::size_t i, const RTCRay& answer) { occluded[i] = answer.tfar < 0; });
}

RayStructureStats Embree::stats() const { return {static_cast<std::uint64_t>(state_->allotted.bytes.load()), 0, 0, 0, 0}; }

}  // namespace etendue

#endif
