// Camera paths: emission they meet, next-event estimation, and connections to light paths and merges with them.
#pragma once

#include "integrators/bidirectional/vcm_light_paths.h"
#include "integrators/bidirectional/vcm_merges.h"

namespace etendue {

// A camera path under way.
struct CameraWalk {
  SubPath path;
  Sampler sampler;
  std::span<const LightVertex> lights;  // of its light path
  Rgb* radiance;                        // what it gathers
  CameraTrail* trail;                   // null where weights do not ask for it
};

// Traces the camera paths of a tile together, event by event, and their shadow rays at the end.
class VcmCameraPaths {
 public:
  VcmCameraPaths(const RenderContext& context, const VcmSettings& settings, const LightPaths& light_paths,
                 const VcmMerges& merges)
      : context_(context), settings_(settings), light_paths_(light_paths), merges_(merges) {
    densities_.count_strategies(static_cast<float>(settings.paths), settings.merge_area());
  }

  // Adds what the paths of iteration `index` gather, pixel by pixel as for_pixels has them.
  void trace(const Tile& tile, std::uint32_t index, std::span<Rgb> radiance);

 private:
  // A vertex that is joined to lights and light paths, with `depth` events before it. Its light sample and its connections are
  // the next ones of their lists.
  struct Vertex {
    const SurfacePoint* point;
    vec3 wo;
    const CameraWalk* walk;
    int depth;
    bool light_sample;
    std::uint32_t connections;
  };
  struct Connection {
    const LightVertex* light;
    vec3 wi;
    float distance_squared;
  };
  struct Gain {
    Rgb* radiance;
    Rgb value;
  };
  struct Memory {
    std::vector<CameraWalk> walks;
    Wavefront<CameraWalk*> wave;
    std::vector<PathSample> paths;
    std::vector<CameraTrail> trails;  // of the paths, where weights ask for them
    // These belong to an event of the wave,
    GrowingList<Vertex> vertices;
    std::vector<LightSample> light_samples;
    GrowingList<Connection> connections;
    BsdfBatch camera_ends;  // of light samples and connections, vertex by vertex
    BsdfBatch light_ends;   // of connections
    BsdfBatch onwards;      // of the paths that meet has not ended
    // and these to the tile.
    GrowingList<Gain> gains;
    GrowingList<Ray> shadow_rays;  // of the gains
    std::vector<VcmMerges::Conditional> conditional;
  };
  static Memory& memory_of_thread() {
    static thread_local Memory memory;
    return memory;
  }

  // Counts what the point emits, which lies at ray.t_max.
  void arrive(CameraWalk& walk, const Ray& ray, const SurfacePoint& point, int depth);
  bool meet(CameraWalk& walk, Ray& ray, const SurfacePoint* met, int depth);
  // Appends a vertex to the trail.
  void follow(CameraTrail& trail, const Ray& ray, int depth, float cos_in) const;
  Rgb emitted_with_mis(const CameraWalk& walk, const Ray& ray, const SurfacePoint* point, int depth);
  void ask_joints(const SurfacePoint& point, const vec3& wo, CameraWalk& walk, int depth);
  bool ask_light_sample(const SurfacePoint& point, const vec3& wo, Sampler& sampler);
  bool ask_connection(const SurfacePoint& point, const vec3& wo, const LightVertex& light);
  void join();
  void next_event(const Vertex& vertex, const LightSample& light, const BsdfPair& pair);
  void connect(const Vertex& vertex, const Connection& connection, const BsdfPair& camera_end, const BsdfPair& light_end);
  void merge(const Vertex& vertex);
  void gain(const CameraWalk& walk, const Rgb& value, const Ray& shadow_ray);
  void finish();

  const RenderContext& context_;
  const VcmSettings& settings_;
  const LightPaths& light_paths_;
  const VcmMerges& merges_;
  Memory& memory_ = memory_of_thread();
  PathDensities densities_;
};

}  // namespace etendue
