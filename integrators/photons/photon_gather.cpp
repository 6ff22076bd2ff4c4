#include "integrators/photons/photon_gather.h"

#include "framework/core/counters.h"
#include "framework/core/parallel.h"
#include "integrators/photons/disc_moments.h"
#include "integrators/photons/kernel_domain.h"

#include <algorithm>
#include <optional>

namespace etendue {

KernelDisc find_disc(const PointQuery& query, const vec3& position, int k, float radius, Neighbours& out, float share) {
  if (k == 0) {
    const float inner = radius * std::sqrt(share);
    query.within(position, inner, out);
    return {out.size(), inner * inner};
  }
  query.nearest(position, static_cast<std::size_t>(k), radius, out);
  KernelDisc disc{out.size(), radius * radius};
  if (out.size() >= static_cast<std::size_t>(k)) disc = {out.size() - 1, out.back().distance_squared};
  if (share == 1) return disc;
  disc.radius_squared *= share;
  const auto inside = [&](const Neighbour& n) { return n.distance_squared < disc.radius_squared; };
  disc.count = static_cast<std::size_t>(std::ranges::partition_point(out, inside) - out.begin());  // the nearest come first
  return disc;
}

void PhotonMap::build(Photons photons, std::unique_ptr<PointQuery> query, const GatherOptions& options) {
  query_ = std::move(query);
  const std::vector<std::uint32_t> order = along_curve(photons.position);
  photons_ = reordered(std::move(photons), order);
  options_ = options;
  held_ = 0;
  for (const PhotonSide& side : photons_.side) held_ |= side.history;
  query_->build(photons_.position);
  const float automatic = options.radius > 0 ? infinity : automatic_radius();
  radius_ = options.radius > 0 ? options.radius : std::min(automatic, options.largest_radius);
  // Where photons are a sixth as dense as usual; in a right-angled corner they are a quarter.
  constexpr float of_automatic = 0.6f;
  sparse_ = options.widen && options.k > 0 ? of_automatic * automatic : infinity;
  even_radius_.clear();
  if (options.widen && options.k > 0 && !photons_.empty()) find_even_discs();
}

// The median distance at which photons have k photons about them (50 for a fixed radius); as a bound for the search four times
// that, which only regions with a sixteenth of the usual density reach. Where there are fewer than k it is no bound but the
// kernel's radius.
float PhotonMap::automatic_radius() const {
  constexpr std::size_t probes = 256;
  if (photons_.empty()) return 1;
  const auto k = std::min<std::size_t>(options_.k > 0 ? options_.k : 50, photons_.size());
  std::vector<float> distances(std::min(probes, photons_.size()));
  parallel_for(distances.size(), 8, [&](std::size_t i) {
    static thread_local Neighbours neighbours;
    query_->nearest(photons_.position[i * photons_.size() / distances.size()], k, infinity, neighbours);
    distances[i] = std::sqrt(neighbours.back().distance_squared);
  });
  const float usual = median(distances);
  if (!(usual > 0)) return options_.alone;
  const bool is_bound = options_.k > 0 && static_cast<std::size_t>(options_.k) <= photons_.size();
  return usual * (is_bound ? 4 : 1);
}

namespace {

constexpr float least_share = 0.1f;  // of a disc: of a thinner sliver one photon would outshine all others

// A photon of the block along the curve, whose place stands for it.
std::size_t middle_of(std::size_t block, std::size_t size, std::size_t photons) {
  return std::min(block * size + size / 2, photons - 1);
}

}  // namespace

void PhotonMap::find_even_discs() {
  constexpr float too_uneven = 20;  // exceeded by one in 800 discs of even light
  constexpr float inner = 0.75f;    // of the radius that is tested, whose middle is not the point
  const std::size_t tested = 8 * static_cast<std::size_t>(options_.k);
  even_radius_.assign(photons_.size() / block_size() + 1, 0);
  parallel_for(even_radius_.size(), 8, [&](std::size_t block) {
    static thread_local Neighbours near;
    const std::size_t middle = middle_of(block, block_size(), photons_.size());
    const vec3& position = photons_.position[middle];
    const vec3 normal = glm::normalize(photons_.side[middle].normal());
    const GatherPoint at = GatherPoint::irradiance(position, normal, position);
    query_->nearest(position, tested, 2 * radius_, near);
    if (near.size() < tested) return;
    const float radius_squared = near.back().distance_squared;
    DiscMoments moments(normal, radius_squared);
    for (const auto& [id, distance_squared] : near)
      if (id != middle && at.counts(photons_, id, options_.side_test))
        moments.add(photons_.power[id], photons_.position[id] - position, distance_squared);
    const float radius = std::min(inner * std::sqrt(radius_squared), radius_);
    even_radius_[block] = moments.unevenness() < too_uneven ? radius : -radius;
  });
}

float PhotonMap::even_radius(const GatherPoint& at, std::span<const Neighbour> nearest) const {
  if (even_radius_.empty() || nearest.size() < static_cast<std::size_t>(options_.k)) return 0;
  float radius = infinity;
  for (const auto& [id, distance_squared] : nearest) {
    if (!at.counts(photons_, id, options_.side_test)) return 0;
    const std::size_t block = id / block_size();
    const vec3& middle = photons_.position[middle_of(block, block_size(), photons_.size())];
    // The curve jumps: a block whose middle is far away tells nothing of this place.
    if (length_squared(middle - at.position()) < square(even_radius_[block])) radius = std::min(radius, even_radius_[block]);
  }
  const bool even = radius > 0 && radius < infinity && square(radius) > nearest.back().distance_squared;
  return even && near_walls(at, radius).none() ? radius : 0;
}

GatherPoint::GatherPoint(const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo, PhotonHistory histories,
                         int max_scatterings, float tail_density)
    : bsdf_(&bsdf),
      position_(point.position),
      wo_(wo),
      normal_(glm::dot(wo, point.normal) < 0 ? -point.normal : point.normal),
      front_(normal_, 0),
      back_(-normal_, 0),
      histories_(histories),
      layer_(point.layer),
      constant_(bsdf.is_diffuse() && point.shading_normal == point.normal),
      longest_(std::min(max_scatterings, 65535)),
      tail_density_(tail_density),
      constant_reflectance_(constant_ ? bsdf.diffuse_albedo() * inv_pi : Rgb(0)) {
  origin_ = ray_origin(point, normal_);
  transmits_ = bsdf.transmits();
  if (transmits_) far_origin_ = ray_origin(point, -normal_);
}

GatherPoint GatherPoint::of_side(bool behind) const {
  GatherPoint at = *this;
  at.transmits_ = false;
  at.is_behind_ = behind;
  if (!behind) return at;
  at.normal_ = -normal_;
  at.origin_ = far_origin_;
  std::swap(at.front_, at.back_);
  return at;
}

GatherPoint GatherPoint::irradiance(const vec3& position, const vec3& normal, const vec3& origin, int max_scatterings,
                                    PhotonHistory histories) {
  GatherPoint at;
  at.position_ = position;
  at.origin_ = origin;
  at.wo_ = at.normal_ = normal;
  at.histories_ = histories;
  at.constant_ = true;
  at.longest_ = std::min(max_scatterings, 65535);
  at.constant_reflectance_ = Rgb(1);
  return at;
}

Rgb PhotonMap::radiance(const RenderContext& context, const SurfacePoint& point, const Bsdf& bsdf, const vec3& wo,
                        PhotonHistory histories, int max_scatterings, float tail_density) const {
  if (max_scatterings < 0 || !(held_ & histories)) return Rgb(0);
  return estimate(context, GatherPoint(point, bsdf, wo, histories, max_scatterings, tail_density));
}

// Where a map is new in every iteration, ends of discs are not looked for where rays would tell them badly: on sheets that let
// some rays through, and where rounding is not small beside the disc.
bool PhotonMap::tells_edges(const GatherPoint& at, float radius) const {
  return !options_.widen || (!lets_light_through(at.layer()) && radius > 20 * clearance_of(at.position(), radius));
}

PhotonMap::Estimate PhotonMap::measure(const RenderContext& context, const GatherPoint& at) const {
  if (photons_.empty()) return {};
  const bool ends_at_walls = options_.edges == Edges::visible || (options_.edges == Edges::hull && !at.of_caustics());
  if (at.transmits() && options_.side_test && ends_at_walls) {
    Estimate near = measure(context, at.of_side(false));  // walls stand on either side of a sheet for themselves
    near.radiance += measure(context, at.of_side(true)).radiance;
    return near;
  }
  static thread_local Neighbours neighbours;
  // Fewer than k in all: those within the radius, which need not be brought into order.
  const bool whole = static_cast<std::size_t>(options_.k) > photons_.size();
  KernelDisc disc = find_disc(*query_, at.position(), whole ? 0 : options_.k, radius_, neighbours, options_.share);
  const bool dense = disc.radius_squared <= options_.share * square(sparse_);
  if (const float wide = even_radius(at, neighbours); wide > 0)
    disc = find_disc(*query_, at.position(), 0, wide, neighbours, std::sqrt(options_.share));
  count(Counter::photons_gathered, disc.count);
  const float radius = std::sqrt(disc.radius_squared);
  const float photon_footprint = disc.count > 0 ? pi * disc.radius_squared / static_cast<float>(disc.count) : 0;
  if (disc.count == 0 || !(disc.radius_squared > 0)) return {Rgb(0), radius};
  const NearWalls walls = near_walls(at, radius);
  const std::span<const Neighbour> near = counting(context, at, {neighbours.data(), disc.count}, walls);
  if (options_.edges == Edges::hull && !at.of_caustics()) return {over_hull(at, near, disc), radius, photon_footprint};
  std::optional<VisibleDomain> domain;
  if (options_.edges == Edges::visible && !near.empty() && dense && tells_edges(at, radius))
    domain.emplace(context, at.position(), at.normal(), radius, walls_ && walls.none());
  float share = domain && !domain->is_disc() ? domain->share(options_.kernel) : 1;
  if (options_.widen && share < least_share) share = 1;
  if (share == 1) domain.reset();
  Rgb sum(0);
  for (const auto& [id, distance_squared] : near)
    if (!domain || domain->contains(photons_.position[id] - at.position()))
      sum += at.reflected(photons_, id) * disc.shape(options_.kernel, distance_squared);
  return {sum * (disc.per_area() / share), radius, photon_footprint};
}

// The hull of a few photons does not tell where the surface ends: then the whole disc is used.
Rgb PhotonMap::over_hull(const GatherPoint& at, std::span<const Neighbour> near, const KernelDisc& disc) const {
  constexpr std::size_t fewest = 8;
  static thread_local std::vector<Rgb> reflected;
  static thread_local std::vector<vec2> positions;
  reflected.clear();
  positions.clear();
  const Frame frame = Frame::from_normal(at.normal());
  Rgb sum(0);
  for (const auto& [id, distance_squared] : near) {
    reflected.push_back(at.reflected(photons_, id) * disc.shape(options_.kernel, distance_squared));
    positions.push_back(in_tangent_plane(frame, photons_.position[id] - at.position()));
    sum += reflected.back();
  }
  if (positions.size() < fewest) return sum * disc.per_area();
  const PhotonHull hull(positions);
  for (const std::uint32_t corner : hull.corners()) sum -= reflected[corner];
  const float share = hull.share(options_.kernel, std::sqrt(disc.radius_squared));
  return share > 0 ? glm::max(sum, Rgb(0)) * (disc.per_area() / share) : Rgb(0);
}

std::span<Neighbour> PhotonMap::counting(const RenderContext& context, const GatherPoint& at, std::span<const Neighbour> near,
                                         const NearWalls& walls) const {
  static thread_local Neighbours kept;
  static thread_local std::vector<Ray> ways;
  static thread_local std::vector<std::size_t> asked;  // the places in `kept` of those that ways lead to
  kept.clear();
  ways.clear();
  asked.clear();
  for (const Neighbour& photon : near) {
    if (!at.counts(photons_, photon.id, options_.side_test)) continue;
    if (!walls.none())
      if (const auto way = at.way_to(photons_, photon, walls)) {
        if (!context.needs.masks) {
          asked.push_back(kept.size());
          ways.push_back(*way);
        } else if (!sees_landed(context, *way, photons_.position[photon.id])) {
          continue;
        }
      }
    kept.push_back(photon);
  }
  if (ways.empty()) return kept;
  static thread_local std::vector<std::uint8_t> hidden;  // by place in `kept`
  hidden.assign(kept.size(), 0);
  for (const std::size_t place : asked) hidden[place] = 1;
  for_unoccluded(context, ways, [&](std::size_t i) { hidden[asked[i]] = 0; });
  std::size_t seen = 0;
  for (std::size_t place = 0; place < kept.size(); ++place)
    if (hidden[place] == 0) kept[seen++] = kept[place];
  kept.resize(seen);
  return kept;
}

const Neighbours& PhotonMap::within(const vec3& position, float radius) const {
  static thread_local Neighbours neighbours;
  query_->within(position, radius, neighbours);
  count(Counter::photons_gathered, neighbours.size());
  return neighbours;
}

const Neighbours& PhotonMap::nearest(const vec3& position, int k) const {
  static thread_local Neighbours neighbours;
  neighbours.clear();
  if (!photons_.empty()) query_->nearest(position, static_cast<std::size_t>(k), radius_, neighbours);
  count(Counter::photons_gathered, neighbours.size());
  return neighbours;
}

// Balls of growing radius until one holds enough that count: behind a thin wall may lie thousands that do not, which would all
// be among the nearest. Of those on the right side the nearest are looked at first, in groups that double, so that many which
// a wall hides cost no more than to sort them.
float PhotonMap::distance_to(const RenderContext& context, int k, const GatherPoint& at, float r_max, float guess) const {
  if (photons_.empty() || k < 1) return r_max;
  static thread_local Neighbours on_side;
  // A radius of zero would not grow.
  const float first = std::max(guess > 0 ? guess : 0.25f * radius_, std::numeric_limits<float>::min());
  const auto nearer = [](const Neighbour& a, const Neighbour& b) { return a.distance_squared < b.distance_squared; };
  for (float r = std::min(r_max, first);; r = std::min(r_max, 1.6f * r)) {
    const Neighbours& found = within(at.position(), r);
    on_side.clear();
    for (const Neighbour& photon : found)
      if (at.counts(photons_, photon.id, options_.side_test)) on_side.push_back(photon);
    const NearWalls walls = near_walls(at, r);
    std::ptrdiff_t missing = k, group = k;
    for (auto begin = on_side.begin(); on_side.end() - begin >= missing; group *= 2) {
      const auto end = begin + std::min(group, on_side.end() - begin);
      std::nth_element(begin, end - 1, on_side.end(), nearer);
      const std::span<Neighbour> seen = counting(context, at, {begin, end}, walls);
      const auto count = static_cast<std::ptrdiff_t>(seen.size());
      if (count >= missing) {
        const auto last = seen.begin() + missing - 1;
        std::nth_element(seen.begin(), last, seen.end(), nearer);
        return std::sqrt(last->distance_squared);
      }
      missing -= count;
      begin = end;
    }
    if (r >= r_max || found.size() == photons_.size()) return r_max;
  }
}

}  // namespace etendue
