// Light paths: traced from the lights, each vertex joined to the lens (a splat) and, where wanted, kept to be joined to.
//
// Paths come in chunks of fixed size, which are traced together, event by event. Each has its own lists: vertices in the order
// of its paths, splats in the order of their events. Nothing depends on the threads.
#pragma once

#include "integrators/bidirectional/vcm_paths.h"

#include <span>
#include <vector>

namespace etendue {

// The vertices of a light path, delta lobes included; kept for weights that ask for them.
struct LightTrail {
  TrailLight light;
  std::vector<TrailVertex> vertices;

  Trail part(int events) const { return Trail(vertices).first(static_cast<std::size_t>(events)); }
};

struct LightVertex {
  SurfacePoint point;
  vec3 wo;      // unit, to where the light came from
  float flown;  // metres, from there
  Rgb power;    // W that arrives, for one path in total
  MisPartials mis{};
  std::int32_t events = 0;  // scattering events up to and with this vertex
  float opacity = 1;        // of its surface, there: the share of light paths that it stops
  const LightTrail* trail = nullptr;
};

class LightPaths {
 public:
  // All paths of an iteration. Vertices with no lobe that could be joined to are left out; `keep` false keeps none.
  void trace(const RenderContext& context, const VcmSettings& settings, std::uint32_t iteration, bool keep);

  std::span<const LightVertex> path(std::uint32_t index) const;
  // All vertices, path by path.
  std::vector<const LightVertex*> vertices() const;
  // Adds what the paths send to each pixel to its mean radiance.
  void add_splats(std::span<dvec3> pixels) const;

 private:
  static constexpr std::uint32_t chunk_size = 1024;

  struct Splat {
    std::uint32_t pixel;
    Rgb value;
  };
  struct Found {
    std::uint32_t path;  // of the chunk
    LightVertex vertex;
  };
  struct Chunk {
    std::vector<LightVertex> vertices;
    std::vector<std::uint32_t> path_end;  // into vertices
    std::vector<Splat> splats;
    std::vector<LightTrail> trails;  // of the paths, where weights ask for them
  };

  class Tracer;

  std::vector<Chunk> chunks_;
};

}  // namespace etendue
