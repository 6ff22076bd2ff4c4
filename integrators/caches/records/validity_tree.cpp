#include "integrators/caches/records/validity_tree.h"

namespace etendue {

void ValidityTree::Node::add(const Entry& entry) {
  bounds.extend(entry.position);
  least = std::min(least, entry.validity_radius);
  longest = std::max(longest, entry.validity_radius);
}

float ValidityTree::distance_to(const Bounds& bounds, const vec3& p) {
  return (1 - 1e-5f) * glm::length(p - glm::clamp(p, bounds.lower, bounds.upper));
}

void ValidityTree::insert(const vec3& position, float validity_radius, std::uint32_t id) {
  if (nodes_.empty()) nodes_.emplace_back();
  insert_into(0, {position, validity_radius, id}, 0);
}

void ValidityTree::insert_into(std::uint32_t index, const Entry& entry, int depth) {
  for (;; ++depth) {
    nodes_[index].add(entry);
    if (nodes_[index].leaf && (nodes_[index].entries.size() < leaf_size || depth >= deepest)) {
      nodes_[index].entries.push_back(entry);
      return;
    }
    std::vector<Entry> moved;
    if (nodes_[index].leaf) {
      Node& node = nodes_[index];
      node.split = node.bounds.centre();
      node.leaf = false;
      node.children.fill(none);
      moved.swap(node.entries);
    }
    const auto child_of = [&](const vec3& p) {
      const vec3& c = nodes_[index].split;
      const unsigned i =
          static_cast<unsigned>(p.x > c.x) | static_cast<unsigned>(p.y > c.y) << 1 | static_cast<unsigned>(p.z > c.z) << 2;
      if (nodes_[index].children[i] == none) {
        nodes_.emplace_back();
        nodes_[index].children[i] = static_cast<std::uint32_t>(nodes_.size() - 1);
      }
      return nodes_[index].children[i];
    };
    for (const Entry& e : moved) insert_into(child_of(e.position), e, depth + 1);
    index = child_of(entry.position);
  }
}

float ValidityTree::limit(const vec3& position, float validity_radius) const {
  if (!nodes_.empty()) limit_node(0, position, validity_radius);
  return validity_radius;
}

void ValidityTree::limit_node(std::uint32_t index, const vec3& position, float& limit) const {
  const Node& node = nodes_[index];
  if (!(node.least + slope_ * distance_to(node.bounds, position) < limit)) return;
  for (const Entry& e : node.entries) limit = std::min(limit, e.validity_radius + slope_ * glm::length(e.position - position));
  if (!node.leaf)
    for (const std::uint32_t child : node.children)
      if (child != none) limit_node(child, position, limit);
}

}  // namespace etendue
