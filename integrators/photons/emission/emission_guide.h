// Emission in proportion to importance: a density over the five numbers a photon is emitted by (light, position, direction),
// higher where paths have been seen to end where photons matter.
//
// A quarter of the pass's paths are pilots; of each it is noted whether it stored a photon in the visible region. A tree that
// halves one dimension at a time is grown over the unit cube as long as that lowers the variance of the count of useful
// photons: with density p in cells of useful share P that is the integral of P / p, least for p ~ sqrt(P), where it is (sum of
// volume sqrt(P))^2. Pilots come in four rounds, each guided by the tree of those before, so that rare regions are found by the
// first and explored by the next ones. Samples are warped by the tree's conditional distributions: a stratified sequence stays
// one. A tenth of the density is uniform: where no pilot was useful photons are rare and strong, but never missing.
//
// Guiding emission by where photons are useful is [Grittmann2018], which learns directions of emission per light; the density
// over the numbers instead, a tree in primary sample space as in [Guo2018], serves every kind of light and finds what links
// position and direction (a window, a keyhole). It cannot guide what happens after emission. Unbiased: the pilots' own photons
// are not kept.
#pragma once

#include "integrators/photons/photon_path.h"

namespace etendue {

class EmissionGuide {
 public:
  struct Pilot {
    EmissionNumbers numbers{};
    float weight = 1;  // one over the density it was drawn with
    bool useful = false;
  };

  // Reorders the pilots. Without pilots the density is uniform.
  explicit EmissionGuide(std::span<Pilot> pilots);

  // Warps uniform numbers to the density; returns the density there.
  float warp(EmissionNumbers& numbers) const;

 private:
  struct Cell {
    EmissionNumbers lower{}, upper;
    float volume() const;
  };
  struct Node {
    int dimension = -1;     // that is halved; -1: a leaf
    float lower_share = 0;  // of the density, in the lower half
    std::uint32_t lower = 0, upper = 0;
    float mass = 0;
  };

  std::uint32_t grow(std::span<Pilot> pilots, const Cell& cell, int depth);
  // The dimension along which 2 or 4 equal parts have the least mean root of their useful shares, if that is less than `below`;
  // otherwise -1.
  static int widest_difference(std::span<const Pilot> pilots, const Cell& cell, int parts, float below);

  std::vector<Node> nodes_;
};

Photons trace_by_importance(const RenderContext& context, const RoughMaterials& rough_materials, const PhotonPass& pass);

}  // namespace etendue
