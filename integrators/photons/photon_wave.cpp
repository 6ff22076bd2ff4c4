#include "integrators/photons/photon_wave.h"

#include "framework/core/memory.h"
#include "framework/core/units.h"

#include <fmt/format.h>

namespace etendue {

namespace {

const PhotonKernels& photon_kernels() {
#if defined(__x86_64__)
  return kernels_of_isa(photon_kernels_one, photon_kernels_sse, photon_kernels_avx2, photon_kernels_avx512);
#else
  return photon_kernels_one();
#endif
}

}  // namespace

void PhotonWave::draw(const PathNumbers& numbers, std::uint32_t first, std::uint32_t count) {
  starts_.resize(count);
  PhotonStarts starts{context_.lights, numbers, first, starts_, nullptr, nullptr};
  if (numbers.sampler() == SamplerKind::sobol)
    photon_kernels().draw(starts);
  else
    for (std::uint32_t i = 0; i < count; ++i) starts_[i].numbers = numbers.emission(first + i);
}

void PhotonWave::emit(const PathNumbers& numbers, std::uint32_t first) {
  stored_.clear();
  states_.resize(starts_.size());
  rays_.resize(starts_.size());
  PhotonStarts starts{context_.lights, numbers, first, starts_, states_.data(), rays_.data()};
  photon_kernels().emit(starts);
  states_.resize(starts.count);
  rays_.resize(starts.count);
}

void PhotonWave::follow(std::uint32_t first) {
  const std::uint32_t last = states_.empty() ? first : states_.back().path + 1;
  std::vector<std::size_t> ends;  // of each event's, in stored_
  for (int scatterings = 0; !states_.empty(); ++scatterings) {
    meet(scatterings);
    ends.push_back(stored_.size());
    if (stored_.size() >= ask_at_) require_room();
  }
  // Counts of each photon, then places: what one stored stays in the order of its events.
  places_.assign(last - first + 1, 0);
  for (const StoredPhoton& p : stored_) ++places_[p.path - first + 1];
  for (std::size_t i = 1; i < places_.size(); ++i) places_[i] += places_[i - 1];
  order_.resize(stored_.size());
  std::uint32_t i = 0;
  for (std::uint32_t event = 0; event < ends.size(); ++event)
    for (; i < ends[event]; ++i) order_[places_[stored_[i].path - first]++] = {i, event};
}

void PhotonWave::require_room() {
  ask_at_ = 2 * stored_.size();
  constexpr double bytes_of_photon = 115, looked_at_from = 1 << 30;  // the former while a map is built
  const double bytes =
      bytes_of_photon * static_cast<double>(stored_.size()) * pass_.count / static_cast<double>(starts_.size());
  if (bytes < looked_at_from && memory_limit() == 0) return;
  const auto held = static_cast<double>(resident_memory_bytes()), free = static_cast<double>(available_memory_bytes());
  if (bytes <= held + free) return;
  throw Error(
      fmt::format("the photons of a pass need about {}, and {} are there; expected fewer photons, or a smaller max_depth",
                  format_bytes(bytes), format_bytes(held + free)));
}

// Divides what was stored by the opacity where it lies, as PhotonTracer does, and notes its layer.
void PhotonWave::heed_masks(std::span<StoredPhoton> stored) const {
  static thread_local std::vector<std::uint32_t> of_path;  // its place among the states
  for (std::uint32_t i = 0; i < states_.size(); ++i) {
    const std::uint32_t path = states_[i].path % most_paths;
    if (of_path.size() <= path) of_path.resize(path + 1);
    of_path[path] = i;
  }
  for (StoredPhoton& photon : stored) {
    const Hit& hit = hits_[of_path[photon.path % most_paths]];
    photon.power /= context_.stopped_share(hit);
    photon.layer = context_.scene.layer_at(hit);
  }
}

void PhotonWave::meet(int scatterings) {
  const Scene& scene = context_.scene;
  const Object& world = scene.objects[0];
  const PhotonKernels& kernels = photon_kernels();
  const std::size_t count = states_.size(), stored = stored_.size();
  hits_.resize(count);
  points_.resize(count);
  etendue::trace(context_, rays_, hits_);
  runs_.reset(2 * scene.materials.size());
  for (std::size_t i = 0; i < count; ++i) {
    const Hit& hit = hits_[i];
    if (!hit) continue;
    const bool on_triangle = hit.instance == 0 && world.geometry.is_triangle(hit.primitive);
    const bool of_point = rays_[i].t_min > 0;
    if (!on_triangle || of_point) points_[i] = scene.surface_at(rays_[i], hit);
    if (of_point && meets_own_wall(rays_[i], points_[i])) continue;
    const std::uint32_t material = on_triangle ? world.shape(hit.primitive).material : points_[i].material;
    runs_.add(2 * material + (on_triangle ? 0 : 1), static_cast<std::uint32_t>(i));
  }
  stored_.resize(stored + count);
  next_states_.resize(count);
  next_rays_.resize(count);
  PhotonEvents events{.scene = scene,
                      .material = nullptr,
                      .rules = {},
                      .last = scatterings >= pass_.max_scatterings,
                      .on_triangles = false,
                      .which = {},
                      .states = states_.data(),
                      .rays = rays_.data(),
                      .hits = hits_.data(),
                      .points = points_.data(),
                      .stored = stored_.data() + stored,
                      .next_states = next_states_.data(),
                      .next_rays = next_rays_.data()};
  runs_.each([&](std::size_t kind, std::span<const std::uint32_t> which) {
    const auto material = static_cast<std::uint32_t>(kind / 2);
    events.material = contents_of(scene.materials[material]);
    events.rules = {rough_materials_.stores(material), rough_materials_(material), pass_.keep};
    events.on_triangles = kind % 2 == 0;
    events.which = which;
    kernels.meet[scene.materials[material].index()](events);
  });
  stored_.resize(stored + events.stored_count);
  if (context_.needs.masks) heed_masks(std::span(stored_).subspan(stored));
  states_.swap(next_states_);
  rays_.swap(next_rays_);
  states_.resize(events.going_on);
  rays_.resize(events.going_on);
}

}  // namespace etendue
