// The headers of the wide_*.inl.
#pragma once

#include "accel/bvh/wide/wide_isa.h"
#include "accel/kernels/box_test.h"
#include "accel/kernels/pack_query.h"
#include "accel/kernels/queries.h"
#include "accel/kernels/traversal_stack.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <type_traits>
