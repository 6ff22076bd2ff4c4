// Points sorted into numbered cells: a counting sort in two steps, first by the upper bits of the cell's number with one
// histogram for each block of the input, then within each part by the rest. Blocks depend on the number of points alone and the
// sort is stable, so the result is the same at any number of threads.
#pragma once

#include "accel/points/neighbourhood.h"
#include "framework/core/huge_pages.h"
#include "framework/core/parallel.h"

#include <bit>

namespace etendue {

// These leave out points that are not finite.
Bounds finite_bounds(std::span<const vec3> points);
std::vector<PlacedPoint> finite_placed_points(std::span<const vec3> points);

struct CellRuns {
  std::vector<PlacedPoint> points;   // finite ones, cell by cell, in each by id
  std::vector<std::uint32_t> first;  // of each cell, and behind them the number of points
};

// `cell_of(position)` is below `cells`.
template <class CellOf>
CellRuns sort_into_cells(std::span<const vec3> points, std::uint32_t cells, const CellOf& cell_of) {
  constexpr int part_bits = 11;
  constexpr std::size_t smallest_block = 1 << 14, most_blocks = 32;
  const int shift = std::max(0, static_cast<int>(std::bit_width(cells - 1)) - part_bits);
  const std::size_t parts = ((cells - 1) >> shift) + 1;
  const std::size_t block_size = std::max(smallest_block, (points.size() + most_blocks - 1) / most_blocks);
  const std::size_t blocks = (points.size() + block_size - 1) / block_size;

  constexpr std::uint32_t nowhere = no_id;
  std::vector<std::uint32_t> cell(points.size()), counts(blocks * parts);
  const auto each_in_block = [&](std::size_t block, const auto& body) {
    const std::size_t end = std::min(points.size(), (block + 1) * block_size);
    for (std::size_t i = block * block_size; i < end; ++i) body(i);
  };
  parallel_for(blocks, 1, [&](std::size_t block) {
    each_in_block(block, [&](std::size_t i) {
      cell[i] = is_finite(points[i]) ? cell_of(points[i]) : nowhere;
      if (cell[i] != nowhere) ++counts[block * parts + (cell[i] >> shift)];
    });
  });

  std::vector<std::uint32_t> part_first(parts + 1);
  std::uint32_t sum = 0;
  for (std::size_t part = 0; part < parts; ++part) {
    part_first[part] = sum;
    for (std::size_t block = 0; block < blocks; ++block) sum += std::exchange(counts[block * parts + part], sum);
  }
  part_first[parts] = sum;

  std::vector<PlacedPoint> moved;
  resize_on_huge_pages(moved, sum);
  std::vector<std::uint32_t> moved_cell(sum);
  parallel_for(blocks, 1, [&](std::size_t block) {
    each_in_block(block, [&](std::size_t i) {
      if (cell[i] == nowhere) return;
      const std::uint32_t to = counts[block * parts + (cell[i] >> shift)]++;
      moved[to] = {points[i], static_cast<std::uint32_t>(i)};
      moved_cell[to] = cell[i];
    });
  });

  // Entry c + 1 is first the number of points of cell c, then where its next one goes, and so in the end where c ends.
  CellRuns runs;
  runs.first.assign(std::size_t{cells} + 1, 0);
  resize_on_huge_pages(runs.points, sum);
  parallel_for(parts, 16, [&](std::size_t part) {
    std::uint32_t* const next = runs.first.data() + 1;
    const std::uint32_t begin = part_first[part], end = part_first[part + 1];
    const std::size_t last_cell = std::min<std::size_t>(cells, (part + 1) << shift);
    for (std::uint32_t i = begin; i < end; ++i) ++next[moved_cell[i]];
    std::uint32_t position = begin;
    for (std::size_t c = part << shift; c < last_cell; ++c) position += std::exchange(next[c], position);
    for (std::uint32_t i = begin; i < end; ++i) runs.points[next[moved_cell[i]]++] = moved[i];
  });
  return runs;
}

}  // namespace etendue
