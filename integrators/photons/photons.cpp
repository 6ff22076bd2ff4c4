#include "integrators/photons/photons.h"

#include "framework/core/parallel.h"
#include "integrators/photons/emission/emission_guide.h"
#include "integrators/photons/emission/photon_chains.h"
#include "integrators/photons/photon_path.h"
#include "integrators/photons/photon_wave.h"

namespace etendue {

namespace {

constexpr std::size_t chunk_size = 4096;

// Spreads the low 11 bits of x to every third bit.
constexpr std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 16) & 0x001f0000ff0000ffull;
  x = (x | x << 8) & 0x100f00f00f00f00full;
  x = (x | x << 4) & 0x10c30c30c30c30c3ull;
  return (x | x << 2) & 0x1249249249249249ull;
}

struct CurveKey {
  std::uint32_t cell, id;
};

// Stable sort by 11 bits of the cell from `shift` on. Each block counts its digits and then has a place of its own for each, so
// that the result does not depend on the threads.
void sort_by_digit(std::span<const CurveKey> from, std::span<CurveKey> to, int shift) {
  constexpr std::size_t block = 1 << 15, digits = 1 << 11;
  const std::size_t blocks = (from.size() + block - 1) / block;
  const auto digit = [shift](const CurveKey& key) { return key.cell >> shift & (digits - 1); };
  std::vector<std::uint32_t> places(blocks * digits);
  const auto over_block = [&](std::size_t b, const auto& body) {
    for (std::size_t i = b * block; i < std::min(from.size(), (b + 1) * block); ++i) body(from[i]);
  };
  parallel_for(blocks, 1,
               [&](std::size_t b) { over_block(b, [&](const CurveKey& key) { ++places[b * digits + digit(key)]; }); });
  std::uint32_t place = 0;
  for (std::size_t d = 0; d < digits; ++d)
    for (std::size_t b = 0; b < blocks; ++b) place += std::exchange(places[b * digits + d], place);
  parallel_for(blocks, 1, [&](std::size_t b) {
    over_block(b, [&](const CurveKey& key) { to[places[b * digits + digit(key)]++] = key; });
  });
}

// The narrowest lobe that is not a delta: 1 for Lambert's. Facets turn what glass refracts by half of |eta - 1| of what they
// turn what it reflects: an index next to 1 leaves a lobe in which kernels would find hardly a photon. One that is a quarter
// off 1, or more, is judged by alpha alone.
struct NarrowestAlpha {
  float operator()(const Diffuse&) const { return 1; }
  float operator()(const Conductor& m) const { return std::min(m.alpha.x, m.alpha.y); }
  float operator()(const Dielectric& m) const { return m.alpha * std::min(1.0f, 4 * std::abs(m.eta - 1)); }
  float operator()(const Plastic& m) const { return m.alpha > 0 ? m.alpha : 1; }
  float operator()(const DiffuseTransmission&) const { return 1; }
};

// Photon i draws point i of its pass's sequence.
Photons trace_by_power(const RenderContext& context, const RoughMaterials& rough_materials, const PhotonPass& pass) {
  const float share = 1 / static_cast<float>(pass.count);
  const PathNumbers of_pass(context.seed, pass, pass.key);
  return trace_in_chunks(pass.count, [&](std::uint32_t first, std::uint32_t last, Photons& out) {
    const auto equal = [share](std::uint32_t, EmissionNumbers&) { return share; };
    PhotonWave(context, rough_materials, pass).trace(of_pass, first, last, equal, out);
  });
}

}  // namespace

PhotonSide::PhotonSide(const vec3& normal, PhotonHistory of, Layer on) : history(of), layer(on) {
  const auto quantise = [](float x) {
    x = 127 * std::clamp(x, -1.0f, 1.0f);
    return static_cast<std::int8_t>(x + (x < 0 ? -0.5f : 0.5f));
  };
  x = quantise(normal.x), y = quantise(normal.y), z = quantise(normal.z);
}

void Photons::add(const vec3& at, const Rgb& watts, const vec3& from, float way, const vec3& normal_from, PhotonHistory history,
                  int events, Layer layer) {
  position.push_back(at);
  power.push_back(watts);
  direction.push_back(from);
  flown.push_back(way);
  side.emplace_back(normal_from, history, layer);
  scatterings.push_back(static_cast<std::uint16_t>(std::min(events, 65535)));
}

void Photons::append(const Photons& more) {
  const auto join = [&](auto Photons::*field) {
    (this->*field).insert((this->*field).end(), (more.*field).begin(), (more.*field).end());
  };
  for_each_field(join);
}

void Photons::reserve(std::size_t count) {
  for_each_field([&](auto Photons::*field) { (this->*field).reserve(count); });
}

void Photons::clear() {
  for_each_field([&](auto Photons::*field) { (this->*field).clear(); });
}

// One array after the other, so that never more than one is there twice.
Photons reordered(Photons photons, std::span<const std::uint32_t> order) {
  Photons::for_each_field([&](auto Photons::*field) {
    const auto from = std::move(photons.*field);
    auto& to = photons.*field;
    to.resize(order.size());
    parallel_for(order.size(), chunk_size, [&](std::size_t i) { to[i] = from[order[i]]; });
  });
  return photons;
}

// One array after the other, as above.
Photons joined(std::vector<Photons> parts) {
  std::vector<std::size_t> offset(parts.size() + 1, 0);
  for (std::size_t p = 0; p < parts.size(); ++p) offset[p + 1] = offset[p] + parts[p].size();
  Photons out;
  Photons::for_each_field([&](auto Photons::*field) {
    (out.*field).resize(offset.back());
    parallel_for(parts.size(), 1, [&](std::size_t p) {
      const auto part = std::move(parts[p].*field);
      std::ranges::copy(part, (out.*field).begin() + static_cast<std::ptrdiff_t>(offset[p]));
    });
  });
  return out;
}

std::vector<std::uint32_t> along_curve(std::span<const vec3> points) {
  Bounds bounds;
  for (const vec3& p : points) bounds.extend(p);
  const vec3 scale = 2047.0f / glm::max(bounds.diagonal(), vec3(1e-30f));  // finite where all lie in one plane
  std::vector<CurveKey> keys(points.size()), sorted(points.size());
  parallel_for(points.size(), chunk_size, [&](std::size_t i) {
    const uvec3 cell(glm::clamp((points[i] - bounds.lower) * scale, vec3(0), vec3(2047)));
    const std::uint64_t morton = spread_bits(cell.x) << 2 | spread_bits(cell.y) << 1 | spread_bits(cell.z);
    keys[i] = {static_cast<std::uint32_t>(morton >> 1), static_cast<std::uint32_t>(i)};
  });
  sort_by_digit(keys, sorted, 0);
  sort_by_digit(sorted, keys, 11);
  sort_by_digit(keys, sorted, 22);
  std::vector<std::uint32_t> order(points.size());
  parallel_for(points.size(), chunk_size, [&](std::size_t i) { order[i] = sorted[i].id; });
  return order;
}

// GGX has 1 / (pi alpha^2) for its peak; reflection spreads it over four times the solid angle.
RoughMaterials::RoughMaterials(const Scene& scene, float narrow, LobeTails lobe_tails, bool gathers_coats)
    : tail_density_(1 / (4 * pi * square(std::max(narrow, 1e-6f)))) {
  for (const Material& material : scene.materials) {
    const bool coat = gathers_coats && std::holds_alternative<Plastic>(material);
    const bool narrow_rough = !coat && has_non_specular(material) && std::visit(NarrowestAlpha{}, material) < narrow;
    narrow_lobes_ |= narrow_rough;
    kinds_.push_back(!has_non_specular(material)         ? Kind::specular_like
                     : !narrow_rough                     ? Kind::rough
                     : lobe_tails == LobeTails::gathered ? Kind::tails
                                                         : Kind::specular_like);
  }
}

bool gathers_coats(const RenderContext& context) {
  return context.needs.caustic_map && std::ranges::any_of(context.scene.lights, is_delta);
}

Expectation expectation_in(const RenderContext& context, const RoughMaterials& rough_materials, Expectation expected) {
  if (!rough_materials.narrow_lobes() || !gathers_coats(context)) return expected;
  expected.bias = Bias::biased;
  expected.bias_bound = 1;
  expected.left_out =
      "light from delta lights that comes by way of specular surfaces is left out on metals and frosted glass of "
      "less roughness than carry_below; vcm brings it";
  return expected;
}

Photons trace_photons(const RenderContext& context, const RoughMaterials& rough_materials, const PhotonPass& pass) {
  if (context.lights.empty() || pass.count == 0 || pass.max_scatterings < 0) return {};
  if (pass.max_scatterings == 0 && !(pass.keep & photon_direct)) return {};  // the first that could be kept have scattered once
  Photons photons = pass.emission == PhotonEmission::importance   ? trace_by_importance(context, rough_materials, pass)
                    : pass.emission == PhotonEmission::visibility ? trace_by_visibility(context, rough_materials, pass)
                                                                  : trace_by_power(context, rough_materials, pass);
  count(Counter::photons_emitted, pass.count);
  count(Counter::photons_stored, photons.size());
  return photons;
}

}  // namespace etendue
