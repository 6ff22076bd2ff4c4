// Records of irradiance and the interpolation between them ([Ward1988], gradients [Ward1992]).
//
// A record at p_i with normal n_i and reach R_i (the split sphere: harmonic mean distance) is worth
//
//   1 / e - 1 / a    where e = |p - p_i| / R_i + sqrt(1 - n . n_i) < a
//
// to a point p with normal n ([Ward1988]'s weight, less its value at the rim so that records fade in and out without a step
// ([Krivanek2009])); a is the accuracy asked for. A record that lies in front of the point (on the side its normal looks to)
// has seen other surroundings and is refused. Sums run in the order of ids, so a lookup depends on the set of records alone.
#pragma once

#include "framework/query.h"
#include "integrators/hemisphere.h"

#include <memory>
#include <optional>
#include <vector>

namespace etendue {

enum class Gradients : std::uint8_t { none, rotation, both };

struct IrradianceRecord {
  vec3 position;
  vec3 normal;  // unit, on the lit side
  float reach;  // R, metres
  Rgb irradiance;
  mat3 rotation{0}, translation{0};  // as in IrradianceEstimate
};

// R kept between the two spacings a R may have; before that, with translation gradients, no farther than where E would be
// extrapolated to 0, and a gradient that still would is shortened.
IrradianceRecord make_record(const vec3& position, const vec3& normal, const IrradianceEstimate& estimate, Gradients gradients,
                             float accuracy, float min_spacing, float max_spacing);

class IrradianceRecords {
 public:
  IrradianceRecords(std::unique_ptr<BallQuery> balls, float accuracy, bool clamp = false)
      : balls_(std::move(balls)), accuracy_(accuracy), clamp_(clamp) {}

  // With clamping, also shortens what older records reach, so that some of what was covered may no longer be.
  void insert(IrradianceRecord record);
  bool covered(const vec3& position, const vec3& normal) const;
  // Empty where no record serves.
  std::optional<Rgb> interpolate(const vec3& position, const vec3& normal) const;

  const std::vector<IrradianceRecord>& all() const { return records_; }

 private:
  float weight(const IrradianceRecord& record, const vec3& position, const vec3& normal) const;  // 0: refused

  std::vector<IrradianceRecord> records_;
  std::unique_ptr<BallQuery> balls_;
  float accuracy_;
  bool clamp_;
};

}  // namespace etendue
