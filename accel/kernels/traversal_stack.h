// The stack of an iterative traversal, as deep as the tree it is for.
//
// Trees of ordinary depth use a fixed array on the stack. Deeper ones borrow from a pool of the thread, which grows once and is
// kept, so that queries do not allocate in the long run. Traversals nest (a top level calls bottom levels), hence the pool
// hands out one block per nesting.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace etendue {

template <class Entry, std::uint32_t fixed_size = 65>
class TraversalStack {
 public:
  // Room for `depth` entries and one more, which a traversal may write before it knows whether to keep it.
  explicit TraversalStack(std::uint32_t depth) : begin_(entries_) {
    if (depth < fixed_size) return;
    borrowed_ = true;
    begin_ = borrow(depth + 1);
  }
  ~TraversalStack() {
    if (borrowed_) --pool().in_use;
  }
  TraversalStack(const TraversalStack&) = delete;
  TraversalStack& operator=(const TraversalStack&) = delete;

  Entry* begin() { return begin_; }

 private:
  struct Block {
    std::unique_ptr<Entry[]> entries;
    std::size_t size = 0;
  };
  struct Pool {
    std::vector<Block> blocks;
    std::size_t in_use = 0;
  };
  static Pool& pool() {
    thread_local Pool pool;
    return pool;
  }

  static Entry* borrow(std::size_t size) {
    Pool& p = pool();
    if (p.in_use == p.blocks.size()) p.blocks.emplace_back();
    Block& block = p.blocks[p.in_use++];
    if (block.size < size) block = {std::make_unique<Entry[]>(size), size};
    return block.entries.get();
  }

  Entry* begin_;
  bool borrowed_ = false;
  Entry entries_[fixed_size];
};

}  // namespace etendue
