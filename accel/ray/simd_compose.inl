// Two vectors side by side as one of twice the width, and stacking by a loop over lanes: for instruction sets narrower than the
// node. Included like wide_traversal.inl.

namespace etendue {
namespace {

template <class Half, int half_width>
struct Twice {
  Half low, high;

  static Twice load(const float* p) { return {Half::load(p), Half::load(p + half_width)}; }
  static Twice set(float x) { return {Half::set(x), Half::set(x)}; }
  void store(float* p) const {
    low.store(p);
    high.store(p + half_width);
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

// What a traversal asks beside arithmetic, lane by lane.
struct LaneByLane {
  template <int width, class Floats>
  static int nearest(const Floats& entries, unsigned met) {
    alignas(64) float entry[width];
    entries.store(entry);
    int best = std::countr_zero(met);
    for (unsigned rest = met & (met - 1); rest != 0; rest &= rest - 1)
      if (entry[std::countr_zero(rest)] < entry[best]) best = std::countr_zero(rest);
    return best;
  }

  template <int width, class Floats, class Waiting>
  static Waiting* stack_places(const WideNode<width>& node, const Floats& entries, unsigned lanes, Waiting* top) {
    alignas(64) float entry[width];
    entries.store(entry);
    for (; lanes != 0; lanes &= lanes - 1) *top++ = {node.children[std::countr_zero(lanes)], entry[std::countr_zero(lanes)]};
    return top;
  }

  template <int width, class Waiting>
  static Waiting* stack_places(const WideNode<width>& node, unsigned lanes, Waiting* top) {
    for (; lanes != 0; lanes &= lanes - 1) (top++)->place = node.children[std::countr_zero(lanes)];
    return top;
  }
};

}  // namespace
}  // namespace etendue
