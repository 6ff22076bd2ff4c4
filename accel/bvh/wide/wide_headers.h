// The headers of the wide_*.inl.
#pragma once

#include "accel/bvh/wide/wide_isa.h"
#include "accel/kernels/counting.h"
#include "accel/kernels/traversal_limit.h"
#include "accel/kernels/traversal_stack.h"
#include "framework/scene/intersect.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <type_traits>

#if defined(__x86_64__)
#include <immintrin.h>
#endif
