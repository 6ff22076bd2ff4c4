// The headers of the wide_*.inl.
#pragma once

#include "accel/ray/counting.h"
#include "accel/ray/traversal_limit.h"
#include "accel/ray/traversal_stack.h"
#include "accel/ray/wide_isa.h"
#include "framework/scene/intersect.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <type_traits>

#if defined(__x86_64__)
#include <immintrin.h>
#endif
