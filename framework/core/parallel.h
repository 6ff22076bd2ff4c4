// Parallel loops and tasks (oneTBB). The work of an index never depends on the thread that does it.
//
// Only parallel.cpp includes oneTBB for these, at the price of a call per part of a loop: its headers and templates are slow to
// compile. Code that reduces includes it itself.
#pragma once

#include "framework/core/vec.h"

#include <cstddef>
#include <functional>
#include <memory>

namespace etendue {

struct Tile {
  ivec2 begin, end;  // pixels, half open
};

inline constexpr int tile_size = 8;  // pixels a side, where nothing else is said

// run(body, begin, end) over parts of [0, count) that cover it.
void parallel_parts(std::size_t count, std::size_t grain, const void* body,
                    void (*run)(const void* body, std::size_t begin, std::size_t end));

// body(index) for every index in [0, count); `grain` indices at least per task.
template <class Body>
void parallel_for(std::size_t count, std::size_t grain, const Body& body) {
  parallel_parts(count, grain, &body, [](const void* erased, std::size_t begin, std::size_t end) {
    const Body& same = *static_cast<const Body*>(erased);
    for (std::size_t i = begin; i != end; ++i) same(i);
  });
}

// body(Tile) for the square tiles that cover the resolution.
template <class Body>
void parallel_tiles(ivec2 resolution, int size, const Body& body) {
  const ivec2 tiles = (resolution + size - 1) / size;
  parallel_for(static_cast<std::size_t>(tiles.x) * tiles.y, 1, [&](std::size_t i) {
    const ivec2 begin = size * ivec2(static_cast<int>(i) % tiles.x, static_cast<int>(i) / tiles.x);
    body(Tile{begin, glm::min(begin + size, resolution)});
  });
}

// body(ivec2 pixel) for every pixel of the tile, row by row.
template <class Body>
void for_pixels(const Tile& tile, const Body& body) {
  for (int y = tile.begin.y; y < tile.end.y; ++y)
    for (int x = tile.begin.x; x < tile.end.x; ++x) body(ivec2(x, y));
}

// body(ivec2 pixel) for every pixel, tile by tile.
template <class Body>
void parallel_pixels(ivec2 resolution, const Body& body) {
  parallel_tiles(resolution, tile_size, [&](const Tile& tile) { for_pixels(tile, body); });
}

// Runs `body` with exactly `threads` threads available to the loops inside it (more than the machine has is allowed).
void with_threads(int threads, const std::function<void()>& body);

// Tasks that any task of the group may add to. The first exception of one is thrown by `wait`.
class TaskGroup {
 public:
  TaskGroup();
  ~TaskGroup();  // after `wait`

  void run(std::function<void()> task);
  void wait();
  void run_and_wait(const std::function<void()>& task);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Runs both, at the same time where a thread is free.
template <class A, class B>
void parallel_invoke(const A& a, const B& b) {
  TaskGroup group;
  group.run(a);
  group.run_and_wait(b);
}

int hardware_threads();

}  // namespace etendue
