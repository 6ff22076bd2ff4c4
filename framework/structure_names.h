// Names of the structures that find points and records, for the parameters of methods: integrators name what accel/ holds, and
// include nothing of it. A test keeps these lists equal to the registry's.
#pragma once

#include <initializer_list>

namespace etendue {

inline constexpr std::initializer_list<const char*> point_structure_names = {"brute",     "nanoflann",   "kd-tree",
                                                                             "hash-grid", "sorted-grid", "bvh"};
inline constexpr std::initializer_list<const char*> record_structure_names = {"brute",   "octree", "hash-grid",
                                                                              "kd-tree", "bvh",    "cells"};

}  // namespace etendue
