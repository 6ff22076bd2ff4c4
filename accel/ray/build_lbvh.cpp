#include "accel/ray/build_lbvh.h"

#include "accel/ray/link_tree.h"
#include "accel/ray/morton_order.h"

namespace etendue {

namespace {

struct HighestBitCuts {
  std::span<const BuildItem> items;
  std::span<const std::uint64_t> codes;
  std::uint32_t leaf_size;

  std::optional<Cut> best(const Run& run) const {
    if (run.size() <= leaf_size) return std::nullopt;
    const std::uint64_t first = codes[run.begin], last = codes[run.end - 1];
    if (first == last) return halve(run);
    // The first code with the highest bit that differs: no less than `last` without its lower bits.
    const std::uint64_t bound = last & ~(std::bit_floor(first ^ last) - 1);
    std::uint32_t below = run.begin;
    for (std::uint32_t count = run.size(); count > 1;) {
      const std::uint32_t half = count / 2;
      below = codes[below + half] < bound ? below + half : below;
      count -= half;
    }
    return Cut{below + 1, 0, 0};
  }
  Cut halve(const Run& run) const { return {run.begin + run.size() / 2, 0, 0}; }
  void settle(const Run&) const {}
  const BuildItem& item(std::uint32_t position) const { return items[position]; }
};

}  // namespace

BinaryTree build_lbvh(std::vector<BuildItem> items, const TreeLimits& limits) {
  if (items.empty()) return {};
  const std::vector<std::uint64_t> codes = sort_by_morton_code(items);
  HighestBitCuts cuts{items, codes, static_cast<std::uint32_t>(limits.leaf_size)};
  return TreeLinker(cuts, static_cast<std::uint32_t>(items.size()), limits).link(0);
}

}  // namespace etendue
