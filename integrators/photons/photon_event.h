// A photon's event at a surface: some photons are stored, and some go on.
//
// Written over lanes (framework/core/lanes.h): one photon, or one in each lane, all at surfaces of one material. trace_by_power
// (photons.cpp) sorts a wave of photons so; integrators/lanes/ compiles this for each instruction set. Photons that are emitted
// by a chain go one by one (photon_path.h).
#pragma once

#include "framework/scene/triangle_surface.h"
#include "framework/transport/bsdf.h"
#include "framework/transport/ray_tools.h"
#include "integrators/paths/path_event.h"
#include "integrators/photons/photon_numbers.h"

namespace etendue {

// A photon under way.
struct PhotonState {
  std::uint32_t path;
  PhotonHistory history;
  Rgb power;
  PcgOf<float> random;
};

struct StoredPhoton {
  std::uint32_t path;
  vec3 position;
  Rgb power;
  vec3 from;
  float flown;
  vec3 normal;
  PhotonHistory history;
  Layer layer = 0;
};

// Says what a material means to a pass of photons.
struct PhotonRules {
  bool stores;         // photons land on the material
  bool rough;          // RoughMaterials
  PhotonHistory keep;  // what is wanted
};

// Photons of a wave that meet one material: what there is of them, and where it goes. Counts grow from what they are.
struct PhotonEvents {
  const Scene& scene;
  const void* material;  // of the kind that the function is for
  PhotonRules rules;
  bool last;          // none goes on
  bool on_triangles;  // of the world; else `points` has the surfaces
  std::span<const std::uint32_t> which;
  const PhotonState* states;
  const Ray* rays;
  const Hit* hits;
  const SurfacePoint* points;
  StoredPhoton* stored;
  std::size_t stored_count = 0;
  PhotonState* next_states;
  Ray* next_rays;
  std::size_t going_on = 0;
};

// The numbers by which a photon is emitted; its power is multiplied by `share`.
struct PhotonStart {
  EmissionNumbers numbers;
  float share;
};

// Photons of consecutive numbers that are to be emitted, and where those go that a light emits.
struct PhotonStarts {
  const LightSampler& lights;
  const PathNumbers& numbers;
  std::uint32_t first;  // number of the first
  std::span<PhotonStart> starts;
  PhotonState* states;
  Ray* rays;
  std::size_t count = 0;
};

struct PhotonKernels {
  void (*draw)(PhotonStarts& starts);  // the numbers of emission, by Sobol's sequence
  void (*emit)(PhotonStarts& starts);
  void (*meet[std::variant_size_v<Material>])(PhotonEvents& events);  // by the material's index
};
const PhotonKernels& photon_kernels_one();
#if defined(__x86_64__)
const PhotonKernels& photon_kernels_sse();
const PhotonKernels& photon_kernels_avx2();
const PhotonKernels& photon_kernels_avx512();
#endif

// Numbers that photons are scattered by.
template <class F>
struct RandomPairs {
  PcgOf<F> random;

  Vec2<F> pair() {
    const F x = random.next_float();
    return {x, random.next_float()};
  }
};

template <class F>
struct PhotonLanes {
  Vec3<F> power;
  Bits<F> history;
  RandomPairs<F> numbers;
};

// Goes on with the largest component of the power that a photon keeps, and then keeps that component ([Jensen2001]).
template <class F>
Mask<F> survives_scattering(F u, const Vec3<F>& weight, Vec3<F>& power) {
  const Vec3<F> scattered = power * weight;
  const F survival = min(F(1.0f), max_component(scattered) / max_component(power));
  power = scattered / survival;
  return u < survival;
}

// Sends photons that arrived from `from` on, and says which go. `normal`: geometric, on the side that they came from. `numbers`
// has pair(): first survival and lobe, then the direction.
template <class F, class M, class Point, class Colours, class Numbers>
Mask<F> scatter_photon(const M& material, const Point& point, const Colours& colour, const Vec3<F>& from, const Vec3<F>& normal,
                       const PhotonRules& rules, Vec3<F>& power, Bits<F>& history, Numbers& numbers, RayLanes<F>& ray) {
  const bool keeps_indirect = (rules.keep & photon_indirect) != 0;
  if (rules.rough && !material.has_specular() && !keeps_indirect) return false;
  const Vec2<F> u_choice = numbers.pair(), u = numbers.pair();
  Vec3<F> weight{0.0f}, wi = normal;
  Mask<F> general = true, ends = false;
  if constexpr (std::is_same_v<M, Diffuse>) {
    // The general case comes to this where the normals are one, with the weight known beforehand.
    general = !((point.shading_normal.x == point.normal.x) & (point.shading_normal.y == point.normal.y) &
                (point.shading_normal.z == point.normal.z));
    weight = colour(material.reflectance);
    if (!all(general)) wi = FrameOf<Vec3<F>>::from_normal(normal).to_world(sample_cosine_hemisphere(u));
    history = select(general, history, Bits<F>(photon_indirect));
  }
  if (any(general)) {
    const BsdfSampleOf<F> sample =
        place_lobes<F>(material, point, colour).sample(from, u_choice.y, u, TransportMode::importance);
    const Mask<F> specular_like = sample.specular | Mask<F>(!rules.rough);
    const Bits<F> first_caustic = select(history == Bits<F>(photon_direct), Bits<F>(photon_caustic), history);
    history = select(general, select(specular_like, first_caustic, Bits<F>(photon_indirect)), history);
    ends = is_black(sample.weight);
    weight = select(general, sample.weight, weight);
    wi = select(general, sample.wi, wi);
  }
  if (!keeps_indirect) ends = ends | (history == Bits<F>(photon_indirect));
  const Mask<F> survives = survives_scattering<F>(u_choice.x, weight, power);
  ray = {ray_origin(point, wi), wi, infinity};
  return survives & !ends;
}

template <class F, class M, class Read, class Write>
void meet_photons(PhotonEvents& events, const Read& read, const Write& write) {
  const M& material = *static_cast<const M*>(events.material);
  for (std::size_t first = 0; first < events.which.size(); first += lane_count<F>) {
    SurfaceOf<F> point;
    Vec3<F> from;
    PhotonLanes<F> photon;
    const Mask<F> active = read(first, material.uses_uvs(), point, from, photon);
    const Vec3<F> normal = select(dot(from, point.normal) < 0, -point.normal, point.normal);
    if (events.rules.stores) {
      const Mask<F> wanted = (photon.history & Bits<F>(events.rules.keep)) != Bits<F>(0u);
      write.store(first, active & wanted, point.position, photon.power, from, normal, photon.history);
    }
    if (events.last) continue;
    const auto colour = [&](const TexturedRgb& c) { return read.colour(c, point, active); };
    RayLanes<F> ray;
    const Mask<F> goes_on = scatter_photon<F>(material, point, colour, from, normal, events.rules, photon.power, photon.history,
                                              photon.numbers, ray);
    write.go_on(first, active & goes_on, photon, ray);
  }
}

}  // namespace etendue
