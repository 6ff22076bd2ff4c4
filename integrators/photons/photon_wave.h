// Photons that are traced together, event by event, in the lanes of the processor (photon_event.h): what they store is the same
// as if each went alone (photon_path.h).
#pragma once

#include "integrators/paths/runs.h"
#include "integrators/photons/photon_event.h"
#include "integrators/photons/photon_path.h"

namespace etendue {

class PhotonWave {
 public:
  PhotonWave(const RenderContext& context, const RoughMaterials& rough_materials, const PhotonPass& pass)
      : context_(context), rough_materials_(rough_materials), pass_(pass) {}

  // Appends what photons [first, last) store, photon by photon. `share(i, numbers)`: by which the power of photon i is
  // multiplied; it may change the numbers that the photon is emitted by. `useful(i)` is called for each that stores something
  // where photons matter.
  template <class Share, class Useful>
  void trace(const PathNumbers& numbers, std::uint32_t first, std::uint32_t last, const Share& share, Photons& out,
             const Useful& useful) {
    for (; first < last; first += most_paths) {
      draw(numbers, first, std::min(most_paths, last - first));
      for (std::uint32_t i = 0; i < starts_.size(); ++i) starts_[i].share = share(first + i, starts_[i].numbers);
      emit(numbers, first);
      follow(first);
      for (const Place& place : order_) {
        const StoredPhoton& p = stored_[place.at];
        out.add(p.position, p.power, p.from, p.flown, p.normal, p.history, static_cast<int>(place.event), p.layer);
        if (!pass_.visible || pass_.visible->contains(p.position, p.normal)) useful(p.path);
      }
    }
  }
  template <class Share>
  void trace(const PathNumbers& numbers, std::uint32_t first, std::uint32_t last, const Share& share, Photons& out) {
    trace(numbers, first, last, share, out, Nothing());
  }

 private:
  static constexpr std::uint32_t most_paths = 1024;  // that go together

  struct Place {
    std::uint32_t at, event;
  };
  struct Nothing {
    void operator()(std::uint32_t) const {}
  };

  void draw(const PathNumbers& numbers, std::uint32_t first, std::uint32_t count);
  void emit(const PathNumbers& numbers, std::uint32_t first);
  void follow(std::uint32_t first);
  void meet(int scatterings);  // one event of each photon under way
  void heed_masks(std::span<StoredPhoton> stored) const;
  // Throws Error where the pass would store more than is free and this process holds already: in a closed white room a path
  // goes on for as many events as it may. Asks when there are many, and each time that they have doubled.
  void require_room();

  const RenderContext& context_;
  const RoughMaterials& rough_materials_;
  const PhotonPass& pass_;
  std::vector<PhotonStart> starts_;
  std::vector<PhotonState> states_, next_states_;
  std::vector<Ray> rays_, next_rays_;
  std::vector<Hit> hits_;
  std::vector<SurfacePoint> points_;
  std::vector<StoredPhoton> stored_;
  std::vector<std::uint32_t> places_;
  std::vector<Place> order_;  // of stored_: photon by photon, event by event
  Runs runs_;
  std::size_t ask_at_ = 1 << 17;  // so many stored photons: require_room
};

}  // namespace etendue
