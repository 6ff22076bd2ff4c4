// Photons in the lanes of an instruction set: reads and writes what photon_event.h computes with.
#pragma once

#include "integrators/lanes/surface_wide.inl"
#include "integrators/photons/photon_event.h"

namespace etendue {
namespace {

inline WideBits numbers_from(std::uint32_t first) {
  alignas(64) std::uint32_t index[width];
  for (int row = 0; row < width; ++row) index[row] = first + static_cast<std::uint32_t>(row);
  return WideBits::load(index);
}

void draw(PhotonStarts& starts) {
  std::uint32_t i = starts.first;
  const auto points = starts.numbers.points<F>();
  for (std::size_t first = 0; first < starts.starts.size(); first += width, i += width) {
    const auto u = points(numbers_from(i));
    const int count = static_cast<int>(std::min<std::size_t>(width, starts.starts.size() - first));
    for (std::size_t d = 0; d < emission_dimensions; ++d) {
      alignas(64) float values[width];
      u[d].store(values);
      for (int row = 0; row < count; ++row) starts.starts[first + static_cast<std::size_t>(row)].numbers[d] = values[row];
    }
  }
}

void emit(PhotonStarts& starts) {
  for (std::size_t first = 0; first < starts.starts.size(); first += width) {
    const int count = static_cast<int>(std::min<std::size_t>(width, starts.starts.size() - first));
    const std::uint32_t number = starts.first + static_cast<std::uint32_t>(first);
    Rows<10> rows;
    for (int row = 0; row < width; ++row) {
      const PhotonStart& start = starts.starts[first + static_cast<std::size_t>(row < count ? row : 0)];
      for (int d = 0; d < emission_dimensions; ++d) rows.put(d, row, start.numbers[static_cast<std::size_t>(d)]);
      rows.put(emission_dimensions, row, start.share);
    }
    const F share = rows.floats(emission_dimensions);
    const EmittedOf<F> emitted = emit_particles<F>(starts.lights, rows.floats(0), {rows.floats(1), rows.floats(2)},
                                                   {rows.floats(3), rows.floats(4)}, WideMask::first(count));
    const PcgOf<F> random = starts.numbers.scattering<F>(numbers_from(number));
    alignas(64) std::uint64_t state[width], increment[width];
    random.state.store(state);
    random.increment.store(increment);
    rows.put(0, emitted.origin);
    rows.put(3, emitted.direction);
    rows.put(6, emitted.power * share);
    rows.put(9, emitted.t_min);
    for_lanes(WideMask::first(count) & !is_black(emitted.power), [&](int row) {
      starts.states[starts.count] = {
          number + static_cast<std::uint32_t>(row), photon_direct, rows.get_vec(6, row), {state[row], increment[row]}};
      starts.rays[starts.count++] = {
          .origin = rows.get_vec(0, row), .t_min = rows.get(9, row), .direction = rows.get_vec(3, row)};
    });
  }
}

struct ReadPhotons {
  const PhotonEvents& events;

  WideMask operator()(std::size_t first, bool uses_uvs, SurfaceOf<F>& point, WideVec3& from, PhotonLanes<F>& photon) const {
    std::uint32_t which[width];
    const int count = read_which(events.which, first, which);
    Rows<6> rows;
    alignas(64) std::uint32_t history[width];
    alignas(64) std::uint64_t state[width], increment[width];
    for (int row = 0; row < width; ++row) {
      const PhotonState& s = events.states[which[row]];
      rows.put(0, row, events.rays[which[row]].direction);
      rows.put(3, row, s.power);
      history[row] = s.history;
      state[row] = s.random.state;
      increment[row] = s.random.increment;
    }
    from = -rows.vec(0);
    photon = {rows.vec(3), WideBits::load(history), {{WideLongBits::load(state), WideLongBits::load(increment)}}};
    point = surface_of(events, which, uses_uvs, rows.vec(0));
    return WideMask::first(count);
  }
  WideVec3 colour(const TexturedRgb& c, const SurfaceOf<F>& point, WideMask active) const {
    return colour_of(events.scene, c, point, active);
  }
};

struct WritePhotons {
  PhotonEvents& events;

  void store(std::size_t first, WideMask stored, const WideVec3& position, const WideVec3& power, const WideVec3& from,
             const WideVec3& normal, WideBits history) const {
    if (!any(stored)) return;
    Rows<12> rows;
    alignas(64) std::uint32_t histories[width];
    rows.put(0, position);
    rows.put(3, power);
    rows.put(6, from);
    rows.put(9, normal);
    history.store(histories);
    for_lanes(stored, [&](int row) {
      const std::uint32_t i = events.which[first + static_cast<std::size_t>(row)];
      events.stored[events.stored_count++] = {events.states[i].path,
                                              rows.get_vec(0, row),
                                              rows.get_vec(3, row),
                                              rows.get_vec(6, row),
                                              events.hits[i].t,
                                              rows.get_vec(9, row),
                                              static_cast<PhotonHistory>(histories[row])};
    });
  }
  void go_on(std::size_t first, WideMask alive, const PhotonLanes<F>& photon, const RayLanes<F>& ray) const {
    if (!any(alive)) return;
    Rows<9> rows;
    alignas(64) std::uint32_t history[width];
    alignas(64) std::uint64_t state[width], increment[width];
    rows.put(0, ray.origin);
    rows.put(3, ray.direction);
    rows.put(6, photon.power);
    photon.history.store(history);
    photon.numbers.random.state.store(state);
    photon.numbers.random.increment.store(increment);
    for_lanes(alive, [&](int row) {
      const std::uint32_t path = events.states[events.which[first + static_cast<std::size_t>(row)]].path;
      events.next_states[events.going_on] = {
          path, static_cast<PhotonHistory>(history[row]), rows.get_vec(6, row), {state[row], increment[row]}};
      events.next_rays[events.going_on++] = {.origin = rows.get_vec(0, row), .direction = rows.get_vec(3, row)};
    });
  }
};

template <class M>
void meet_photon(PhotonEvents& events) {
  meet_photons<F, M>(events, ReadPhotons{events}, WritePhotons{events});
}

template <class... M>
constexpr PhotonKernels photon_kernels_of(const std::variant<M...>*) {
  return {draw, emit, {meet_photon<M>...}};
}

}  // namespace
}  // namespace etendue
