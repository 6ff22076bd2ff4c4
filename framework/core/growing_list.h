// A list that is filled item by item and kept for its memory. `append` gives the place of a new item, to be written member by
// member: push_back would copy what was just stored piece by piece, and the processor waits for such copies.
#pragma once

#include <vector>

namespace etendue {

template <class T>
class GrowingList {
 public:
  void clear() { size_ = 0; }
  T& append() {  // holds what it last held
    if (size_ == items_.size()) grow();
    return items_[size_++];
  }
  std::size_t size() const { return size_; }
  const T& operator[](std::size_t i) const { return items_[i]; }
  const T* data() const { return items_.data(); }
  const T* begin() const { return items_.data(); }
  const T* end() const { return begin() + size_; }

 private:
  [[gnu::noinline]] void grow() { items_.resize(2 * size_ + 64); }

  std::vector<T> items_;
  std::size_t size_ = 0;
};

}  // namespace etendue
