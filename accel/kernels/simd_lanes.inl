// Vectors of floats for the wide traversal: those that an instruction set has, pairs of them where a node is wider, and
// stacking by a loop over lanes. Included like accel/bvh/wide/wide_tests.inl.
#pragma once

namespace etendue {
namespace {

struct OneFloat {
  float x;

  static OneFloat load(const float* p) { return {*p}; }
  static OneFloat load_anywhere(const float* p) { return {*p}; }
  static OneFloat set(float value) { return {value}; }
  void store(float* p) const { *p = x; }
  void store_anywhere(float* p) const { *p = x; }
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

#ifdef __SSE4_1__
struct Lanes4 {
  __m128 v;

  static Lanes4 load(const float* p) { return {_mm_load_ps(p)}; }
  static Lanes4 load_anywhere(const float* p) { return {_mm_loadu_ps(p)}; }
  static Lanes4 set(float x) { return {_mm_set1_ps(x)}; }
  void store(float* p) const { _mm_store_ps(p, v); }
  void store_anywhere(float* p) const { _mm_storeu_ps(p, v); }
  friend Lanes4 operator+(Lanes4 a, Lanes4 b) { return {_mm_add_ps(a.v, b.v)}; }
  friend Lanes4 operator-(Lanes4 a, Lanes4 b) { return {_mm_sub_ps(a.v, b.v)}; }
  friend Lanes4 operator*(Lanes4 a, Lanes4 b) { return {_mm_mul_ps(a.v, b.v)}; }
  friend Lanes4 operator/(Lanes4 a, Lanes4 b) { return {_mm_div_ps(a.v, b.v)}; }
  friend Lanes4 larger(Lanes4 a, Lanes4 b) { return {_mm_max_ps(a.v, b.v)}; }
  friend Lanes4 smaller(Lanes4 a, Lanes4 b) { return {_mm_min_ps(a.v, b.v)}; }
  friend unsigned less(Lanes4 a, Lanes4 b) { return static_cast<unsigned>(_mm_movemask_ps(_mm_cmplt_ps(a.v, b.v))); }
  friend unsigned less_equal(Lanes4 a, Lanes4 b) { return static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(a.v, b.v))); }
  friend unsigned equal(Lanes4 a, Lanes4 b) { return static_cast<unsigned>(_mm_movemask_ps(_mm_cmpeq_ps(a.v, b.v))); }
};

#endif

#ifdef __AVX2__
struct Lanes8 {
  __m256 v;

  static Lanes8 load(const float* p) { return {_mm256_load_ps(p)}; }
  static Lanes8 load_anywhere(const float* p) { return {_mm256_loadu_ps(p)}; }
  static Lanes8 set(float x) { return {_mm256_set1_ps(x)}; }
  void store(float* p) const { _mm256_store_ps(p, v); }
  void store_anywhere(float* p) const { _mm256_storeu_ps(p, v); }
  friend Lanes8 operator+(Lanes8 a, Lanes8 b) { return {_mm256_add_ps(a.v, b.v)}; }
  friend Lanes8 operator-(Lanes8 a, Lanes8 b) { return {_mm256_sub_ps(a.v, b.v)}; }
  friend Lanes8 operator*(Lanes8 a, Lanes8 b) { return {_mm256_mul_ps(a.v, b.v)}; }
  friend Lanes8 operator/(Lanes8 a, Lanes8 b) { return {_mm256_div_ps(a.v, b.v)}; }
  friend Lanes8 larger(Lanes8 a, Lanes8 b) { return {_mm256_max_ps(a.v, b.v)}; }
  friend Lanes8 smaller(Lanes8 a, Lanes8 b) { return {_mm256_min_ps(a.v, b.v)}; }
  friend unsigned less(Lanes8 a, Lanes8 b) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)));
  }
  friend unsigned less_equal(Lanes8 a, Lanes8 b) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)));
  }
  friend unsigned equal(Lanes8 a, Lanes8 b) {
    return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(a.v, b.v, _CMP_EQ_OQ)));
  }
};

#endif

#ifdef __AVX512F__
struct Lanes16 {
  __m512 v;

  static Lanes16 load(const float* p) { return {_mm512_load_ps(p)}; }
  static Lanes16 load_anywhere(const float* p) { return {_mm512_loadu_ps(p)}; }
  static Lanes16 set(float x) { return {_mm512_set1_ps(x)}; }
  void store(float* p) const { _mm512_store_ps(p, v); }
  void store_anywhere(float* p) const { _mm512_storeu_ps(p, v); }
  friend Lanes16 operator+(Lanes16 a, Lanes16 b) { return {_mm512_add_ps(a.v, b.v)}; }
  friend Lanes16 operator-(Lanes16 a, Lanes16 b) { return {_mm512_sub_ps(a.v, b.v)}; }
  friend Lanes16 operator*(Lanes16 a, Lanes16 b) { return {_mm512_mul_ps(a.v, b.v)}; }
  friend Lanes16 operator/(Lanes16 a, Lanes16 b) { return {_mm512_div_ps(a.v, b.v)}; }
  friend Lanes16 larger(Lanes16 a, Lanes16 b) { return {_mm512_max_ps(a.v, b.v)}; }
  friend Lanes16 smaller(Lanes16 a, Lanes16 b) { return {_mm512_min_ps(a.v, b.v)}; }
  friend unsigned less(Lanes16 a, Lanes16 b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ); }
  friend unsigned less_equal(Lanes16 a, Lanes16 b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ); }
  friend unsigned equal(Lanes16 a, Lanes16 b) { return _mm512_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ); }
};

#endif

// The vector that an instruction set has for a width.
template <int width>
struct Native;
template <>
struct Native<1> {
  using type = OneFloat;
};
#ifdef __SSE4_1__
template <>
struct Native<4> {
  using type = Lanes4;
};
#endif
#ifdef __AVX2__
template <>
struct Native<8> {
  using type = Lanes8;
};
#endif
#ifdef __AVX512F__
template <>
struct Native<16> {
  using type = Lanes16;
};
#endif

// Two vectors side by side.
template <class Half, int half_width>
struct Twice {
  Half low, high;

  static Twice load(const float* p) { return {Half::load(p), Half::load(p + half_width)}; }
  static Twice load_anywhere(const float* p) { return {Half::load_anywhere(p), Half::load_anywhere(p + half_width)}; }
  static Twice set(float x) { return {Half::set(x), Half::set(x)}; }
  void store(float* p) const {
    low.store(p);
    high.store(p + half_width);
  }
  void store_anywhere(float* p) const {  // aligned or not
    low.store_anywhere(p);
    high.store_anywhere(p + half_width);
  }
  friend Twice operator+(const Twice& a, const Twice& b) { return {a.low + b.low, a.high + b.high}; }
  friend Twice operator-(const Twice& a, const Twice& b) { return {a.low - b.low, a.high - b.high}; }
  friend Twice operator*(const Twice& a, const Twice& b) { return {a.low * b.low, a.high * b.high}; }
  friend Twice operator/(const Twice& a, const Twice& b) { return {a.low / b.low, a.high / b.high}; }
  friend Twice larger(const Twice& a, const Twice& b) { return {larger(a.low, b.low), larger(a.high, b.high)}; }
  friend Twice smaller(const Twice& a, const Twice& b) { return {smaller(a.low, b.low), smaller(a.high, b.high)}; }
  friend unsigned less(const Twice& a, const Twice& b) { return less(a.low, b.low) | less(a.high, b.high) << half_width; }
  friend unsigned less_equal(const Twice& a, const Twice& b) {
    return less_equal(a.low, b.low) | less_equal(a.high, b.high) << half_width;
  }
  friend unsigned equal(const Twice& a, const Twice& b) { return equal(a.low, b.low) | equal(a.high, b.high) << half_width; }
};

// A vector of `width` floats where the widest that may be used has `widest`.
template <int width, int widest>
struct Row {
  using type = Twice<typename Row<width / 2, widest>::type, width / 2>;
};
template <int width, int widest>
requires(width <= widest) struct Row<width, widest> : Native<width> {
};

// Bits of the triangles of which an edge function is zero, and (elsewhere) of those whose edge functions have one sign.
struct Sides {
  unsigned on_edge, same;
};

// What waits on the stack: a place, and for closest hits where the ray enters it. (A WideRef would do for any hit, but types
// that other files know would have the compiler emit functions which the linker could take for theirs.)
struct Waiting {
  WideRef place;
  float entry;
};
struct WaitingAny {
  WideRef place;
};

// What a traversal asks of an instruction set.
template <int widest>
struct Simd {
  template <int width>
  using Floats = typename Row<width, widest>::type;

  // Sixteen values to pick from by slot.
  class Table {
   public:
    explicit Table(const Floats<16>& values) { values.store(values_); }
    Floats<16> pick(const std::uint8_t* slots) const {
      alignas(64) float picked[16];
      for (int lane = 0; lane < 16; ++lane) picked[lane] = values_[slots[lane]];
      return Floats<16>::load(picked);
    }

   private:
    alignas(64) float values_[16];
  };

  template <class Lanes>
  static Sides sides(const Lanes& u, const Lanes& v, const Lanes& w) {
    const Lanes zero = Lanes::set(0);
    const unsigned below = less(u, zero) | less(v, zero) | less(w, zero);
    const unsigned above = less(zero, u) | less(zero, v) | less(zero, w);
    return {equal(u, zero) | equal(v, zero) | equal(w, zero), below ^ above};
  }

  // The children that are leaves, a bit each.
  template <int width>
  static unsigned leaves(const WideNode<width>& node) {
    unsigned mask = 0;
    for (int slot = 0; slot < width; ++slot) mask |= static_cast<unsigned>(node.children[slot].is_leaf()) << slot;
    return mask;
  }

  template <int width, class Floats>
  static int nearest(const Floats& entries, unsigned met) {
    alignas(64) float entry[width];
    entries.store(entry);
    int best = std::countr_zero(met);
    for (unsigned rest = met & (met - 1); rest != 0; rest &= rest - 1)
      if (entry[std::countr_zero(rest)] < entry[best]) best = std::countr_zero(rest);
    return best;
  }

  template <int width, class Floats>
  static Waiting* stack_places(const WideNode<width>& node, const Floats& entries, unsigned lanes, Waiting* top) {
    alignas(64) float entry[width];
    entries.store(entry);
    for (; lanes != 0; lanes &= lanes - 1) *top++ = {node.children[std::countr_zero(lanes)], entry[std::countr_zero(lanes)]};
    return top;
  }

  // Lists those of `count` rays that meet a child, in their order, and answers how many. May write 16 values beyond.
  static std::uint32_t collect(const std::uint32_t* met, const std::uint32_t* ids, std::uint32_t count, int child,
                               std::uint32_t* to) {
    std::uint32_t size = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      to[size] = ids[i];
      size += met[i] >> child & 1;
    }
    return size;
  }

  // And where they enter it: `entries` by ray and child. `nearest`: the least.
  template <int width>
  static std::uint32_t collect(const std::uint32_t* met, const std::uint32_t* ids, const float* entries, std::uint32_t count,
                               int child, std::uint32_t* to, float* nears, float& nearest) {
    nearest = infinity;
    std::uint32_t size = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      if ((met[i] >> child & 1) == 0) continue;
      const float entry = entries[i * width + child];
      to[size] = ids[i];
      nears[size++] = entry;
      nearest = std::min(nearest, entry);
    }
    return size;
  }

  template <int width>
  static WaitingAny* stack_places(const WideNode<width>& node, unsigned lanes, WaitingAny* top) {
    for (; lanes != 0; lanes &= lanes - 1) (top++)->place = node.children[std::countr_zero(lanes)];
    return top;
  }
};

}  // namespace
}  // namespace etendue
