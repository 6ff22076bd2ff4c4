// An allocator for arrays that are read at random: large ones lie on pages of 2 MiB where the system grants them, so that a
// traversal waits less for address translation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace etendue {

template <class T>
struct HugePageAllocator {
  using value_type = T;
  static constexpr std::size_t page = 2 << 20;

  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (bytes < page) return static_cast<T*>(::operator new(bytes, std::align_val_t(alignof(T))));
    void* const memory = std::aligned_alloc(page, (bytes + page - 1) / page * page);
    if (memory == nullptr) throw std::bad_alloc();
#if defined(__linux__)
    madvise(memory, bytes, MADV_HUGEPAGE);  // a wish: small pages do as well
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) {
    if (count * sizeof(T) < page)
      ::operator delete(memory, std::align_val_t(alignof(T)));
    else
      std::free(memory);
  }
  friend bool operator==(const HugePageAllocator&, const HugePageAllocator&) { return true; }
};

// Resizes a new vector, whose memory, where it is large, is asked for on huge pages before it is first touched: a builder's
// arrays are written once, and getting thousands of small pages takes a tenth of its time.
template <class T>
void resize_on_huge_pages(std::vector<T>& values, std::size_t count) {
  values.reserve(count);
#if defined(__linux__)
  constexpr std::uintptr_t page = 2 << 20;
  const auto address = reinterpret_cast<std::uintptr_t>(values.data());
  const std::uintptr_t begin = (address + page - 1) / page * page, end = (address + count * sizeof(T)) / page * page;
  if (end >= begin + 4 * page) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
#endif
  values.resize(count);
}

}  // namespace etendue
