// Records of incident radiance in spherical harmonics, with translation gradients ([Krivanek2005]).
//
// A record holds, for each channel, the coefficients of the radiance over the hemisphere about its normal, and their
// derivatives along two tangents. Light scattered towards the eye is linear in them: a lobe (BSDF times cosine for one outgoing
// direction) is a vector of coefficients, and the answer is the lobe times the weighted mean of what records extrapolate to.
//
// Deviations from [Krivanek2005]. Coefficients are in world axes: turning a lobe costs nothing, so that neither radiance nor
// gradients are ever rotated. Radiance below the horizon is set to the mirror image of that above: without a step at the
// horizon there is no ringing, and all coefficients serve the visible half. Gradients follow the walls between strata as the
// surroundings shift ([Krivanek2005a], after [Ward1992]), with the harmonic in place of the cosine, for strata of equal solid
// angle.
//
// Interpolation, validity radius, rejection of records in front and neighbour clamping are those of irradiance records.
#pragma once

#include "framework/integrator.h"
#include "integrators/caches/records/hemisphere.h"
#include "integrators/caches/records/validity_tree.h"

#include <memory>
#include <optional>

namespace etendue {

// Coefficients of a lobe, or of radiance; index as in spherical_harmonics.h.
using ShLobe = std::vector<Rgb>;

// The lobe of a white diffuse surface, up to l = 6: its product with a record is irradiance over pi.
ShLobe diffuse_lobe(int order, const vec3& normal);

struct RadianceEstimate {
  std::vector<Rgb> coefficients;  // n^2 values, then as many derivatives along the tangent, then along the bitangent
  float inverse_distance = 0;     // mean over the hemisphere, of 1 / distance
  // Variance of the luminance that a lobe reflects, per sum of its squared coefficients; from the differences of neighbouring
  // strata, whose real contrast counts as noise too.
  float variance = 0;

  // Becomes the mean of `passes` equal estimates, of which `next` is the last.
  void average_in(const RadianceEstimate& next, int passes);
};

// `samples`: one per stratum of even_direction, in order, their directions in world axes.
RadianceEstimate estimate_radiance(int order, const HemisphereStrata& strata, std::span<const HemisphereSample> samples,
                                   const Frame& frame);

struct RadianceSpacing {
  float accuracy = 0.2f;      // Ward's a
  float least = 0, most = 1;  // metres that a record serves at least and at most
};

class RadianceRecords {
 public:
  // `overlap`: as of irradiance records.
  RadianceRecords(std::unique_ptr<RecordQuery> index, int order, float accuracy, float overlap = 1)
      : index_(std::move(index)), order_(order), accuracy_(accuracy), answers_(overlap * accuracy) {}

  void insert(const vec3& position, const vec3& normal, const RadianceEstimate& estimate, const RadianceSpacing& spacing,
              bool gradients);
  bool covered(const vec3& position, const vec3& normal) const;
  // The first coefficients of the radiance at a point, as many as asked for: the weighted mean of what the records extrapolate
  // to. The least error of those that serve (a point is covered at every accuracy above it); empty where none does.
  std::optional<float> interpolate(const vec3& position, const vec3& normal, std::span<Rgb> coefficients) const;
  // Standard error of the luminance that a lobe of these coefficients reflects there, if their squares sum to `lobe_square`:
  // from what each record says by itself (error_of_mean.h).
  float standard_error(const vec3& position, const vec3& normal, std::span<const Rgb> lobe, float lobe_square) const;
  void add_shapes(std::vector<RecordShape>& shapes) const;

 private:
  struct Record {
    vec3 position;
    Frame frame;
    float validity_radius;
    float variance;  // as of RadianceEstimate
  };
  float error(const Record& record, const vec3& position, const vec3& normal) const;  // infinite: refused
  float weight(float error) const { return 1 / std::max(error, 1e-4f) - 1 / answers_; }

  std::vector<Record> records_;
  std::vector<Rgb> coefficients_;  // of all records, 3 n^2 each
  std::unique_ptr<RecordQuery> index_;
  ValidityTree validity_;
  int order_;
  float accuracy_, answers_;  // what is covered; what is answered
};

}  // namespace etendue
