// Shared by the methods that interpolate irradiance between records, whatever fills these: parameters, the refinement from
// iteration to iteration, the loop over pixels, and the file.
//
// A coarse cache of few rays gives the first image; it is refined by stages (integrators/caches/records/cache_progress.h), each
// of which begins when it lowers the error by more than as much work on camera samples would. Each iteration renders samples of
// each pixel and notes where the next accuracy is not met. A stage begins with more passes over the hemispheres of the records
// there are and, unless noise outweighs their error of interpolation, with new records there. What the cache adds to a pixel is
// averaged, the first stages with less weight. Pixels that scatter take more camera samples than others
// (integrators/paths/sample_shares.h). Without `refine` the cache is filled before the first iteration and stays as it is.
//
// A cache can be saved and loaded (integrators/caches/records/record_file.h). Loaded records serve any view of the same scene;
// what they do not cover gets new ones. The refinement goes on at the stage where it stood, but for what was noted since that
// began, which is not saved; the camera samples of a new image are counted anew. Loaded for the same view, resolution and seed
// without `refine`, a cache gives the same image as a fresh one, to the bit.
#pragma once

#include "integrators/caches/cache_fill.h"
#include "integrators/caches/records/cache_file.h"
#include "integrators/caches/records/record_file.h"
#include "integrators/caches/rough_cache.h"
#include "integrators/paths/sample_shares.h"

namespace etendue {

struct RecordParams {
  float accuracy = 0.2f;
  bool refine = true;
  int samples = 256;
  float min_spacing = 1.5f;
  float max_spacing = 0.1f;
  float extra_samples = 2;
  int max_depth = 0;
  SamplerKind sampler = SamplerKind::sobol;
  LightChoice lights = LightChoice::by_need;
};

template <class Visitor>
void describe_records(Visitor& v, RecordParams& p) {
  v.number("accuracy", p.accuracy, 0.001, 1, "1",
           "Ward's a: the error at which a record no longer serves; smaller, more records");
  v.flag("refine", p.refine, "records and passes over them are added as iterations go on; off: filled once");
  v.integer("samples", p.samples, 1, 100000000, "rays", "over the hemisphere of a record, per pass");
  v.number("min_spacing", p.min_spacing, 0, 1000, "pixels", "a record serves at least this far");
  v.number("max_spacing", p.max_spacing, 0, 1, "scene diagonals", "and at most this far");
  v.number("extra_samples", p.extra_samples, 0, 31, "camera samples",
           "beyond one per pixel and iteration, at most on the mean: as many for each, or given to the pixels that scatter "
           "most; none where light is smooth, or photons that are new in each iteration leave most of the noise");
  v.integer("max_depth", p.max_depth, 0, 65536, "scattering events", "longest path; 0: as the scene states, else 64");
  v.choice("sampler", p.sampler, "random numbers");
  describe_lights(v, p.lights);
}

struct CacheParams : RecordParams {
  CacheMetric metric = CacheMetric::bounded_split_sphere;
  Gradients gradients = Gradients::both;
  bool neighbour_clamping = true;
};

template <class Visitor>
void describe_cache(Visitor& v, CacheParams& p) {
  v.choice("metric", p.metric,
           "how far a record serves, from what its hemisphere saw; split-sphere and tabellion know no spacings, Hessians "
           "min_spacing alone");
  describe_records(v, p);
  v.choice("gradients", p.gradients,
           "with which records are extrapolated: both adds translation; mesh takes that from the mesh of samples");
  v.flag("neighbour_clamping", p.neighbour_clamping, "records reach no farther than their neighbours and the way to them");
}

// `structure`: what finds the records.
RecordSettings record_settings(const RecordParams& params, const std::string& structure);
CacheSettings cache_settings(const CacheParams& params, const std::string& structure);

class RecordCache : public Integrator, public FileCache {
 public:
  void iteration(RenderContext& context, std::uint32_t index, Film& film) final;
  Cache* cache() final { return this; }
  std::vector<RecordShape> record_shapes() const final;
  Image standard_error() const final { return cached_.standard_error(); }

 protected:
  // The result of a camera sample.
  struct CameraSample {
    ivec2 pixel;
    std::uint64_t key;    // of the pixel
    std::uint32_t index;  // among the pixel's samples
    Sampler sampler;
    Rgb sampled{0},
        cached{0};           // by paths, light samples and photons; by the cache, or by what stands in where it has no answer
    float cached_error = 0;  // standard error of the cache's, of its luminance, where `states_error`
    bool states_error = false;
    CachePoint wanted{};        // the first point that the next accuracy leaves uncovered
    CachePoint wanted_rough{};  // likewise, of rough surfaces
  };

  // `records`: the number to fill it to; 0: as many as the accuracy asks for. `samples`: rays of a record, per pass.
  RecordCache(const RecordParams& params, int records, int samples)
      : records_wanted_(records),
        samples_(samples),
        sampler_(params.sampler),
        asked_depth_(params.max_depth),
        progress_{params.accuracy, params.refine} {}

  // Brings photons and records to the state of an iteration, whose stage has been entered.
  virtual void refine(RenderContext& context, std::uint32_t index) = 0;
  virtual void camera_samples(const RenderContext& context, float next_accuracy, std::span<CameraSample> samples) const = 0;

  // In camera samples: what a ray of a record costs, the photons of an iteration, and all photons that records were made with.
  virtual double ray_work() const { return EffortSplit::ray_work; }
  virtual double photon_work() const { return 0; }
  virtual double photon_record_work() const { return 0; }
  // Do records need new photons in every iteration, whatever error they state?
  virtual bool made_anew() const { return false; }

  bool has_overture() const { return progress_.refines && records_wanted_ == 0; }
  std::uint32_t stage() const { return standing_.stage(); }
  // The round of random numbers and photons, of which none is drawn again after loading.
  std::uint32_t round_of(std::uint32_t index) const { return progress_.refines ? standing_.first_round() + index : index; }
  bool shares_levels() const { return max_depth_ > shared_above; }

  // The points that the centres of pixels see with less than `deepest` events before them.
  std::vector<CachePoint> seen_points(const RenderContext& context, int deepest, const RoughMaterials* rough_materials) const;
  // Without records yet. `standing_` has begun, and `rough_` is there or not.
  void start(const RenderContext& context, const CacheSettings& settings, std::vector<CachePoint> seen, float extra_samples);
  // Makes the records that the first iteration expects, or takes those that were loaded.
  void fill_before(const RenderContext& context);
  // Fills or refines the records as the stage asks for; `anew`: those of earlier stages go, as they do in the overture.
  void refine_records(const RenderContext& context, bool anew, double passes);
  void write(ByteWriter& body) const final;
  void read(const RenderContext& context, ByteReader& body) final;

  const int records_wanted_, samples_;
  const SamplerKind sampler_;
  const int asked_depth_;
  int max_depth_ = 0;
  MisMode direct_ = MisMode::light;  // of direct light where no path goes on
  CacheProgress progress_;
  CacheStanding standing_;
  std::unique_ptr<CacheLevels> cache_;
  std::optional<RoughCache> rough_;
  HemisphereRadiance radiance_;

 private:
  void fill(const RenderContext& context, float accuracy);
  void clear(const RenderContext& context);
  void take_rays();
  void choose_stage(std::uint32_t index);
  void measure_split();

  std::vector<CachePoint> wanted_, wanted_rough_;  // by pixel
  CachedLight cached_;
  SampleShares shares_;
  EffortSplit split_;
  double iterations_work_ = 0;                     // of their photons
  std::vector<float> stated_;                      // standard errors by records, by pixel; below 0: not asked for
  std::uint32_t filled_stage_ = no_id;             // for which the records are
  std::vector<std::vector<RecordHistory>> saved_;  // by level, until they are used
};

}  // namespace etendue
