// An allocator for arrays that are read at random: large ones lie on pages of 2 MiB where the system grants them, so that a
// traversal waits less for address translation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>
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
    madvise(memory, bytes, MADV_HUGEPAGE);  // advice only: small pages work as well
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

// Leaves values unconstructed: after a resize, the threads that know them construct or assign them in place.
template <class T>
struct UnconstructedOnHugePages : HugePageAllocator<T> {
  using value_type = T;

  UnconstructedOnHugePages() = default;
  template <class U>
  UnconstructedOnHugePages(const UnconstructedOnHugePages<U>&) {}

  static void construct(T*) { static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>); }
};

template <class T>
using HugePageVector = std::vector<T, UnconstructedOnHugePages<T>>;

// Asks for huge pages under memory that has not been touched yet, if it is large: a builder writes its arrays once, and mapping
// thousands of small pages would take part of its time.
inline void wish_for_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
  constexpr std::uintptr_t page = 2 << 20;
  const auto address = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t begin = (address + page - 1) / page * page, end = (address + bytes) / page * page;
  if (end >= begin + 4 * page) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
#endif
}

// Resizes an empty vector, its memory on huge pages.
template <class T>
void resize_on_huge_pages(std::vector<T>& values, std::size_t count) {
  values.reserve(count);
  wish_for_huge_pages(values.data(), count * sizeof(T));
  values.resize(count);
}

struct FreeUninitialised {
  template <class T>
  void operator()(T* values) const {
    ::operator delete(values, std::align_val_t(alignof(T)));
  }
};

// An array for work that writes each element before it reads it: values of plain types are left uninitialised, so that the
// threads that first write them share the cost of mapping the memory.
template <class T>
using UninitialisedArray = std::unique_ptr<T[], FreeUninitialised>;

template <class T>
UninitialisedArray<T> uninitialised_on_huge_pages(std::size_t count) {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);
  auto* const values = static_cast<T*>(::operator new(count * sizeof(T), std::align_val_t(alignof(T))));
  wish_for_huge_pages(values, count * sizeof(T));
  return UninitialisedArray<T>(values);
}

}  // namespace etendue
