#include "framework/scene/motion.h"

#include "framework/core/elementary.h"

#include <optional>

namespace etendue {

namespace {

vec3& anchor(Quadric& quadric) { return const_cast<vec3&>(etendue::anchor(std::as_const(quadric))); }

// A motion that gives each point a place for each frame.
class Deformation : public Motion {
 public:
  explicit Deformation(const Geometry& geometry) : rest_(geometry), bounds_(bounds_of(geometry)) {}
  const Geometry& rest() const override { return rest_; }

  std::vector<std::uint32_t> pose(int frame, Geometry& geometry) override {
    for (std::size_t i = 0; i < rest_.positions.size(); ++i)
      if (moves(rest_.positions[i])) geometry.positions[i] = place(rest_.positions[i], frame);
    for (std::size_t i = 0; i < rest_.quadrics.size(); ++i)
      if (const vec3& p = etendue::anchor(rest_.quadrics[i]); moves(p)) anchor(geometry.quadrics[i]) = place(p, frame);
    if (!moving_) moving_ = moving_primitives();
    return *moving_;
  }

 protected:
  virtual bool moves(const vec3& p) const = 0;
  virtual vec3 place(const vec3& p, int frame) const = 0;

  const Bounds& bounds() const { return bounds_; }
  float diagonal() const { return glm::length(bounds_.diagonal()); }

 private:
  std::vector<std::uint32_t> moving_primitives() const {
    std::vector<std::uint32_t> moving;
    for (std::uint32_t id = 0; id < rest_.primitive_count(); ++id) {
      bool any = false;
      if (rest_.is_triangle(id))
        for (int k = 0; k < 3; ++k) any |= moves(rest_.positions[rest_.triangles[id][k]]);
      else
        any = moves(etendue::anchor(rest_.quadric(id)));
      if (any) moving.push_back(id);
    }
    return moving;
  }

  Geometry rest_;
  Bounds bounds_;
  std::optional<std::vector<std::uint32_t>> moving_;
};

struct WaveParams {
  float amplitude = 0.05f, length = 0.4f, period = 20, moving = 1;
};

template <class Visitor>
void describe(Visitor& v, WaveParams& p) {
  v.number("amplitude", p.amplitude, 0.0001, 10, "diagonals", "height of the wave");
  v.number("length", p.length, 0.001, 100, "diagonals", "length of the wave");
  v.number("period", p.period, 1, 1e6, "frames", "in which it passes");
  v.number("moving", p.moving, 0.0001, 1, "of the vertices", "that it moves: the lowest along the longest axis");
}

class Wave final : public Deformation {
 public:
  Wave(const MotionTask& task, const WaveParams& params)
      : Deformation(task.geometry), params_(params), axis_(bounds().longest_axis()) {
    std::vector<float> along;
    for (const vec3& p : task.geometry.positions)
      if (is_finite(p)) along.push_back(p[axis_]);
    for (const Quadric& quadric : task.geometry.quadrics) along.push_back(etendue::anchor(quadric)[axis_]);
    const auto count = static_cast<std::ptrdiff_t>(params.moving * static_cast<float>(along.size()));
    if (params.moving >= 1 || along.empty()) return;
    std::nth_element(along.begin(), along.begin() + count, along.end());
    highest_ = along[static_cast<std::size_t>(count)];
  }

 private:
  bool moves(const vec3& p) const override { return p[axis_] <= highest_; }
  vec3 place(const vec3& p, int frame) const override {
    const float along = (p.x + p.z) / (std::sqrt(2.0f) * params_.length * diagonal());
    const float height = math::sin(2 * pi * (along - static_cast<float>(frame) / params_.period));
    return p + vec3(0, params_.amplitude * diagonal() * height, 0);
  }

  WaveParams params_;
  int axis_;
  float highest_ = infinity;
};

struct TwistParams {
  float turns = 2;
};

template <class Visitor>
void describe(Visitor& v, TwistParams& p) {
  v.number("turns", p.turns, 0.001, 1000, "turns", "between bottom and top at the last frame");
}

class Twist final : public Deformation {
 public:
  Twist(const MotionTask& task, const TwistParams& params)
      : Deformation(task.geometry), turns_per_frame_(params.turns / static_cast<float>(task.frames)) {}

 private:
  bool moves(const vec3&) const override { return true; }
  vec3 place(const vec3& p, int frame) const override {
    const float height = bounds().diagonal().y;
    if (!(height > 0)) return p;
    const vec3 centre = bounds().centre(), r = p - centre;
    const float angle = 2 * pi * turns_per_frame_ * static_cast<float>(frame) * r.y / height;
    const float s = math::sin(angle), c = math::cos(angle);
    return centre + vec3(c * r.x + s * r.z, r.y, c * r.z - s * r.x);
  }

  float turns_per_frame_;
};

}  // namespace

const vec3& anchor(const Quadric& quadric) {
  if (const auto* cylinder = std::get_if<Cylinder>(&quadric)) return cylinder->base;
  if (const auto* disk = std::get_if<Disk>(&quadric)) return disk->centre;
  return std::get<Sphere>(quadric).centre;
}

Bounds bounds_of(const Geometry& geometry) {
  Bounds bounds;
  for (const std::uint32_t id : geometry.valid_primitives()) bounds.extend(geometry.primitive_bounds(id));
  return bounds.empty() ? Bounds{vec3(0), vec3(0)} : bounds;
}

MotionEntry wave_entry() { return motion_entry<Wave, WaveParams>("wave", "a travelling wave lifts and lowers the surface"); }
MotionEntry twist_entry() {
  return motion_entry<Twist, TwistParams>("twist", "turned about the vertical axis, ever more with height");
}

std::span<const MotionEntry> motions() {
  static const std::vector<MotionEntry> entries{wave_entry(), twist_entry(), explode_entry(), scatter_entry()};
  return entries;
}

const MotionEntry& find_motion(const std::string& name, const Location& where) {
  std::vector<std::string> names;
  for (const MotionEntry& entry : motions()) {
    if (entry.name == name) return entry;
    names.push_back(entry.name);
  }
  throw Error(where, unknown_name("motion", name, names));
}

}  // namespace etendue
