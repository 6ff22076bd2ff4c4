// The memory that a method keeps beside the scene, the structure and the image: an estimate from its parameters, before it is
// prepared.
//
// Bytes per photon and per pixel were measured (tests/unit/memory_forecast_test.cpp holds the sums to the bytes): a photon
// takes 46 bytes (Photons), and up to 115 while a map is built, its structure included; a pixel takes what the method notes of
// it. What grows with what is found (cells, records, a guide) is that of a diffuse room after some dozens of iterations. For
// `auto` it is the largest of what may be chosen.
#pragma once

#include "framework/core/params.h"
#include "framework/scene/needs.h"

#include <string>

namespace etendue {

struct MethodMemory {
  double photons = 0;       // bytes
  double pixels = 0;        // bytes: records, cells and the state of pixels
  double photon_count = 0;  // emitted at a time
};

// Throws Error for a method that does not exist.
MethodMemory method_memory(const std::string& integrator, const ParamMap& params, const SceneNeeds& needs, ivec2 resolution);

}  // namespace etendue
