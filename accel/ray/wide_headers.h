// The headers of wide_traversal.inl.
#pragma once

#include "accel/ray/counting.h"
#include "accel/ray/traversal_limit.h"
#include "accel/ray/traversal_stack.h"
#include "accel/ray/wide_isa.h"
#include "framework/scene/intersect.h"

#include <bit>
#include <type_traits>

#if defined(__x86_64__)
#include <immintrin.h>
#endif
