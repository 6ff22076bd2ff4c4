// Wide traversal without SIMD instructions: for other machines, and to test the others against.
#include "accel/ray/wide_headers.h"

#include "accel/ray/simd_compose.inl"
#include "accel/ray/wide_traversal.inl"

namespace etendue {
namespace {

struct OneFloat {
  float x;

  static OneFloat load(const float* p) { return {*p}; }
  static OneFloat set(float value) { return {value}; }
  void store(float* p) const { *p = x; }
  friend OneFloat operator+(OneFloat a, OneFloat b) { return {a.x + b.x}; }
  friend OneFloat operator-(OneFloat a, OneFloat b) { return {a.x - b.x}; }
  friend OneFloat operator*(OneFloat a, OneFloat b) { return {a.x * b.x}; }
  friend OneFloat operator/(OneFloat a, OneFloat b) { return {a.x / b.x}; }
  friend OneFloat larger(OneFloat a, OneFloat b) { return {a.x > b.x ? a.x : b.x}; }
  friend OneFloat smaller(OneFloat a, OneFloat b) { return {a.x < b.x ? a.x : b.x}; }
  friend unsigned less(OneFloat a, OneFloat b) { return a.x < b.x; }
  friend unsigned less_equal(OneFloat a, OneFloat b) { return a.x <= b.x; }
  friend unsigned equal(OneFloat a, OneFloat b) { return a.x == b.x; }
};

template <int width>
struct Row {
  using type = Twice<typename Row<width / 2>::type, width / 2>;
};
template <>
struct Row<1> {
  using type = OneFloat;
};

struct ScalarSimd : LaneByLane {
  template <int width>
  using Floats = typename Row<width>::type;
};

}  // namespace

const WideKernelSet& wide_kernels_scalar() { return kernel_set<ScalarSimd>(); }

}  // namespace etendue
