#include "integrators/photons/wall_grid.h"

#include "framework/core/parallel.h"
#include "framework/scene/clearance.h"

#include <optional>
#include <span>

namespace etendue {

namespace {

constexpr float most_cells_aside = 64;
constexpr std::uint32_t fine_mesh = 4096;  // triangles: lists soon end there, and long ones take time to fill for nothing
constexpr float same_normal = 0x1p-20f;    // two planes are one within this angle, and within rounding

std::optional<Sheet> sheet_of(const Geometry& geometry, std::uint32_t primitive) {
  const auto plane = [&](const vec3& point, const vec3& normal) {
    return Sheet{normal, glm::dot(point, normal), false, geometry.primitive_bounds(primitive)};
  };
  if (geometry.is_triangle(primitive)) {
    const uvec3 v = geometry.triangles[primitive];
    const vec3 &p0 = geometry.positions[v.x], &p1 = geometry.positions[v.y], &p2 = geometry.positions[v.z];
    return plane(p0, vec3(glm::normalize(glm::cross(dvec3(p1) - dvec3(p0), dvec3(p2) - dvec3(p0)))));
  }
  const Quadric& quadric = geometry.quadric(primitive);
  if (const auto* disk = std::get_if<Disk>(&quadric)) return plane(disk->centre, disk->normal);
  if (const auto* sphere = std::get_if<Sphere>(&quadric))
    return Sheet{sphere->centre, sphere->radius, true, quadric_bounds(quadric)};
  return std::nullopt;
}

// Is it smooth glass that takes nothing of the light on its way, and lets light through to both sides?
bool is_clear(const Material& material) {
  const auto* glass = std::get_if<Dielectric>(&material);
  return glass && glass->has_specular() && glass->transmit_tint == Rgb(1);
}

}  // namespace

// The point's own plane is lowered, so that photons on it are above it: they came from that side, as the side test tells.
void NearWalls::add(const Sheet& sheet, float side, bool own) {
  if (sheet.is_sphere) {
    side_[sphere_count_] = side;
    spheres_[sphere_count_++] = &sheet;
    return;
  }
  const std::uint32_t lane = plane_count_ % 4;
  of_planes_[plane_count_] = &sheet;
  Planes& four = planes_[plane_count_++ / 4];
  if (lane == 0) four = {Floats{}, Floats{}, Floats{}, Floats{} - infinity};  // those behind the last hide nothing
  const vec3 normal = side * sheet.normal_or_centre;
  four.x[lane] = normal.x;
  four.y[lane] = normal.y;
  four.z[lane] = normal.z;
  four.height[lane] = side * sheet.height_or_radius - (own ? 2 * rounding_ : 0);
}

// Does the way to `end` meet something that lies on a plane? What separates the point from where a photon landed within the
// radius stands on a sheet that is listed, on which the photon did not land from the point's side.
bool NearWalls::crosses_plane(const vec3& end) const {
  for (std::uint32_t first = 0; first < plane_count_; first += 4) {
    const Planes& four = planes_[first / 4];
    const Floats there = four.heights(end), here = four.heights(position_);
    const auto beyond = ~(there > rounding_);
    if (!any(beyond)) continue;
    for (std::uint32_t i = first; i < std::min(first + 4, plane_count_); ++i) {
      if (beyond[i % 4] == 0) continue;
      // The point where the way meets the plane; not a number where floats cannot tell.
      const vec3 at = position_ + here[i % 4] / (here[i % 4] - there[i % 4]) * (end - position_);
      if (!of_planes_[i]->is_beside(at, 4 * rounding_)) return true;
    }
  }
  return false;
}

bool NearWalls::crosses_sphere(const vec3& landed, const vec3& end) const {
  for (std::uint32_t i = 0; i < sphere_count_; ++i) {
    const float there = spheres_[i]->height(landed) * side_[i];
    if (!(there > rounding_) && !(spheres_[i]->height(end) * side_[i] > rounding_)) return true;
  }
  return false;
}

// Layers of cells that one thread fills: the sheets of each, by the primitives in their order.
class WallGrid::Slab {
 public:
  Slab(const WallGrid& grid, std::uint32_t begin, std::uint32_t end)
      : grid_(grid), begin_(begin), end_(end), lists_(std::size_t{end - begin} * grid.size_.y * grid.size_.x) {}

  // The primitives `ids` of the object; `boxes`: of all.
  void add(const Object& object, std::span<const std::uint32_t> ids, std::span<const Bounds> boxes,
           const std::vector<Material>& materials) {
    for (const std::uint32_t id : ids) {
      const Range range = grid_.cells_about(boxes[id]);
      if (has_room(range) && !is_clear(materials[object.shape(id).material])) add(range, sheet_of(object.geometry, id));
    }
  }
  // No sheet: of a surface that is neither plane nor sphere.
  void add(const Range& range, const std::optional<Sheet>& sheet) {
    const float reach = grid_.radius_ + 0.87f * grid_.cell_size_;  // half a cell's diagonal
    for (uvec3 c(0, 0, std::max(range.begin.z, begin_)); c.z < std::min(range.end.z, end_); ++c.z)
      for (c.y = range.begin.y; c.y < range.end.y; ++c.y)
        for (c.x = range.begin.x; c.x < range.end.x; ++c.x) {
          List& list = lists_[index(c)];
          const vec3 centre = grid_.centre(c);
          if (list.too_many || (sheet && std::abs(sheet->height(centre)) > reach)) continue;
          if (sheet && holds(list, *sheet, centre)) continue;
          if (!sheet || list.sheets.size() == grid_.longest_list_)
            list = {.too_many = true, .sheets = {}};
          else
            list.sheets.push_back(*sheet);
        }
  }
  // Cells whose lists are those of a neighbour share them: most do, and lists that are near in memory are found fast.
  void move_to(std::vector<Cell>& cells, std::vector<Sheet>& sheets) const {
    const std::size_t row = grid_.size_.x, layer = row * grid_.size_.y, before = cells.size();
    for (std::size_t i = 0; i < lists_.size(); ++i) {
      const List& list = lists_[i];
      Cell cell{static_cast<std::uint32_t>(sheets.size()),
                static_cast<std::uint32_t>(list.too_many ? NearWalls::too_many : list.sheets.size())};
      bool shared = false;
      for (const std::size_t back : {std::size_t{1}, row, layer})
        if (!shared && back <= i && lists_[i - back].sheets == list.sheets) {
          cell.first = cells[before + i - back].first;
          shared = true;
        }
      cells.push_back(cell);
      if (!shared) sheets.insert(sheets.end(), list.sheets.begin(), list.sheets.end());
    }
  }

 private:
  struct List {
    bool too_many = false;
    std::vector<Sheet> sheets;
  };

  std::size_t index(const uvec3& c) const { return (std::size_t{c.z - begin_} * grid_.size_.y + c.y) * grid_.size_.x + c.x; }

  // Is there a cell whose list one more sheet may change? About a fine mesh there soon is none.
  bool has_room(const Range& range) const {
    for (uvec3 c(0, 0, std::max(range.begin.z, begin_)); c.z < std::min(range.end.z, end_); ++c.z)
      for (c.y = range.begin.y; c.y < range.end.y; ++c.y)
        for (c.x = range.begin.x; c.x < range.end.x; ++c.x)
          if (!lists_[index(c)].too_many) return true;
    return false;
  }

  // Has the list the sheet? Then the sheet's surfaces lie on that one, too.
  bool holds(List& list, const Sheet& sheet, const vec3& centre) const {
    const float height = sheet.height(centre);
    const auto same = std::find_if(list.sheets.begin(), list.sheets.end(), [&](const Sheet& other) {
      if (other.is_sphere || sheet.is_sphere)
        return other.is_sphere && sheet.is_sphere && other.normal_or_centre == sheet.normal_or_centre &&
               other.height_or_radius == sheet.height_or_radius;
      const float side = glm::dot(other.normal_or_centre, sheet.normal_or_centre) < 0 ? -1 : 1;
      return length_squared(other.normal_or_centre - side * sheet.normal_or_centre) <= square(same_normal) &&
             std::abs(other.height(centre) - side * height) <= 2 * grid_.rounding_;
    });
    if (same == list.sheets.end()) return false;
    same->bounds.extend(sheet.bounds);
    return true;
  }

  const WallGrid& grid_;
  std::uint32_t begin_, end_;
  std::vector<List> lists_;
};

WallGrid::WallGrid(const Scene& scene, float radius) : radius_(radius) {
  const Geometry& geometry = scene.objects[0].geometry;
  longest_list_ = geometry.primitive_count() > fine_mesh ? most_sheets / 2 : most_sheets;
  std::vector<Bounds> boxes(geometry.primitive_count());  // empty where nothing may be held
  parallel_for(boxes.size(), 1024, [&](std::size_t i) {
    const auto id = static_cast<std::uint32_t>(i);
    if (geometry.is_valid(id)) boxes[i] = geometry.primitive_bounds(id);
  });
  Bounds bounds;
  if (scene.has_instances())
    bounds = scene.bounds();
  else
    for (const Bounds& box : boxes) bounds.extend(box);
  if (bounds.empty()) bounds = {vec3(0), vec3(0)};
  const float extent = std::max(max_component(bounds.diagonal()), std::numeric_limits<float>::min());
  rounding_ = 8 * unit_roundoff * (extent + max_component(glm::max(glm::abs(bounds.lower), glm::abs(bounds.upper))));
  cell_size_ = std::max(radius, extent / most_cells_aside);
  lower_ = bounds.lower;
  cells_per_metre_ = 1 / cell_size_;
  size_ = uvec3(glm::min(bounds.diagonal() * cells_per_metre_, vec3(most_cells_aside))) + 1u;

  constexpr std::uint32_t slabs = 8;
  const std::uint32_t layers = (size_.z + slabs - 1) / slabs;
  std::vector<std::optional<Slab>> parts((size_.z + layers - 1) / layers);
  std::vector<std::vector<std::uint32_t>> ids(parts.size());  // of the primitives about each
  for (std::uint32_t id = 0; id < boxes.size(); ++id) {
    if (boxes[id].empty()) continue;
    const Range range = cells_about(boxes[id]);
    for (std::uint32_t i = range.begin.z / layers; i * layers < range.end.z; ++i) ids[i].push_back(id);
  }
  parallel_for(parts.size(), 1, [&](std::size_t i) {
    const auto first = static_cast<std::uint32_t>(i) * layers;
    Slab& slab = parts[i].emplace(*this, first, std::min(first + layers, size_.z));
    slab.add(scene.objects[0], ids[i], boxes, scene.materials);
    for (const InfinitePlane& plane : scene.planes)
      if (!is_clear(scene.materials[plane.material]))
        slab.add({uvec3(0), size_},
                 Sheet{plane.normal, glm::dot(plane.point, plane.normal), false, {vec3(-infinity), vec3(infinity)}});
    // Objects placed elsewhere are not looked into: in their boxes every way is traced.
    for (std::size_t k = 1; k < scene.instances.size(); ++k) {
      const Geometry& geometry = scene.objects[scene.instances[k].object].geometry;
      Bounds local;
      for (const std::uint32_t id : geometry.valid_primitives()) local.extend(geometry.primitive_bounds(id));
      if (!local.empty()) slab.add(cells_about(scene.instances[k].to_world.bounds(local)), std::nullopt);
    }
  });
  for (const auto& part : parts) part->move_to(cells_, sheets_);
}

WallGrid::Range WallGrid::cells_about(const Bounds& bounds) const {
  const auto cell = [&](const vec3& p) { return glm::clamp((p - lower_) * cells_per_metre_, vec3(0), vec3(size_) - 1.0f); };
  return {uvec3(cell(bounds.lower - radius_)), uvec3(cell(bounds.upper + radius_)) + 1u};
}

NearWalls WallGrid::near(const vec3& position, const vec3& normal, float radius, bool side_test) const {
  NearWalls walls;
  walls.position_ = position;
  walls.count_ = NearWalls::too_many;
  const vec3 at = (position - lower_) * cells_per_metre_, end(size_);
  // Outside of the grid, as on an infinite plane.
  if (radius > radius_ || !(at.x >= 0 && at.y >= 0 && at.z >= 0 && at.x < end.x && at.y < end.y && at.z < end.z)) return walls;
  const Cell& cell = cells_[index(uvec3(at))];
  if (cell.count == NearWalls::too_many) return walls;
  walls.count_ = 0;
  // A sphere alone no smaller than the radius, whose photons passed the side test: from within it all ways are clear, and from
  // without they end above it.
  const auto hides_none = [&](const Sheet& sheet) {
    return !sheet.is_sphere ||
           (side_test && radius <= sheet.height_or_radius && std::abs(glm::dot(sheet.normal_at(position), normal)) > 0.999f);
  };
  if (cell.count == 1 && hides_none(sheets_[cell.first])) return walls;
  walls.rounding_ = rounding_;
  const float longest_way = 2 * radius + rounding_;  // to a photon within the radius, and from there before its landing
  for (std::uint32_t i = cell.first; i < cell.first + cell.count; ++i) {
    const Sheet& sheet = sheets_[i];
    const float height = sheet.height(position);
    if (std::abs(height) > longest_way || sheet.is_beside(position, longest_way)) continue;
    // On the point's own sheet the side is that of the normal. Where it is flat, and nothing else near, directions tell sides.
    const bool apart = std::abs(height) > 2 * rounding_;
    const float facing = apart ? height : glm::dot(sheet.normal_at(position), normal);
    const bool own = !apart && std::abs(facing) > 0.999f;
    walls.add(sheet, apart || own ? std::copysign(1.0f, facing) : 0.0f, own);
    if (!own || !hides_none(sheet)) walls.count_ = static_cast<int>(cell.count);
  }
  return walls;
}

std::shared_ptr<const WallGrid> wall_grid(const Scene& scene, float radius, std::shared_ptr<const WallGrid> grid) {
  if (grid && radius <= grid->radius() && 2 * radius >= grid->radius()) return grid;
  return std::make_shared<const WallGrid>(scene, radius);
}

}  // namespace etendue
