#include "accel/bvh/wide/wide_bvh.h"

#include "accel/bvh/wide/wide_isa.h"
#include "accel/kernels/pack_query.h"
#include "framework/core/check.h"

namespace etendue {

namespace {

template <int node_width, class Pack>
const WideKernels<node_width, Pack>& kernels_of(const WideKernelSet& set) {
  if constexpr (node_width == 4) return set.bvh4;
  if constexpr (node_width == 8) return set.bvh8;
  if constexpr (node_width == 16) return set.bvh16;
}

}  // namespace

template <int node_width, class Pack>
bool test_rare_leaf(const WideView<node_width, Pack>& view, const Ray& ray, const TriangleRay& shear, WideRef leaf,
                    bool any_hit, Hit& hit) {
  if (leaf.is_none()) return false;
  if (leaf.is_pack()) {
    using Query = PackQuery<Floats<Pack::lanes, native_width>, Pack, false>;
    return Query(ray.origin, shear).test_rare(view.geometry, view.tree.packs[leaf.index()], ray, hit);
  }
  const WideList list = view.tree.lists[leaf.index()];
  bool found = false;
  for (std::uint32_t i = list.first; i < list.first + list.count && !(any_hit && found); ++i)
    found |= intersect_primitive(view.geometry, view.tree.list_ids[i], ray, shear, hit);
  return found;
}

template <int node_width, class Pack>
const WideKernels<node_width, Pack>& wide_kernels(Isa isa) {
  switch (isa) {
    case Isa::scalar:
    case Isa::sse:
      return kernels_of<node_width, Pack>(wide_kernels_four());
#if defined(__x86_64__)
    case Isa::avx2:
      return kernels_of<node_width, Pack>(wide_kernels_avx2());
    case Isa::avx512:
      return kernels_of<node_width, Pack>(wide_kernels_avx512());
#else
    default:
      break;
#endif
  }
  CHECK(!"an instruction set of this machine");
  __builtin_unreachable();
}

// A box is eight floats. Compilers for AVX-512 turn its minima into comparisons and choices, which takes a tenth longer.
const BinnedKernels& binned_kernels(Isa isa) {
#if defined(__x86_64__)
  if (isa >= Isa::avx2) return binned_kernels_avx2();
#endif
  CHECK(isa <= Isa::sse);
  return binned_kernels_four();
}

template bool test_rare_leaf(const WideView<4, TrianglePack<4>>&, const Ray&, const TriangleRay&, WideRef, bool, Hit&);
template bool test_rare_leaf(const WideView<8, TrianglePack<8>>&, const Ray&, const TriangleRay&, WideRef, bool, Hit&);
template bool test_rare_leaf(const WideView<16, SharedPack>&, const Ray&, const TriangleRay&, WideRef, bool, Hit&);
template const WideKernels<4, TrianglePack<4>>& wide_kernels(Isa);
template const WideKernels<8, TrianglePack<8>>& wide_kernels(Isa);
template const WideKernels<16, SharedPack>& wide_kernels(Isa);

static_assert(RayStructure<Bvh4> && RayStructure<Bvh8> && RayStructure<Bvh16>);

}  // namespace etendue
