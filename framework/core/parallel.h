// Parallel loops (oneTBB). The work of an index never depends on the thread that does it.
#pragma once

#include "framework/core/vec.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstddef>

namespace etendue {

struct Tile {
  ivec2 begin, end;  // pixels, half open
};

inline constexpr int tile_size = 8;  // pixels a side, where nothing else is said

// body(index) for every index in [0, count); `grain` indices at least per task.
template <class Body>
void parallel_for(std::size_t count, std::size_t grain, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) body(i);
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
template <class Body>
void with_threads(int threads, const Body& body) {
  tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  arena.execute(body);
}

int hardware_threads();

}  // namespace etendue
