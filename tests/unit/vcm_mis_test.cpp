// The recursive weights of vertex connection and merging against the balance heuristic written out: the densities of all ways
// to sample the same path, and each one's share of them.
#include "integrators/bidirectional/vcm_mis.h"
#include "framework/core/rng.h"
#include "integrators/bidirectional/vcm_correlation.h"

#include <gtest/gtest.h>
#include <vector>

namespace etendue {
namespace {

// Vertices 0 (on the light) to m (on the lens). Edge i joins vertices i and i + 1.
struct RandomPath {
  int m;
  std::vector<double> distance2, cos_near, cos_far;  // per edge; near: at the vertex on the light's side
  std::vector<double> forward, reverse;              // per vertex, solid angle: towards the camera, towards the light
  std::vector<bool> specular;                        // per vertex
  double emission, direct, camera;                   // solid angle (and area)
  bool delta_light;
  double light_paths, merge_area;

  explicit RandomPath(std::uint64_t seed) {
    Pcg32 rng(seed, 5);
    const auto random = [&] { return 0.05 + 2 * static_cast<double>(rng.next_float()); };
    m = 2 + static_cast<int>(6 * rng.next_float());
    for (int i = 0; i <= m; ++i) {
      distance2.push_back(random());
      cos_near.push_back(0.5 * random());
      cos_far.push_back(0.5 * random());
      forward.push_back(random());
      reverse.push_back(random());
      specular.push_back(i > 0 && i < m && rng.next_float() < 0.3f);
    }
    emission = random();
    direct = random();
    camera = 100 * random();
    delta_light = rng.next_float() < 0.3f;
    light_paths = 1 + 200 * random();
    merge_area = rng.next_float() < 0.5f ? 0 : 0.1 * random() / light_paths;
  }

  // Density of the light's part up to vertex `last`, and of the camera's part down to vertex `first`.
  double traced_from_light(int last) const {
    double p = emission;
    for (int i = 1; i <= last; ++i) p *= (i > 1 ? forward[i - 1] : 1) * cos_far[i - 1] / distance2[i - 1];
    return p;
  }
  double traced_from_camera(int first) const {
    double p = 1;
    for (int i = m - 1; i >= first; --i) p *= (i == m - 1 ? camera : reverse[i + 1]) * cos_near[i] / distance2[i];
    return p;
  }
  // The strategy in which the light's part ends at vertex `last` (-1: the camera's part meets the light).
  double connection(int last) const {
    if (last < 0) return delta_light ? 0 : traced_from_camera(0);
    if (specular[last] || specular[last + 1]) return 0;
    if (last == 0) return direct * cos_near[0] / distance2[0] * traced_from_camera(1);
    return traced_from_light(last) * traced_from_camera(last + 1) * (last == m - 1 ? light_paths : 1);
  }
  double merge(int at) const {
    return specular[at] ? 0 : light_paths * merge_area * traced_from_light(at) * traced_from_camera(at);
  }
  double sum() const {
    double total = 0;
    for (int last = -1; last < m; ++last) total += connection(last);
    for (int at = 1; at < m; ++at) total += merge(at);
    return total;
  }

  // The partial sums at each vertex, as the two kinds of paths carry them.
  float n_merge() const { return static_cast<float>(light_paths * merge_area); }
  float n_connect() const { return merge_area > 0 ? 1 / n_merge() : 0; }
  std::vector<MisPartials> along_light() const {
    std::vector<MisPartials> partials(static_cast<std::size_t>(m) + 1);
    MisPartials p = MisPartials::at_light(static_cast<float>(emission), static_cast<float>(direct),
                                          static_cast<float>(cos_near[0]), 1, delta_light, n_connect());
    for (int i = 1; i < m; ++i) {
      p.arrive(i > 1 ? static_cast<float>(distance2[i - 1]) : 1, static_cast<float>(cos_far[i - 1]));
      partials[i] = p;
      leave(p, specular[i], cos_near[i], forward[i], reverse[i]);
    }
    return partials;
  }
  std::vector<MisPartials> along_camera() const {
    std::vector<MisPartials> partials(static_cast<std::size_t>(m) + 1);
    MisPartials p = MisPartials::at_camera(static_cast<float>(light_paths), static_cast<float>(camera));
    for (int i = m - 1; i >= 0; --i) {
      p.arrive(static_cast<float>(distance2[i]), static_cast<float>(cos_near[i]));
      partials[i] = p;
      if (i > 0) leave(p, specular[i], cos_far[i - 1], reverse[i], forward[i]);
    }
    return partials;
  }

 private:
  void leave(MisPartials& p, bool delta, double cos_out, double pdf, double pdf_back) const {
    if (delta) return p.scatter_specular(static_cast<float>(cos_out), static_cast<float>(pdf_back / pdf));
    p.scatter(n_merge(), n_connect(), static_cast<float>(cos_out), static_cast<float>(pdf), static_cast<float>(pdf_back));
  }
};

double weight(const RandomPath& path, int last) {
  const auto light = path.along_light(), camera = path.along_camera();
  const auto f = [](double x) { return static_cast<float>(x); };
  const auto& [m, d2, near, far, forward, reverse, specular, emission, direct, pdf_camera, delta, n, area] = path;
  if (last < 0) return mis_balance(0, f(direct * near[0] / d2[0]) * camera[0].vcm + f(emission) * camera[0].vc);
  if (last == 0) {
    const double hit = delta ? 0 : reverse[1] / direct, traced = emission * far[0] / (near[0] * direct);
    return mis_balance(f(hit), f(traced) * camera[1].connected(path.n_merge(), f(forward[1])));
  }
  const double towards_light = (last == m - 1 ? pdf_camera / n : reverse[last + 1]) * near[last] / d2[last];
  const float light_side = f(towards_light) * light[last].connected(path.n_merge(), f(reverse[last]));
  if (last == m - 1) return mis_balance(light_side, 0);
  const double towards_camera = forward[last] * far[last] / d2[last];
  return mis_balance(light_side, f(towards_camera) * camera[last + 1].connected(path.n_merge(), f(forward[last + 1])));
}

double merge_weight(const RandomPath& path, int at) {
  const auto light = path.along_light(), camera = path.along_camera();
  return mis_balance(light[at].merged(path.n_connect(), static_cast<float>(path.reverse[at])),
                     camera[at].merged(path.n_connect(), static_cast<float>(path.forward[at])));
}

// The same path as two trails, and the correlation-aware weights of all ways to join them.
class RandomTrails {
 public:
  explicit RandomTrails(const RandomPath& path) : p_(path) {
    TrailVertex v{f(p_.emission * p_.cos_far[0] / p_.distance2[0]), f(p_.cos_near[0] / p_.distance2[0])};
    for (int i = 1; i < p_.m; ++i) {
      v.leave(f(p_.cos_near[i]), f(p_.forward[i]), f(p_.reverse[i]), p_.specular[i]);
      light_.push_back(v);
      v = v.next(f(p_.distance2[i]), f(p_.cos_far[i]));
    }
    v = {f(p_.camera * p_.cos_near[p_.m - 1] / p_.distance2[p_.m - 1]), 0};
    for (int i = p_.m - 1; i > 0; --i) {
      v.leave(f(p_.cos_far[i - 1]), f(p_.reverse[i]), f(p_.forward[i]), p_.specular[i]);
      camera_.push_back(v);
      v = v.next(f(p_.distance2[i - 1]), f(p_.cos_near[i - 1]));
    }
    densities_.count_strategies(f(p_.light_paths), f(p_.merge_area));
  }

  float connection(int last) {
    const TrailVertex& end = camera_.back();
    const double to_area = p_.cos_near[0] / p_.distance2[0];
    const TrailLight light{f(p_.direct * to_area), p_.delta_light ? 0 : f(end.forward * to_area), 2};
    if (last <= 0) {
      densities_.connect(light, {}, camera_,
                         {0, f(p_.emission * p_.cos_far[0] / p_.distance2[0]), 0, end.reverse, p_.specular[1]}, first());
      return last < 0 ? densities_.hit() : densities_.connection(0);
    }
    const double camera_finds = (last == p_.m - 1 ? p_.camera : p_.reverse[last + 1]) * p_.cos_near[last] / p_.distance2[last];
    const double light_finds = p_.forward[last] * p_.cos_far[last] / p_.distance2[last];
    densities_.connect(light, part(light_, last), part(camera_, p_.m - 1 - last),
                       {f(camera_finds), f(light_finds), f(p_.reverse[last]), f(p_.forward[last + 1])}, first());
    return densities_.connection(static_cast<std::size_t>(last));
  }
  float merge(int at) {
    const TrailLight light{f(p_.direct * p_.cos_near[0] / p_.distance2[0]), p_.delta_light ? 0.0f : 1.0f, 2};
    densities_.merge(light, part(light_, at), part(camera_, p_.m - at), {0, 0, f(p_.reverse[at]), f(p_.forward[at])}, first());
    return densities_.merge_at(static_cast<std::size_t>(at));
  }
  // [Grittmann2021], written out.
  double rho(int at) const {
    const double area = std::numbers::pi * std::pow(std::tan(std::numbers::pi / 180), 2) * first();
    double l = 1, c = 1;
    for (int i = 1; i <= at; ++i)
      if (i == 1 || !p_.specular[i - 1]) l *= std::min(1.0, double{light_[i - 1].own} * (i == 1 ? area * area : area));
    for (int i = p_.m - 1; i >= at; --i)
      if (i == p_.m - 1 || !p_.specular[i + 1]) c *= std::min(1.0, camera_[p_.m - 1 - i].own * area);
    return at == p_.m - 1 ? 1 : c / (c + l - c * l);
  }

 private:
  static float f(double x) { return static_cast<float>(x); }
  static Trail part(const std::vector<TrailVertex>& trail, int count) { return Trail(trail).first(count); }
  float first() const { return f(100 * p_.distance2[p_.m - 1]); }

  const RandomPath& p_;
  std::vector<TrailVertex> light_, camera_;
  PathDensities densities_;
};

TEST(VcmWeights, CorrelationAwareOnesScaleMergesAlone) {
  double least = 1;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    const RandomPath path(seed);
    RandomTrails trails(path);
    double sum = 0, of_weights = 0;
    for (int last = -1; last < path.m; ++last) sum += path.connection(last);
    for (int at = 1; at < path.m; ++at) sum += path.merge(at) * trails.rho(at);
    const auto expect_share = [&](double p, const auto& weight) {
      if (!(p > 0)) return;
      const double w = weight();
      of_weights += w;
      EXPECT_NEAR(w, p / sum, 1e-4 * p / sum + 1e-9) << seed;
    };
    for (int last = -1; last < path.m; ++last) expect_share(path.connection(last), [&] { return trails.connection(last); });
    for (int at = 1; at < path.m; ++at) {
      expect_share(path.merge(at) * trails.rho(at), [&] { return trails.merge(at); });
      least = std::min(least, trails.rho(at));
    }
    EXPECT_NEAR(of_weights, sum > 0 ? 1 : 0, 1e-4) << seed;
  }
  EXPECT_LT(least, 0.1);
}

TEST(VcmWeights, EqualEachStrategysShareOfAllDensities) {
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    const RandomPath path(seed);
    const double sum = path.sum();
    double of_weights = 0;
    for (int last = -1; last < path.m; ++last) {
      const double p = path.connection(last);
      if (!(p > 0)) continue;
      const double w = weight(path, last);
      of_weights += w;
      EXPECT_NEAR(w, p / sum, 1e-4 * p / sum + 1e-9) << "path " << seed << ", light's part to vertex " << last;
    }
    for (int at = 1; at < path.m; ++at) {
      const double p = path.merge(at);
      if (!(p > 0)) continue;
      const double w = merge_weight(path, at);
      of_weights += w;
      EXPECT_NEAR(w, p / sum, 1e-4 * p / sum + 1e-9) << "path " << seed << ", merged at vertex " << at;
    }
    EXPECT_NEAR(of_weights, sum > 0 ? 1 : 0, 1e-4) << seed;
  }
}

}  // namespace
}  // namespace etendue
