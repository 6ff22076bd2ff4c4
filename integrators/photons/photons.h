// Photons: emitted by the lights, traced through the scene, stored where surfaces receive them ([Jensen1996]).
//
// A lobe is *specular-like* if it is a delta lobe, or narrower than a roughness threshold, so that no density estimate of a few
// hundred photons could resolve its reflection; a surface without other lobes is a specular-like vertex of a path. All others
// are *rough* vertices (diffuse ones are the roughest): photons are stored there. By what happened before it landed a photon is
//
//   direct    nothing                             L R
//   caustic   specular-like events only           L C+ R
//   indirect  a rough event at least              L (C|R)* R C* R
//
// and a map states which of the three it holds, so that nothing is counted twice.
//
// A narrow rough lobe has *tails*: directions whose density is below the peak of the narrowest lobe that would be gathered.
// Kernels resolve the tails as well as they resolve rough vertices, whereas a camera path that follows the lobe rarely goes
// there, and may then find light a thousand times as bright (through a door, say). So on request photons are stored on
// such surfaces too; camera paths follow the lobe's core and gather its lobe tails. This partition is by direction alone, as
// that of [Jensen1996] is by material; integrators/bidirectional/vcm.h weights both strategies everywhere.
//
// Photon i of a pass is a function of (seed, pass, i) alone. Chunks of fixed size are traced in parallel and joined in order,
// so the arrays are the same, bit for bit, at any number of threads. Russian roulette follows [Jensen2001]: a photon survives
// with the largest component of its power it would keep, and keeps that component.
//
// Photons are emitted in proportion to the lights' power, or where they matter (PhotonEmission): a VisibleRegion tells where
// they will be gathered.
//
//   power        all of the same power, wherever they go
//   importance   by a guide over the numbers of emission, learned from a quarter of the paths (emission/emission_guide.h).
//                Photons that are rare where they are not expected to matter are strong in turn; unbiased everywhere
//   visibility   paths that store a photon in the region and no others, by Markov chains, all of about the same power
//                (emission/photon_chains.h). Unbiased within the region; outside of it light is missing
#pragma once

#include "framework/integrator.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace etendue {

// Bits, so that a set of histories is a mask.
using PhotonHistory = std::uint8_t;
inline constexpr PhotonHistory photon_direct = 1, photon_caustic = 2, photon_indirect = 4, photon_any = 7;

// The geometric normal of the side a photon came from, in steps of 1/127, its history, and the layer that it landed on.
struct PhotonSide {
  std::int8_t x = 0, y = 0, z = 0;
  PhotonHistory history : 3 = 0;
  Layer layer : 5 = 0;

  PhotonSide() = default;
  PhotonSide(const vec3& normal, PhotonHistory history, Layer layer = 0);

  vec3 normal() const { return vec3(x, y, z) * (1.0f / 127); }
  bool same_normal(const PhotonSide& other) const { return x == other.x && y == other.y && z == other.z; }
  bool operator==(const PhotonSide&) const = default;
};

struct Photons {
  std::vector<vec3> position;
  std::vector<Rgb> power;       // W, divided by the number emitted
  std::vector<vec3> direction;  // unit, to where the photon came from
  std::vector<float> flown;     // metres, on its last way
  std::vector<PhotonSide> side;
  std::vector<std::uint16_t> scatterings;  // before it landed; 65535 stands for all above

  std::size_t size() const { return position.size(); }
  bool empty() const { return position.empty(); }
  void add(const vec3& at, const Rgb& watts, const vec3& from, float way, const vec3& normal_from, PhotonHistory history,
           int events, Layer layer = 0);
  void append(const Photons& more);
  void reserve(std::size_t count);
  void clear();
  bool operator==(const Photons&) const = default;

  // body(pointer to member) for each of the arrays.
  template <class Body>
  static void for_each_field(const Body& body) {
    body(&Photons::position);
    body(&Photons::power);
    body(&Photons::direction);
    body(&Photons::flown);
    body(&Photons::side);
    body(&Photons::scatterings);
  }
};

// All parts, one after the other.
Photons joined(std::vector<Photons> parts);

// Photons order[0], order[1], ...: for locality, see `along_curve`.
Photons reordered(Photons photons, std::span<const std::uint32_t> order);

// Ids in the order of a Morton curve through 2048 x 2048 x 1024 cells of the points' bounds, ties by id.
std::vector<std::uint32_t> along_curve(std::span<const vec3> points);

// The middle one, of two the upper; reorders the values.
inline float median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// How the tails of a narrow rough lobe are treated.
enum class LobeTails : std::uint8_t { followed, gathered };
constexpr auto names_of(LobeTails) { return std::array{"followed", "gathered"}; }

template <class Visitor>
void describe_carry_below(Visitor& v, float& carry_below) {
  v.number("carry_below", carry_below, 0, 1, "GGX alpha",
           "rough lobes narrower than this are followed, not gathered (of glass whose index is within a quarter of 1, alpha "
           "times four times that distance counts); but for coats on which caustics of delta lights fall");
}

// Which materials receive photons, by index. `narrow`: GGX alpha below which a rough lobe is specular-like.
class RoughMaterials {
 public:
  RoughMaterials(const Scene& scene, float narrow, LobeTails lobe_tails = LobeTails::followed, bool gathers_coats = false);
  bool operator()(std::uint32_t material) const { return kinds_[material] == Kind::rough; }
  // Does the material have a narrow rough lobe, whose tails are gathered?
  bool has_tails(std::uint32_t material) const { return kinds_[material] == Kind::tails; }
  bool stores(std::uint32_t material) const { return kinds_[material] != Kind::specular_like; }
  // Is there a narrow rough lobe?
  bool narrow_lobes() const { return narrow_lobes_; }
  // Density of a BSDF over solid angle, 1/sr, below which directions are lobe tails.
  float tail_density() const { return tail_density_; }

 private:
  enum class Kind : std::uint8_t { specular_like, tails, rough };

  std::vector<Kind> kinds_;
  bool narrow_lobes_ = false;
  float tail_density_;
};

// Are plastics gathered at, however narrow their coats? Where the caustics of lights that no ray can meet may fall on them:
// those on the diffuse base are found by photons alone.
bool gathers_coats(const RenderContext& context);

// The expectation of a method that follows narrow rough lobes, once it knows the scene. Light of lights that no ray can meet,
// which comes to such a lobe by way of specular surfaces, is found by photons alone: on the lobes of metals and frosted glass,
// where none are gathered, it is left out.
Expectation expectation_in(const RenderContext& context, const RoughMaterials& rough_materials, Expectation expected);

enum class PhotonEmission : std::uint8_t { power, importance, visibility };
constexpr auto names_of(PhotonEmission) { return std::array{"power", "importance", "visibility"}; }

class VisibleRegion;

struct PhotonPass {
  std::uint32_t count = 0;  // paths to trace, pilots and rejected ones included
  std::uint64_t key = 0;    // passes of different keys are independent
  int max_scatterings = 0;  // at most this many events before landing
  PhotonHistory keep = photon_any;
  SamplerKind sampler = SamplerKind::sobol;
  PhotonEmission emission = PhotonEmission::power;
  const VisibleRegion* visible = nullptr;  // for the other emissions; null: photons matter everywhere
};

// Paths end early once no photon of a kept history can follow.
Photons trace_photons(const RenderContext& context, const RoughMaterials& rough_materials, const PhotonPass& pass);

}  // namespace etendue
