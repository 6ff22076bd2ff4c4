// The contract of an integrator, and the context it works in.
#pragma once

#include "framework/core/parallel.h"
#include "framework/core/params.h"
#include "framework/image/film.h"
#include "framework/query.h"
#include "framework/scene/needs.h"
#include "framework/scene/scene.h"
#include "framework/transport/light_sampling.h"

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

// Wall time split by phase: "build", "pilot", "learn", "initial_pass", "emit", "gather", "trace". Time inside no phase is
// "other". A phase that is measured within another is taken from it, so that no time counts twice.
class PhaseTimes {
 public:
  class Scope {
   public:
    Scope(PhaseTimes& times, const char* phase) : times_(times), phase_(phase), outer_(times.innermost_), start_(Clock::now()) {
      if (outer_) outer_->add_until(start_);
      times_.innermost_ = this;
    }
    ~Scope() {
      const Clock::time_point now = Clock::now();
      add_until(now);
      times_.innermost_ = outer_;
      if (outer_) outer_->start_ = now;
    }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    using Clock = std::chrono::steady_clock;
    void add_until(Clock::time_point now) { times_.seconds_[phase_] += std::chrono::duration<double>(now - start_).count(); }

    PhaseTimes& times_;
    const char* phase_;
    Scope* outer_;
    Clock::time_point start_;
  };

  Scope measure(const char* phase) { return Scope(*this, phase); }
  const std::map<std::string, double>& seconds() const { return seconds_; }

 private:
  std::map<std::string, double> seconds_;
  Scope* innermost_ = nullptr;
};

// Says how far the caller means to take a method; 0: it does not say. Methods may choose by it, but none owns a clock.
struct Effort {
  double seconds = 0;            // preparation included
  std::uint64_t iterations = 0;  // at most
  double error = 0;              // relMSE to reach
};

struct RenderContext {
  const Scene& scene;
  const SceneNeeds& needs;
  const RayQuery& rays;
  LightSampler& lights;
  std::uint64_t seed = 0;
  ivec2 resolution{0};
  PhaseTimes& phases;
  // Structures by name, so that integrators need not know accel/. Throw Error on an unknown name.
  std::function<std::unique_ptr<PointQuery>(const std::string& name)> make_points;
  std::function<std::unique_ptr<RecordQuery>(const std::string& name, const Bounds& bounds)> make_records;
  bool states_error = false;  // Cache::standard_error() will be called: keep what it needs
  Effort effort = {};
  Tile window = {};  // the pixels that will be looked at; empty: all
  Bounds bounds = scene.bounds();  // looked up once, since it takes a look at all primitives

  // The part of a tile that will be looked at, which may be empty. It serves methods whose pixels do not depend on each other.
  Tile seen(const Tile& tile) const {
    if (window.end == ivec2(0)) return tile;
    const ivec2 begin = glm::max(tile.begin, window.begin);
    return {begin, glm::max(begin, glm::min(tile.end, window.end))};
  }

  // Sets how light samples choose among lights from now on. Every method that takes any calls it in `prepare`.
  void choose_lights_by(LightChoice choice, DirectSamples samples = DirectSamples::of_lights) {
    const auto timed = phases.measure("build");
    lights.choose_by(choice, samples);
  }
  // The share of rays that a surface stops where this one met it. What is stored there of the rays that are stopped stands for
  // all.
  float stopped_share(const Hit& hit) const { return needs.masks ? scene.opacity_at(hit) : 1; }

  // The depth to use when a method's own parameter is 0: the scene's, else 64.
  int max_depth(int requested) const { return requested > 0 ? requested : scene.max_depth.value_or(64); }
};

enum class Bias : std::uint8_t { unbiased, consistent, biased };

// Says what theory expects of a method as configured.
struct Expectation {
  Bias bias = Bias::unbiased;
  double mse_exponent = -1;  // MSE ~ iterations^exponent; for biased methods until the plateau
  double bias_bound = 0;     // relative bias of the image's mean the method declares for smooth scenes (0 if unbiased)
  std::string note;          // what the bias comes from, with its source
  std::string left_out{};    // light in this scene that the method never finds, or loses, and what does; empty: none is known
};

// A record of a cache as it is shown: it serves surfaces that face as it does, within an ellipse or a cube about it.
struct RecordShape {
  vec3 position, normal;
  float radius = 0;    // metres: the longer semi-axis, or half the edge of the cube
  vec3 anisotropy{0};  // of an ellipse: displacement d counts as sqrt(d.d + (d.anisotropy)^2)
  bool cube = false;   // along the world's axes

  bool covers(const vec3& point) const {
    const vec3 d = point - position;
    return cube ? max_component(glm::abs(d)) <= radius : glm::dot(d, d) + square(glm::dot(d, anisotropy)) <= radius * radius;
  }
};

// Methods that keep a cache offer this in addition.
class Cache {
 public:
  virtual ~Cache() = default;
  // Its records, whether prepared or not.
  virtual std::vector<RecordShape> record_shapes() const = 0;
  // The standard error of each pixel after the iterations so far, as the method itself takes it to be (of its luminance, in all
  // channels). Bias that it knows of counts as error. It is to be called only where RenderContext::states_error is set.
  virtual Image standard_error() const = 0;
  // Can it outlive its image?
  virtual bool savable() const { return true; }
  // The bytes of a file, after the last iteration.
  virtual std::string save(const RenderContext& context) const = 0;
  // Called before `prepare`, which then begins with these records. Throws Error where the bytes are damaged, or made for
  // another scene or with other parameters.
  virtual void load(const RenderContext& context, std::string_view bytes, const Location& where) = 0;
};

// Calls come in order: prepare once, then iteration 0, 1, 2, ... Everything an integrator does depends on (scene, parameters,
// seed, index) alone. It owns no clock and no budget.
class Integrator {
 public:
  virtual ~Integrator() = default;
  virtual void prepare(RenderContext& context) = 0;
  virtual void iteration(RenderContext& context, std::uint32_t index, Film& film) = 0;
  virtual Expectation expectation() const = 0;
  virtual Cache* cache() { return nullptr; }  // null: the method keeps none
  // Null: the method stands for itself, or has not been prepared.
  virtual const MethodChoice* choice() const { return nullptr; }
};

// A row of the registry.
struct IntegratorEntry {
  std::string name, summary;
  std::vector<ParamInfo> params;
  std::function<std::unique_ptr<Integrator>(const ParamMap&)> make;  // throws Error on bad parameters
  double bytes_a_pixel = 0;                                          // that are kept of each beside the image, as measured
};

// The row of a method that make(params) makes.
template <class Params, class Make>
IntegratorEntry integrator_entry(const std::string& name, const std::string& summary, const Make& make,
                                 double bytes_a_pixel = 0) {
  return {name, summary, list_params<Params>(),
          [name, make](const ParamMap& map) -> std::unique_ptr<Integrator> { return make(read_params<Params>(map, name)); },
          bytes_a_pixel};
}
template <class Method, class Params>
IntegratorEntry integrator_entry(const std::string& name, const std::string& summary, double bytes_a_pixel = 0) {
  return integrator_entry<Params>(
      name, summary, [](const Params& params) { return std::make_unique<Method>(params); }, bytes_a_pixel);
}

}  // namespace etendue
