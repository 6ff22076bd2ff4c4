#include "framework/io/pbrt/noise.h"

#include <array>
#include <cmath>
#include <cstdint>

namespace etendue {

namespace {

// The permutation of [Perlin2002].
constexpr std::array<std::uint8_t, 256> permutation{
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,  103, 30,  69,  142, 8,   99,
    37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,  0,   26,  197, 62,  94,  252, 219, 203, 117, 35,  11,  32,
    57,  177, 33,  88,  237, 149, 56,  87,  174, 20,  125, 136, 171, 168, 68,  175, 74,  165, 71,  134, 139, 48,  27,  166,
    77,  146, 158, 231, 83,  111, 229, 122, 60,  211, 133, 230, 220, 105, 92,  41,  55,  46,  245, 40,  244, 102, 143, 54,
    65,  25,  63,  161, 1,   216, 80,  73,  209, 76,  132, 187, 208, 89,  18,  169, 200, 196, 135, 130, 116, 188, 159, 86,
    164, 100, 109, 198, 173, 186, 3,   64,  52,  217, 226, 250, 124, 123, 5,   202, 38,  147, 118, 126, 255, 82,  85,  212,
    207, 206, 59,  227, 47,  16,  58,  17,  182, 189, 28,  42,  223, 183, 170, 213, 119, 248, 152, 2,   44,  154, 163, 70,
    221, 153, 101, 155, 167, 43,  172, 9,   129, 22,  39,  253, 19,  98,  108, 110, 79,  113, 224, 232, 178, 185, 112, 104,
    218, 246, 97,  228, 251, 34,  242, 193, 238, 210, 144, 12,  191, 179, 162, 241, 81,  51,  145, 235, 249, 14,  239, 107,
    49,  192, 214, 31,  181, 199, 106, 157, 184, 84,  204, 176, 115, 121, 50,  45,  127, 4,   150, 254, 138, 236, 205, 93,
    222, 114, 67,  29,  24,  72,  243, 141, 128, 195, 78,  66,  215, 61,  156, 180};

// Beyond, single precision holds no place within a cell.
constexpr float farthest_cell = 1 << 22;

int permuted(int i) { return permutation[static_cast<std::size_t>(i) & 255]; }

// One of sixteen gradients at a corner of the lattice, times the way from it.
float gradient(const glm::ivec3& corner, const vec3& d) {
  const int hash = permuted(permuted(permuted(corner.x) + corner.y) + corner.z) & 15;
  const bool last_pair = hash == 12 || hash == 13;
  const float u = hash < 8 || last_pair ? d.x : d.y, v = hash < 4 || last_pair ? d.y : d.z;
  return ((hash & 1) != 0 ? -u : u) + ((hash & 2) != 0 ? -v : v);
}

float fade(float t) { return t * t * t * (t * (6 * t - 15) + 10); }

template <class Term>
float sum_of_octaves(vec3 p, float roughness, int octaves, Term term) {
  float sum = 0, strength = 1;
  for (int i = 0; i < octaves; ++i) {
    sum += strength * term(perlin_noise(p));
    p *= 1.99f;
    strength *= roughness;
  }
  return sum;
}

}  // namespace

float perlin_noise(const vec3& p) {
  const vec3 cell = glm::floor(p);
  if (!(glm::all(glm::lessThan(glm::abs(cell), vec3(farthest_cell))))) return 0;
  const glm::ivec3 i(cell);
  const vec3 d = p - cell;
  float along_x[4];
  for (int k = 0; k < 4; ++k) {
    const glm::ivec3 corner = i + glm::ivec3(0, k & 1, k >> 1);
    const vec3 from = d - vec3(0, k & 1, k >> 1);
    along_x[k] = glm::mix(gradient(corner, from), gradient(corner + glm::ivec3(1, 0, 0), from - vec3(1, 0, 0)), fade(d.x));
  }
  const float y = fade(d.y);
  return glm::mix(glm::mix(along_x[0], along_x[1], y), glm::mix(along_x[2], along_x[3], y), fade(d.z));
}

float fractal_noise(const vec3& p, float roughness, int octaves) {
  return sum_of_octaves(p, roughness, octaves, [](float n) { return n; });
}

float turbulence(const vec3& p, float roughness, int octaves) {
  return sum_of_octaves(p, roughness, octaves, [](float n) { return std::abs(n); });
}

}  // namespace etendue
