// Records of irradiance and the interpolation between them ([Ward1988], gradients [Ward1992]).
//
// A record at p_i with normal n_i and validity radius R_i is worth
//
//   1 / e - 1 / a    where e = |p - p_i| / R_i + sqrt(1 - n . n_i) < a
//
// to a point p with normal n ([Ward1988]'s weight, less its value at the rim so that records fade in and out without a step
// ([Krivanek2009])); a is the accuracy asked for. [Tabellion2004] weighs by 1 - e / a, with e the greater of the two terms and
// the normal's in units of ten degrees. A record in front of the point (on the side its normal faces) has seen other
// surroundings and is rejected, and so is one that faces away, whatever the accuracy. Sums run in the order of ids, so a lookup
// depends only on the set of records.
//
// Where the number of records is given rather than the accuracy, gaps between records cannot be filled with more of them: there
// the record of least error answers alone, if that is below `stretch` times the accuracy.
//
// While a cache is refined beyond the requested accuracy, records answer up to `overlap` times the accuracy at which they cover
// (in place of a above). So gaps that open are answered until they hold records, and everywhere more records are averaged,
// which lowers their noise.
#pragma once

#include "framework/query.h"
#include "integrators/caches/records/cache_metric.h"
#include "integrators/caches/records/validity_tree.h"

#include <memory>
#include <optional>
#include <vector>

namespace etendue {

// `both`: rotation, and translation by the walls between strata; `mesh`: from the mesh of the samples (see
// irradiance_hessian.h).
enum class Gradients : std::uint8_t { none, rotation, both, mesh };
constexpr auto names_of(Gradients) { return std::array{"none", "rotation", "both", "mesh"}; }

struct IrradianceRecord {
  vec3 position;
  vec3 normal;            // unit, on the lit side
  float validity_radius;  // R along the longer axis, metres
  Rgb irradiance;
  mat3 rotation{0}, translation{0};  // as in IrradianceEstimate
  vec3 anisotropy{0};                // as in ValidityRadius
  float variance = 0;                // of the irradiance's luminance, as in IrradianceEstimate
  float shared_variance = 0;         // likewise
  float least = 0;                   // as in ValidityRadius

  // Shortens the validity radius to at most `length` along every axis, but not below `least`.
  void shorten(float length);
};

// The validity radius is by a metric, gradients as asked for. A gradient that would extrapolate below 0 within that radius is
// shortened.
IrradianceRecord make_record(const vec3& position, const vec3& normal, const IrradianceEstimate& estimate, Gradients gradients,
                             CacheMetric metric, const MetricContext& context);

struct Interpolated {
  Rgb irradiance;
  float error;               // least e of the records that serve: a point is covered at every accuracy above it
  float standard_error = 0;  // of the irradiance's luminance, where it was asked for (error_of_mean.h)
};

enum class CacheWeight : std::uint8_t { ward, tabellion };

class IrradianceRecords {
 public:
  // `clamp`: by how much the validity radii of neighbours may differ, per distance between them; 0: by any amount.
  IrradianceRecords(std::unique_ptr<RecordQuery> index, float accuracy, float clamp = 0, CacheWeight weight = CacheWeight::ward,
                    float stretch = 1, float overlap = 1)
      : index_(std::move(index)),
        validity_(clamp),
        accuracy_(accuracy),
        answers_(overlap * accuracy),
        farthest_(std::max(stretch, overlap) * accuracy),
        clamps_(clamp > 0),
        weight_(weight) {}

  // With clamping, also shortens the validity radius of older records, so that points they covered may no longer be covered.
  void insert(IrradianceRecord record);
  bool covered(const vec3& position, const vec3& normal) const;
  // Empty where no record serves.
  std::optional<Interpolated> interpolate(const vec3& position, const vec3& normal, bool states_error = false) const;

  const std::vector<IrradianceRecord>& all() const { return records_; }

 private:
  // Infinite: refused, or not below the stretched accuracy.
  float error(const IrradianceRecord& record, const vec3& position, const vec3& normal) const;

  // The record's irradiance, extrapolated to a point by its gradients.
  static Rgb extrapolate(const IrradianceRecord& record, const vec3& position, const vec3& normal);

  std::vector<IrradianceRecord> records_;
  std::unique_ptr<RecordQuery> index_;
  ValidityTree validity_;
  float accuracy_, answers_, farthest_;  // e below which points are covered; records answer together; the nearest answers alone
  bool clamps_;
  CacheWeight weight_;
};

}  // namespace etendue
