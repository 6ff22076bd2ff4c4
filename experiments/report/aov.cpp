#include "experiments/report/aov.h"

#include "framework/core/check.h"
#include "framework/core/lists.h"
#include "framework/core/parallel.h"

#include <algorithm>

namespace etendue {
namespace {

constexpr int rays_across = 4;  // of a pixel, where a mean is taken

// Gives the albedo of the surface that a material is part of, for light along its normal.
struct AlbedoStraightOn {
  const std::vector<Texture>& textures;
  const vec2& uv;

  Rgb operator()(const Diffuse& m) const { return evaluate(m.reflectance, textures, uv); }
  Rgb operator()(const Conductor& m) const { return m.ideal ? m.tint : m.tint * fresnel_conductor(1.0f, m.eta, m.k); }
  Rgb operator()(const Dielectric& m) const {
    const float once = fresnel_dielectric(1.0f, m.eta);
    return glm::mix(m.transmit_tint, m.reflect_tint, m.thin ? 2 * once / (1 + once) : once);
  }
  Rgb operator()(const DiffuseTransmission& m) const {
    return evaluate(m.reflectance, textures, uv) + evaluate(m.transmittance, textures, uv);
  }
  // The base's part is integrated over all directions.
  Rgb operator()(const Plastic& m) const {
    const Rgb base = evaluate(m.reflectance, textures, uv);
    const float reflected = fresnel_dielectric(1.0f, m.coat.eta()), entering = (1 - reflected) * m.coat.passing(1.0f);
    return reflected + entering * m.coat.leaving() * base / (1.0f - m.coat.internal_reflectance() * base);
  }
};

struct SeenSurface {
  const Scene& scene;
  const Ray& ray;
  const Hit& hit;
  const SurfacePoint& point;
};

dvec3 albedo_of(const SeenSurface& s) {
  return dvec3(std::visit(AlbedoStraightOn{s.scene.textures, s.point.uv}, s.scene.materials[s.point.material]));
}
dvec3 normal_of(const SeenSurface& s) {
  return dvec3(glm::dot(s.point.normal, s.ray.direction) > 0 ? -s.point.shading_normal : s.point.shading_normal);
}
dvec3 position_of(const SeenSurface& s) { return dvec3(s.point.position) + dvec3(s.scene.origin); }
dvec3 depth_of(const SeenSurface& s) { return dvec3(s.hit.t); }
dvec3 primitive_of(const SeenSurface& s) {
  if (s.hit.instance == plane_instance) return {s.hit.primitive, -2, -2};
  return {s.hit.primitive, s.hit.instance, s.scene.instances[s.hit.instance].object};
}
dvec3 material_number_of(const SeenSurface& s) { return dvec3(s.point.material); }

struct SurfaceImage {
  std::string_view name;
  dvec3 (*value)(const SeenSurface&);
  double nothing;  // where nothing is seen
  bool is_mean;
};
constexpr SurfaceImage surface_images[] = {{"albedo", albedo_of, 0, true},         {"normal", normal_of, 0, true},
                                           {"position", position_of, 0, false},    {"depth", depth_of, infinity, false},
                                           {"primitive", primitive_of, -1, false}, {"material", material_number_of, -1, false}};

dvec3 seen_at(const SurfaceImage& image, const RenderContext& context, const vec2& film) {
  const Ray ray = context.scene.camera.ray(context.resolution, film, vec2(0.5f));
  const Hit hit = context.rays.closest(ray);
  if (!hit) return dvec3(image.nothing);
  return image.value({context.scene, ray, hit, context.scene.surface_at(ray, hit)});
}

}  // namespace

std::vector<std::string> aov_names() {
  std::vector<std::string> names{records_aov, standard_error_aov};
  for (const SurfaceImage& image : surface_images) names.emplace_back(image.name);
  return names;
}

bool is_surface_image(const std::string& name) { return contains(mapped(surface_images, &SurfaceImage::name), name); }

Image draw_surface_image(const std::string& name, const RenderContext& context) {
  CHECK(is_surface_image(name));
  const SurfaceImage& kind = *std::ranges::find(surface_images, name, &SurfaceImage::name);
  const int across = kind.is_mean ? rays_across : 1;
  Image image(context.resolution);
  parallel_pixels(context.resolution, [&](ivec2 pixel) {
    dvec3 sum(0);
    for (int i = 0; i < across * across; ++i) {
      const vec2 within = (vec2(i % across, i / across) + 0.5f) / static_cast<float>(across);
      sum += seen_at(kind, context, vec2(pixel) + within);
    }
    image.at(pixel.x, pixel.y) = sum / static_cast<double>(across * across);
  });
  return image;
}

namespace {

constexpr double dimmed = 0.35;              // of the picture that stays
constexpr double rim_strength = 0.75;        // of a rim's colour
constexpr float faces = 0.9f;                // least cosine between a record's normal and the surface's
constexpr float flat = 0.2f;                 // sine of the angle above which two neighbouring pixels lie on different surfaces
constexpr float same_point = 2e-3f;          // of the distance: what a centre's own ray may miss it by
constexpr double lowest = 0.05, top = 0.95;  // records whose radii span the colours

struct SeenPoint {
  vec3 position{0}, normal{0};  // towards the camera
  bool surface = false;
};

SeenPoint see(const RenderContext& context, const vec2& film) {
  const Ray ray = context.scene.camera.ray(context.resolution, film, vec2(0.5f));
  const Hit hit = context.rays.closest(ray);
  if (!hit) return {};
  const SurfacePoint point = context.scene.surface_at(ray, hit);
  return {point.position, glm::dot(point.normal, ray.direction) > 0 ? -point.normal : point.normal, true};
}

class RadiusColours {
 public:
  explicit RadiusColours(std::span<const RecordShape> records) {
    std::vector<float> radii;
    for (const RecordShape& record : records)
      if (record.radius > 0) radii.push_back(record.radius);
    if (radii.empty()) return;
    const auto at = [&](double share) {
      const auto place = radii.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(radii.size() - 1));
      std::nth_element(radii.begin(), place, radii.end());
      return *place;
    };
    least_ = at(lowest);
    most_ = at(top);
  }

  dvec3 of(float radius) const {
    const double span = std::log(most_ / least_);
    const double x = span > 0 ? 3 * std::clamp(std::log(radius / least_) / span, 0.0, 1.0) : 1.5;
    static constexpr dvec3 steps[] = {{1, 0.12, 0.05}, {1, 0.8, 0.05}, {0.1, 0.85, 0.25}, {0.15, 0.4, 1}};
    const int i = std::min(2, static_cast<int>(x));
    return glm::mix(steps[i], steps[i + 1], x - i);
  }

 private:
  float least_ = 1, most_ = 1;
};

class Overlay {
 public:
  Overlay(const RenderContext& context, std::span<const RecordShape> records)
      : context_(context), records_(records), colours_(records), size_(context.resolution) {}

  Image draw(const Image& image) {
    out_ = image;
    for (dvec3& pixel : out_.pixels) pixel *= dimmed;
    find_covering();
    draw_rims();
    draw_centres();
    return std::move(out_);
  }

 private:
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * size_.x + x; }

  static float reach(const RecordShape& record) { return record.radius * (record.cube ? std::sqrt(3.0f) : 1.0f); }
  bool covers(std::uint32_t id, const SeenPoint& point) const {
    const RecordShape& record = records_[id];
    return point.surface && record.covers(point.position) && glm::dot(point.normal, record.normal) > faces;
  }

  void find_covering() {
    Bounds bounds;
    for (const RecordShape& record : records_) bounds.extend(record.position);
    const auto records = context_.make_records("octree", bounds);
    for (std::size_t i = 0; i < records_.size(); ++i)
      records->insert(records_[i].position, reach(records_[i]), static_cast<std::uint32_t>(i));
    seen_.resize(out_.pixels.size());
    covering_.resize(out_.pixels.size());
    parallel_pixels(size_, [&](ivec2 pixel) {
      static thread_local Neighbours found;
      SeenPoint& point = seen_[index(pixel.x, pixel.y)];
      point = see(context_, vec2(pixel) + 0.5f);
      if (!point.surface) return;
      records->covering(point.position, found);
      for (const Neighbour& n : found)
        if (covers(n.id, point)) covering_[index(pixel.x, pixel.y)].push_back(n.id);
    });
  }

  bool same_surface(const SeenPoint& a, const SeenPoint& b) const {
    const vec3 way = b.position - a.position;
    return a.surface && b.surface && std::abs(glm::dot(way, a.normal)) <= flat * glm::length(way) &&
           glm::dot(a.normal, b.normal) > faces;
  }

  // The innermost pixels of a record, beside one of the same surface that is outside. Of several rims the smallest record's
  // shows. Cubes lie side by side: the one before draws what parts them.
  void draw_rims() {
    parallel_pixels(size_, [&](ivec2 pixel) {
      const SeenPoint& point = seen_[index(pixel.x, pixel.y)];
      float radius = infinity;
      for (const ivec2 step : {ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1)}) {
        const ivec2 beside = pixel + step;
        if (beside.x < 0 || beside.y < 0 || beside.x >= size_.x || beside.y >= size_.y) continue;
        const SeenPoint& other = seen_[index(beside.x, beside.y)];
        if (!same_surface(point, other)) continue;
        for (const std::uint32_t id : covering_[index(pixel.x, pixel.y)])
          if (!covers(id, other) && !(records_[id].cube && step.x + step.y < 0)) radius = std::min(radius, records_[id].radius);
      }
      if (std::isfinite(radius)) blend(pixel, colours_.of(radius), rim_strength);
    });
  }

  void draw_centres() {
    const int half = std::max(size_.x, size_.y) >= 200 ? 1 : 0;
    for (const RecordShape& record : records_) {
      if (record.cube) continue;  // its centre lies on no surface
      const auto connection = context_.scene.camera.connect(size_, record.position, vec2(0.5f));
      if (!connection) continue;
      const SeenPoint point = see(context_, connection->film);
      const float distance = glm::length(record.position - connection->lens_point);
      if (!point.surface || glm::length(point.position - record.position) > same_point * distance ||
          glm::dot(point.normal, record.normal) <= faces)
        continue;
      const ivec2 centre(connection->film);
      for (int y = std::max(0, centre.y - half); y <= std::min(size_.y - 1, centre.y + half); ++y)
        for (int x = std::max(0, centre.x - half); x <= std::min(size_.x - 1, centre.x + half); ++x)
          blend({x, y}, x == centre.x && y == centre.y ? dvec3(1) : colours_.of(record.radius), 1);
    }
  }

  void blend(ivec2 pixel, const dvec3& colour, double strength) {
    dvec3& value = out_.at(pixel.x, pixel.y);
    value = glm::mix(value, colour, strength);
  }

  const RenderContext& context_;
  std::span<const RecordShape> records_;
  RadiusColours colours_;
  ivec2 size_;
  Image out_;
  std::vector<SeenPoint> seen_;                       // by pixel
  std::vector<std::vector<std::uint32_t>> covering_;  // records, by pixel
};

}  // namespace

Image draw_records(const Image& image, const RenderContext& context, std::span<const RecordShape> records) {
  CHECK(image.size == context.resolution);
  return Overlay(context, records).draw(image);
}

}  // namespace etendue
