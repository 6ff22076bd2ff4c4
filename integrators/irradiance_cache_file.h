// What a file of an irradiance cache holds after its key (cache_file.h): the histories of its records, from which the records
// are made again, and where the refinement stood.
//
//   u64  view: hash of scene, camera, resolution and seed for which it was filled last
//   u64  key salt (CacheLevels::resume)
//   u32  rounds of refinement behind it
//   f32  accuracy reached
//   u64  number of levels; of each: u64 number of records; of each:
//          f32 position[3], normal[3], geometric normal[3], pixel width; i32 depth; u64 key; i32 passes; their mean:
//          f32 irradiance[3], inverse distance, least distance, variance, rotation[9], translation[9]; f64 hessian[3],
//          geometric[3]
//
// In a file of a radiance cache all that is one text, after which stand the records of rough surfaces (rough_cache_file.cpp).
#pragma once

#include "integrators/cache_file.h"
#include "integrators/cache_fill.h"

#include <span>
#include <string>
#include <vector>

namespace etendue {

struct SavedIrradianceCache {
  std::uint64_t view = 0, key_salt = 0;
  std::uint32_t rounds = 0;
  float accuracy = 0;
  std::vector<std::vector<RecordHistory>> levels;
};

std::string write_irradiance_cache(const SavedIrradianceCache& cache, std::span<const std::span<const RecordHistory>> levels);

// Throws Error unless every value is one that a cache can hold: `one_level`, all depths share the first level.
SavedIrradianceCache read_irradiance_cache(std::string_view body, bool one_level, const Location& where);

}  // namespace etendue
