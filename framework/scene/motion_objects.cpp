// Motions of objects: a geometry cut into parts that keep their shape.
#include "framework/core/elementary.h"
#include "framework/core/rng.h"
#include "framework/scene/motion.h"
#include "framework/scene/transform.h"

#include <numeric>

namespace etendue {

namespace {

struct Part {
  std::vector<std::uint32_t> primitives;           // ascending
  std::uint32_t first_vertex = 0, vertex_end = 0;  // of the split geometry
  vec3 centre{0};                                  // of its box
};

// Cuts [begin, end) of `ids` into `count` runs of primitives, halving where the centres spread most.
void cut(std::span<std::uint32_t> ids, const std::vector<vec3>& centres, int count, std::vector<Part>& parts) {
  if (count == 1 || ids.size() < 2) {
    if (!ids.empty()) parts.push_back({{ids.begin(), ids.end()}, 0, 0, vec3(0)});
    return;
  }
  Bounds spread;
  for (const std::uint32_t id : ids) spread.extend(centres[id]);
  const int axis = spread.longest_axis(), left = count / 2;
  const std::size_t middle = std::clamp<std::size_t>(ids.size() * left / count, 1, ids.size() - 1);
  std::nth_element(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(middle), ids.end(), [&](auto a, auto b) {
    return centres[a][axis] < centres[b][axis] || (centres[a][axis] == centres[b][axis] && a < b);
  });
  cut(ids.first(middle), centres, left, parts);
  cut(ids.subspan(middle), centres, count - left, parts);
}

Quadric moved(const Quadric& quadric, const Transform& by) {
  struct Mover {
    const Transform& by;
    Quadric operator()(Sphere s) const { return s.centre = by.point(s.centre), s; }
    Quadric operator()(Cylinder c) const { return c.base = by.point(c.base), c.axis = by.vector(c.axis), c; }
    Quadric operator()(Disk d) const { return d.centre = by.point(d.centre), d.normal = by.vector(d.normal), d; }
  };
  return std::visit(Mover{by}, quadric);
}

class ObjectMotion : public Motion {
 public:
  ObjectMotion(const MotionTask& task, int objects) : rest_(task.geometry), seed_(task.seed) {
    // Primitives without a finite place belong to no object.
    std::vector<std::uint32_t> ids = rest_.valid_primitives();
    std::vector<vec3> centres(rest_.primitive_count());
    for (const std::uint32_t id : ids) centres[id] = rest_.primitive_bounds(id).centre();
    cut(ids, centres, objects, parts_);
    split_vertices();
    bounds_ = bounds_of(rest_);
  }

  const Geometry& rest() const override { return rest_; }

 protected:
  const std::vector<Part>& parts() const { return parts_; }
  const Bounds& bounds() const { return bounds_; }

  // A generator for an object at a frame.
  Pcg32 generator(std::size_t object, int frame) const { return {hash_keys(seed_, object, frame), object}; }

  static vec3 direction(Pcg32& random) {
    const float z = 1 - 2 * random.next_float(), phi = 2 * pi * random.next_float(), r = safe_sqrt(1 - z * z);
    return {r * math::cos(phi), r * math::sin(phi), z};
  }

  void move(std::size_t object, const Transform& by, Geometry& geometry) const {
    const Part& part = parts_[object];
    for (std::uint32_t v = part.first_vertex; v < part.vertex_end; ++v) geometry.positions[v] = by.point(rest_.positions[v]);
    for (const std::uint32_t id : part.primitives)
      if (!rest_.is_triangle(id)) geometry.quadrics[id - rest_.triangles.size()] = moved(rest_.quadric(id), by);
  }

  std::vector<std::uint32_t> primitives_of(const std::vector<std::size_t>& objects) const {
    std::vector<std::uint32_t> ids;
    for (const std::size_t object : objects)
      ids.insert(ids.end(), parts_[object].primitives.begin(), parts_[object].primitives.end());
    std::sort(ids.begin(), ids.end());
    return ids;
  }

 private:
  void split_vertices() {
    std::vector<vec3> positions;
    std::vector<std::uint32_t> copy(rest_.positions.size()), owner(rest_.positions.size(), no_id);
    for (std::uint32_t p = 0; p < parts_.size(); ++p) {
      Part& part = parts_[p];
      std::sort(part.primitives.begin(), part.primitives.end());
      part.first_vertex = static_cast<std::uint32_t>(positions.size());
      Bounds box;
      for (const std::uint32_t id : part.primitives) {
        box.extend(rest_.primitive_bounds(id));
        for (int k = 0; k < 3 && rest_.is_triangle(id); ++k) {
          std::uint32_t& v = rest_.triangles[id][k];
          if (owner[v] != p) {
            owner[v] = p;
            copy[v] = static_cast<std::uint32_t>(positions.size());
            positions.push_back(rest_.positions[v]);
          }
          v = copy[v];
        }
      }
      part.centre = box.centre();
      part.vertex_end = static_cast<std::uint32_t>(positions.size());
    }
    append_unowned(positions);
    rest_.positions = std::move(positions);
  }

  // Invalid triangles keep vertices of their own, behind all others.
  void append_unowned(std::vector<vec3>& positions) {
    std::vector<bool> owned(rest_.triangles.size());
    for (const Part& part : parts_)
      for (const std::uint32_t id : part.primitives)
        if (rest_.is_triangle(id)) owned[id] = true;
    for (std::size_t id = 0; id < rest_.triangles.size(); ++id)
      for (int k = 0; k < 3 && !owned[id]; ++k) {
        positions.push_back(rest_.positions[rest_.triangles[id][k]]);
        rest_.triangles[id][k] = static_cast<std::uint32_t>(positions.size()) - 1;
      }
  }

  Geometry rest_;
  std::uint64_t seed_;
  std::vector<Part> parts_;
  Bounds bounds_;
};

struct ExplodeParams {
  int objects = 64;
  float distance = 1, spin = 1;
};

template <class Visitor>
void describe(Visitor& v, ExplodeParams& p) {
  v.integer("objects", p.objects, 1, 1000000, "objects", "that the geometry is cut into");
  v.number("distance", p.distance, 0.001, 1000, "diagonals", "that an object of middling speed has flown at the last frame");
  v.number("spin", p.spin, 0, 1000, "turns", "of each object by the last frame");
}

class Explode final : public ObjectMotion {
 public:
  Explode(const MotionTask& task, const ExplodeParams& params)
      : ObjectMotion(task, params.objects), params_(params), frames_(task.frames) {}

  std::vector<std::uint32_t> pose(int frame, Geometry& geometry) override {
    const float time = static_cast<float>(frame) / static_cast<float>(frames_);
    const float far = params_.distance * glm::length(bounds().diagonal());
    std::vector<std::size_t> all(parts().size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    for (const std::size_t object : all) {
      Pcg32 random = generator(object, 0);
      const vec3& centre = parts()[object].centre;
      const vec3 outward = centre - bounds().centre(), axis = direction(random);
      const vec3 course = length_squared(outward) > 0 ? glm::normalize(outward) : direction(random);
      const float speed = 0.5f + random.next_float();
      move(object,
           Transform::translate(centre + time * far * speed * course) * Transform::rotate(2 * pi * params_.spin * time, axis) *
               Transform::translate(-centre),
           geometry);
    }
    return primitives_of(all);
  }

 private:
  ExplodeParams params_;
  int frames_;
};

struct ScatterParams {
  int objects = 64;
  float moving = 0.1f;
};

template <class Visitor>
void describe(Visitor& v, ScatterParams& p) {
  v.integer("objects", p.objects, 1, 1000000, "objects", "that the geometry is cut into");
  v.number("moving", p.moving, 0.000001, 1, "of the objects", "put elsewhere at every frame, at least one");
}

class Scatter final : public ObjectMotion {
 public:
  Scatter(const MotionTask& task, const ScatterParams& params)
      : ObjectMotion(task, params.objects), params_(params), seed_(task.seed) {}

  std::vector<std::uint32_t> pose(int frame, Geometry& geometry) override {
    const std::vector<std::size_t> chosen = choose(frame);
    for (const std::size_t object : chosen) {
      Pcg32 random = generator(object, frame);
      const vec3 share(random.next_float(), random.next_float(), random.next_float()), axis = direction(random);
      move(object,
           Transform::translate(bounds().lower + share * bounds().diagonal()) *
               Transform::rotate(2 * pi * random.next_float(), axis) * Transform::translate(-parts()[object].centre),
           geometry);
    }
    return primitives_of(chosen);
  }

 private:
  // Draws that many different objects, all choices equally likely: a shuffle stopped early.
  std::vector<std::size_t> choose(int frame) const {
    std::vector<std::size_t> objects(parts().size());
    if (objects.empty()) return {};
    std::iota(objects.begin(), objects.end(), std::size_t{0});
    const auto wanted = static_cast<std::size_t>(std::lround(params_.moving * static_cast<float>(objects.size())));
    const std::size_t count = std::clamp<std::size_t>(wanted, 1, objects.size());
    Pcg32 random(hash_keys(seed_, frame), 0x5ca77e5);
    for (std::size_t i = 0; i < count; ++i) std::swap(objects[i], objects[i + random.next() % (objects.size() - i)]);
    objects.resize(count);
    return objects;
  }

  ScatterParams params_;
  std::uint64_t seed_;
};

}  // namespace

MotionEntry explode_entry() { return motion_entry<Explode, ExplodeParams>("explode", "objects fly apart, spinning"); }
MotionEntry scatter_entry() {
  return motion_entry<Scatter, ScatterParams>("scatter",
                                              "at every frame some objects are put at random places, turned at random");
}

}  // namespace etendue
