// Octree over records with which neighbour clamping finds the few records it concerns ([Krivanek2006]).
//
// Clamping needs the least of radius_j + slope |p - p_j| over all records, and the records whose validity radius is longer than
// a new one's plus slope times the distance to it. Nodes keep the box of their records and their least and longest
// validity_radius, so both are answered by branch and bound, exactly as by going through all pairs.
#pragma once

#include "framework/core/vec.h"

#include <array>
#include <vector>

namespace etendue {

class ValidityTree {
 public:
  explicit ValidityTree(float slope = 1) : slope_(slope) {}

  void insert(const vec3& position, float validity_radius, std::uint32_t id);
  // The least of `validity_radius` and of what the records allow at a position.
  float limit(const vec3& position, float validity_radius) const;
  // shorten(id, length) for every record longer than length = radius + slope * distance, whose radius becomes that length.
  template <class Shorten>
  void shorten_around(const vec3& position, float validity_radius, const Shorten& shorten) {
    if (!nodes_.empty()) shorten_node(0, position, validity_radius, shorten);
  }

 private:
  static constexpr std::size_t leaf_size = 8;
  static constexpr int deepest = 40;
  static constexpr std::uint32_t none = 0xffffffffu;

  struct Entry {
    vec3 position;
    float validity_radius;
    std::uint32_t id;
  };
  struct Node {
    Bounds bounds;
    float least = infinity, longest = 0;
    vec3 split{0};
    std::array<std::uint32_t, 8> children;
    bool leaf = true;
    std::vector<Entry> entries;  // of a leaf

    void add(const Entry& entry);
  };

  static float distance_to(const Bounds& bounds, const vec3& p);
  void insert_into(std::uint32_t node, const Entry& entry, int depth);
  void limit_node(std::uint32_t node, const vec3& position, float& limit) const;

  // Distances to boxes are rounded, so they are reduced a little: no record is missed.
  template <class Shorten>
  void shorten_node(std::uint32_t index, const vec3& position, float validity_radius, const Shorten& shorten) {
    if (!(nodes_[index].longest > validity_radius + slope_ * distance_to(nodes_[index].bounds, position))) return;
    float longest = 0, least = infinity;
    for (Entry& e : nodes_[index].entries) {
      const float length = validity_radius + slope_ * glm::length(e.position - position);
      if (e.validity_radius > length) {
        e.validity_radius = length;
        shorten(e.id, length);
      }
      longest = std::max(longest, e.validity_radius);
      least = std::min(least, e.validity_radius);
    }
    if (!nodes_[index].leaf)
      for (const std::uint32_t child : nodes_[index].children) {
        if (child == none) continue;
        shorten_node(child, position, validity_radius, shorten);
        longest = std::max(longest, nodes_[child].longest);
        least = std::min(least, nodes_[child].least);
      }
    nodes_[index].longest = longest;
    nodes_[index].least = least;
  }

  float slope_;
  std::vector<Node> nodes_;
};

}  // namespace etendue
