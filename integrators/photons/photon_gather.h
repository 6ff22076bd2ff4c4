// A map of photons and the radiance estimated from it ([Jensen1996], [Jensen2001]).
//
// Photons arrive in proportion to irradiance, cosine included, so the estimate is sum f_r power K(d) without a further N.L.
//
// With k > 0 the k-th nearest photon sets the kernel's radius and is itself not counted: of independent photons this is
// unbiased at uniform density for any normalised kernel ((k - 1) / (pi r_k^2) for the box, relative variance 1 / (k - 2)),
// where counting it gives the k / (k - 1) of the textbook. Where a low-discrepancy sequence spreads photons evenly, as those of
// a point or the sun on a floor, the k-th lies farther off: the box is up to 1 / (2 k - 1) too dark, other kernels a few tenths
// of that. The search stops at a largest radius; fewer than k photons there are counted all, over the disc of that radius, and
// the mixture is unbiased still: with n ~ Poisson, E = density (P(n >= k - 1) + P(n <= k - 2)). With k = 0 the radius is fixed.
//
// With `widen`, a disc of fixed radius takes the place of that over the k nearest where photons lie evenly: it holds about 4.5
// k, whose noise is less, and no kernel has bias there. [Schregle2003] lets the number of photons grow as long as the change of
// the estimate passes for noise. Here moments decide, which do not depend on the estimate (disc_moments.h). They decide once
// for each block of photons along the curve, by the 8 k photons about its middle, since that costs less than at every look-up.
// A point takes the least radius of the blocks of its k nearest photons whose middle it lies near, if all of these pass, all k
// photons count and no wall is near: at borders and in sharp caustics the k nearest stay. What is bright by chance passes as
// often as what is dark, and photons are few that do not pass, so that even light keeps its mean. Unevenness that 8 k photons
// do not tell from chance (ripples finer than the disc, a border at its rim) is blurred as by the wider disc. Of that the inner
// sqrt(share) counts, so that its blur vanishes, too, but later: even light has none, and less noise.
//
// What stays is the bias of the kernel's width: smooth irradiance blurs by kappa r^2 laplacian(E) (kappa = 1/8 box, 1/12
// Epanechnikov, 3/40 cone), and within r of an edge the part of the disc off the surface is missing (one half at the edge):
// against which there are the remedies of integrators/photons/kernel_domain.h.
#pragma once

#include "framework/transport/bsdf.h"
#include "framework/transport/ray_tools.h"
#include "integrators/photons/density_kernel.h"
#include "integrators/photons/photons.h"
#include "integrators/photons/wall_grid.h"

#include <memory>

namespace etendue {

// Says what the photons are divided by: the whole disc, the part the point sees, or the photons' hull.
enum class Edges : std::uint8_t { disc, visible, hull };
constexpr auto names_of(Edges) { return std::array{"disc", "visible", "hull"}; }

struct GatherOptions {
  int k = 50;
  float radius = 0;  // metres; with k the largest radius of the search; 0: from the photons' own density
  Kernel kernel = Kernel::epanechnikov;
  bool side_test = true;  // refuse photons that arrived on another side than the one that is looked at, or past a wall
  float largest_radius = infinity;  // metres; bounds a radius that is found from the photons' density
  Edges edges = Edges::disc;
  float share = 1;  // of the disc so found, about the same middle, which photons must lie in to count
  float alone = 1;  // metres: the radius about a photon that has no other
  // The map is new in every iteration. With k > 0 discs are wider where photons lie evenly, and their visible part is looked
  // for where photons are not far sparser than usual, and used if it is no mere sliver.
  bool widen = false;
};

// Photons under a kernel: the first `count` of the neighbours, over a disc of squared radius `radius_squared`.
struct KernelDisc {
  std::size_t count = 0;
  float radius_squared = 0;

  float shape(Kernel kernel, float distance_squared) const { return kernel_shape(kernel, distance_squared / radius_squared); }
  float per_area() const { return radius_squared > 0 ? inv_pi / radius_squared : 0; }
};

// k nearest within `radius` (k > 0), or all within `radius`. `out` is the caller's buffer. With a `share` below 1 only those in
// the disc's inner part of that area: at even density they are as many of the disc's photons on the mean, so that this is
// unbiased where the whole disc is.
KernelDisc find_disc(const PointQuery& query, const vec3& position, int k, float radius, Neighbours& out, float share = 1);

// A point that photons are gathered at: which of them count there, and what it reflects of each towards wo.
class GatherPoint {
 public:
  // Photons of the given histories count, with at most `max_scatterings` events behind them. Only directions of a BSDF density
  // below `tail_density` (1/sr) are reflected: a lobe's tails, or all.
  GatherPoint(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, PhotonHistory histories, int max_scatterings,
              float tail_density = infinity);

  // Irradiance on the side of unit `normal`, by photons with at most `max_scatterings` events behind them, which are reflected
  // as they are.
  // `origin`: of rays that leave to that side.
  static GatherPoint irradiance(const vec3& position, const vec3& normal, const vec3& origin, int max_scatterings = 65535,
                                PhotonHistory histories = photon_any);

  const vec3& position() const { return position_; }
  const vec3& normal() const { return normal_; }  // geometric, on the side that is gathered at: that of wo, but for of_side
  // The same point of a surface that lets light through, for the photons of one side: that of wo or the other.
  GatherPoint of_side(bool behind) const;
  bool transmits() const { return transmits_; }
  bool is_behind() const { return is_behind_; }
  bool of_caustics() const { return histories_ == photon_caustic; }  // alone, which hulls are not for (kernel_domain.h)
  bool of_tails() const { return tail_density_ < infinity; }
  // A diffuse surface's; others, which reflect by direction, have 1.
  Rgb albedo() const { return bsdf_ != nullptr && bsdf_->is_diffuse() ? bsdf_->diffuse_albedo() : Rgb(1); }
  // Corners and the far side of thin walls fail the side test; a side is the same up to 84 degrees, so that curved surfaces
  // pass. Where the BSDF is evaluated, it refuses light from behind unless the surface lets it through. What landed on another
  // layer counts there alone.
  bool counts(const Photons& photons, std::uint32_t id, bool side_test) const {
    const PhotonSide side = photons.side[id];
    if (!(side.history & histories_) || photons.scatterings[id] > longest_) return false;
    if (!share_light(side.layer, layer_)) return false;
    const float facing = side_test ? glm::dot(side.normal(), normal_) : 1;
    if (!((transmits_ ? std::abs(facing) : facing) >= 0.1f)) return false;
    return !of_tails() || bsdf_->pdf(wo_, photons.direction[id]) < tail_density_;
  }
  // The way to a photon that counts, if a wall may stand on it. Photons on the far side of a surface that lets light through
  // are looked at from there.
  std::optional<Ray> way_to(const Photons& photons, const Neighbour& photon, const NearWalls& walls) const {
    const auto& [id, distance_squared] = photon;
    const bool same_side = !transmits_ || glm::dot(photons.side[id].normal(), normal_) > 0;
    const auto end = [&] {
      return before_landing(photons.position[id], photons.direction[id], photons.flown[id], std::sqrt(distance_squared));
    };
    if (same_side && !walls.may_hide(photons.position[id], end)) return std::nullopt;
    return segment(same_side ? origin_ : far_origin_, end());
  }
  const vec3& origin() const { return origin_; }
  Layer layer() const { return layer_; }
  // f_r times the power of a photon that counts.
  Rgb reflected(const Photons& photons, std::uint32_t id) const {
    if (constant_) return photons.power[id] * constant_reflectance_;
    // Over the cosine that made photons as dense as they are, the geometric one where each landed: on another facet of a curved
    // surface the point's own may be far smaller, which made such surfaces too bright. `evaluate` has the shading one, as path
    // tracing does. Photons know their normals to 0.3 degrees only; those of the point's own plane have its exact one, or flat
    // surfaces would be off by a constant under slanting light.
    const vec3& wi = photons.direction[id];
    const PhotonSide& side = photons.side[id];
    const bool same_plane = side.same_normal(front_) || side.same_normal(back_);
    const float cosine = std::abs(glm::dot(wi, same_plane ? normal_ : glm::normalize(side.normal())));
    return photons.power[id] * bsdf_->evaluate(wo_, wi) / std::max(cosine, same_plane ? least_exact_cosine : least_cosine);
  }

 private:
  static constexpr float least_cosine = 0.02f;        // lest the rounding of a photon's normal be divided out
  static constexpr float least_exact_cosine = 1e-5f;  // rays along the surface

  GatherPoint() = default;

  const Bsdf* bsdf_ = nullptr;  // null: constant
  vec3 position_;
  vec3 wo_, normal_;
  vec3 origin_, far_origin_;  // of rays to either side
  bool transmits_ = false, is_behind_ = false;
  PhotonSide front_, back_;  // of normal_, as photons know it
  PhotonHistory histories_;
  Layer layer_ = 0;
  bool constant_;  // f_r is the same for every direction
  std::int32_t longest_;
  float tail_density_ = infinity;
  Rgb constant_reflectance_;
};

// Holds what a photon makes a point reflect (f_r times power, in W/sr), and where the photon lies, seen from there.
struct GatheredPhoton {
  Rgb reflected;
  vec3 offset;
  float distance_squared;
};

class PhotonMap {
 public:
  // Takes the photons along a space-filling curve and builds `query` over them.
  void build(Photons photons, std::unique_ptr<PointQuery> query, const GatherOptions& options);
  void set_edges(Edges edges) { options_.edges = edges; }
  // With them, photons that the side test lets pass are refused where a wall hides them.
  void set_walls(std::shared_ptr<const WallGrid> walls) { walls_ = std::move(walls); }

  // Holds what `estimate` finds, and within which radius.
  struct Estimate {
    Rgb radiance{0};
    float radius = 0;            // metres; 0: there are no photons
    float photon_footprint = 0;  // area per photon, m^2
  };

  // Radiance towards wo that photons of the given histories, with at most `max_scatterings` events behind them, make the
  // surface reflect.
  Rgb radiance(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
               PhotonHistory histories, int max_scatterings, float tail_density = infinity) const;
  // The same, of the photons that count at the point.
  Rgb estimate(const RenderContext& context, const GatherPoint& at) const { return measure(context, at).radiance; }
  Estimate measure(const RenderContext& context, const GatherPoint& at) const;

  // Calls visit(GatheredPhoton, way) for every photon within `radius` and `off_plane` (metres) of the point's tangent plane
  // that counts. Where a wall may hide it there is a way (std::optional<Ray>): it counts if nothing blocks that. The sum of
  // what they reflect, each times kernel_shape over pi radius^2, is the radiance.
  template <class Visit>
  void gather(const GatherPoint& at, float radius, float off_plane, const Visit& visit) const {
    if (photons_.empty()) return;
    const Neighbours& near = within(at.position(), radius);
    if (near.empty()) return;
    const NearWalls walls = near_walls(at, radius);
    const bool open = walls.none();
    for (const Neighbour& photon : near) {
      const vec3 offset = photons_.position[photon.id] - at.position();
      if (!(std::abs(glm::dot(offset, at.normal())) <= off_plane) || !at.counts(photons_, photon.id, options_.side_test))
        continue;
      visit(GatheredPhoton{at.reflected(photons_, photon.id), offset, photon.distance_squared},
            open ? std::nullopt : at.way_to(photons_, photon, walls));
    }
  }

  // Calls visit(direction, reflected) for those of the k nearest photons, within the radius of the search, that count at the
  // point: where each came from, and what it makes the point reflect.
  template <class Visit>
  void visit_nearest(const GatherPoint& at, int k, const Visit& visit) const {
    for (const auto& [id, distance_squared] : nearest(at.position(), k))
      if (at.counts(photons_, id, options_.side_test)) visit(photons_.direction[id], at.reflected(photons_, id));
  }

  // Distance to the k-th nearest photon that counts at the point, or `r_max` where there are fewer. `guess`: a radius that may
  // hold so many, which saves time and changes no answer; 0: none is known.
  float distance_to(const RenderContext& context, int k, const GatherPoint& at, float r_max, float guess = 0) const;

  std::size_t size() const { return photons_.size(); }
  const Photons& photons() const { return photons_; }  // along a curve
  float radius() const { return radius_; }             // the fixed one, or the largest of the search
  // The walls that may hide photons within the radius of a point.
  NearWalls near_walls(const vec3& position, const vec3& normal, float radius) const {
    return walls_ ? walls_->near(position, normal, radius) : NearWalls();
  }
  NearWalls near_walls(const GatherPoint& at, float radius) const { return near_walls(at.position(), at.normal(), radius); }

 private:
  // Those of the photons that count at the point and that no wall hides from it, in their order.
  std::span<Neighbour> counting(const RenderContext& context, const GatherPoint& at, std::span<const Neighbour> near,
                                const NearWalls& walls) const;
  // The answer lies in a buffer of this thread.
  const Neighbours& within(const vec3& position, float radius) const;
  const Neighbours& nearest(const vec3& position, int k) const;
  float automatic_radius() const;
  std::size_t block_size() const { return static_cast<std::size_t>(options_.k) * 8 / 5; }
  void find_even_discs();  // about a photon of each block of that size
  // The radius of a disc about the point in which photons lie evenly; 0 where those nearest to it tell of none.
  float even_radius(const GatherPoint& at, std::span<const Neighbour> nearest) const;
  bool tells_edges(const GatherPoint& at, float radius) const;
  Rgb over_hull(const GatherPoint& at, std::span<const Neighbour> near, const KernelDisc& disc) const;

  Photons photons_;
  PhotonHistory held_ = 0;  // histories that photons have
  std::unique_ptr<PointQuery> query_;
  std::shared_ptr<const WallGrid> walls_;
  GatherOptions options_;
  float radius_ = 0;
  float sparse_ = infinity;         // a disc's radius beyond which hardly any light is lost at edges
  std::vector<float> even_radius_;  // about each block of photons along the curve, negative where they lie unevenly
};

}  // namespace etendue
