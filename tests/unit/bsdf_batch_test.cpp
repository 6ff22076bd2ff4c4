#include "framework/core/isa.h"
#include "integrators/paths/surfaces.h"

#include <gtest/gtest.h>

namespace etendue {
namespace {

vec3 direction(Sampler& numbers) { return sample_unit_sphere(numbers.get_2d()); }

SurfacePoint random_point(Sampler& numbers, std::uint32_t materials) {
  SurfacePoint point{};
  point.normal = direction(numbers);
  point.shading_normal = glm::normalize(point.normal + 0.2f * direction(numbers));
  point.tangent = direction(numbers);
  point.material = std::min(static_cast<std::uint32_t>(numbers.get_1d() * static_cast<float>(materials)), materials - 1);
  return point;
}

class Asking {
 public:
  Asking() {
    scene_.materials = {Diffuse{}, Conductor{}, Conductor{.alpha = {0.1f, 0.3f}}, Dielectric{}, Dielectric{.alpha = 0.2f},
                        Plastic{}};
    for (SurfacePoint& point : points_) point = random_point(numbers_, static_cast<std::uint32_t>(scene_.materials.size()));
  }

  void pairs(TransportMode mode) {
    ask([&] { return direction(numbers_); });
    const BsdfPair* answers = batch_.pairs(scene_, mode);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const BsdfPair expected = Bsdf(scene_, points_[i]).pair(wo_[i], other_[i], mode);
      EXPECT_EQ(answers[i].value, expected.value) << i;
      if (is_black(expected.value)) continue;
      EXPECT_EQ(answers[i].pdf, expected.pdf) << i;
      EXPECT_EQ(answers[i].pdf_reverse, expected.pdf_reverse) << i;
    }
  }
  void samples(TransportMode mode) {
    ask([&] { return vec3(numbers_.get_1d(), numbers_.get_1d(), numbers_.get_1d()); });
    const ReversibleSample* answers = batch_.samples(scene_, mode);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Bsdf bsdf(scene_, points_[i]);
      const BsdfSample expected = bsdf.sample(wo_[i], other_[i].x, {other_[i].y, other_[i].z}, mode);
      EXPECT_EQ(answers[i].weight, expected.weight) << i;
      if (!expected) continue;
      EXPECT_EQ(answers[i].wi, expected.wi) << i;
      EXPECT_EQ(answers[i].specular, expected.specular) << i;
      EXPECT_EQ(answers[i].transmitted, expected.transmitted) << i;
      EXPECT_EQ(answers[i].pdf_reverse, bsdf.pdf(expected.wi, wo_[i])) << i;
    }
  }

 private:
  template <class Other>
  void ask(const Other& other) {
    for (std::size_t i = 0; i < points_.size(); ++i) {
      wo_[i] = direction(numbers_);
      other_[i] = other();
      batch_.ask(points_[i], wo_[i], other_[i]);
    }
  }

  Scene scene_;
  Sampler numbers_{SamplerKind::independent, 1, Stream::test, 0, 0};
  std::vector<SurfacePoint> points_ = std::vector<SurfacePoint>(1000);
  std::vector<vec3> wo_ = std::vector<vec3>(1000), other_ = wo_;
  BsdfBatch batch_;
};

TEST(BsdfBatch, AnswersWithTheBitsOfBsdf) {
  const Isa usual = chosen_isa();
  for (const Isa isa : supported_isas()) {
    SCOPED_TRACE(static_cast<int>(isa));
    choose_isa(isa);
    Asking asking;
    for (const TransportMode mode : {TransportMode::radiance, TransportMode::importance}) {
      asking.pairs(mode);
      asking.samples(mode);
    }
  }
  choose_isa(usual);
}

}  // namespace
}  // namespace etendue
