// Answers of the BSDFs that a wave meets, many at once: written over lanes as path_event.h is, and compiled with it.
#pragma once

#include "framework/scene/triangle_surface.h"
#include "framework/transport/bsdf.h"

#include <span>

namespace etendue {

// At a surface, towards wo. `other` is wi; or, where a direction is to be sampled, the number for the lobe and two for it.
struct BsdfQuery {
  const SurfacePoint* point;
  vec3 wo, other;
};

// A sampled direction, and the density of wo given it.
template <class F>
struct ReversibleSampleOf : BsdfSampleOf<F> {
  F pdf_reverse{0.0f};
};
using ReversibleSample = ReversibleSampleOf<float>;

// Queries about surfaces of one material, and where the answers go, as the queries are numbered: pairs, or samples.
struct BsdfEvents {
  const Scene& scene;
  const void* material;  // of the kind that the function is for
  TransportMode mode;
  std::span<const std::uint32_t> which;
  const BsdfQuery* queries;
  BsdfPair* pairs;  // null: samples are wanted
  ReversibleSample* samples;
};

template <class F, class M, class Read, class Write>
void ask_material(const BsdfEvents& events, const Read& read, const Write& write) {
  const M& material = *static_cast<const M*>(events.material);
  for (std::size_t first = 0; first < events.which.size(); first += lane_count<F>) {
    SurfaceOf<F> point;
    Vec3<F> wo, other;
    const Mask<F> active = read(first, material.uses_uvs(), point, wo, other);
    const auto colour = [&](const TexturedRgb& c) { return read.colour(c, point, active); };
    const auto bsdf = place_lobes<F>(material, point, colour);
    if (events.pairs != nullptr) {
      write(first, bsdf.pair(wo, other, events.mode));
    } else {
      ReversibleSampleOf<F> next{bsdf.sample(wo, other.x, {other.y, other.z}, events.mode)};
      next.pdf_reverse = bsdf.pdf(next.wi, wo);
      write(first, next);
    }
  }
}

}  // namespace etendue
