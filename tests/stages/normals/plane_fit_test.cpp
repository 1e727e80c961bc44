#include "stages/normals/geometric.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"

namespace vitrine {
namespace {

constexpr int kWidth = 48, kHeight = 40;
const Intrinsics kCamera{kWidth, kHeight, 55, 60, 22, 21};

// Two planes that meet in column `edge`.
struct Corner {
  Vec3d left = normalized(Vec3d{0.5, 0.3, -1}), right = normalized(Vec3d{-0.7, -0.2, -0.6});
  int edge = 24;
  Vec3d normal(int x) const { return x < edge ? left : right; }
  double inverse_z(int x, int y) const { return dot(normal(x), kCamera.ray(x + 0.5, y + 0.5)) / (x < edge ? -2.0 : -1.7); }
};

DepthSamples samples_of(const Corner& corner, double noise, double share) {
  DepthSamples s{kWidth, kHeight, {}, {}};
  Rng rng(5);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool known = rng.uniform_double() < share, wrong = rng.uniform_double() < 0.05;
      const double error = wrong ? rng.uniform_double() : noise * double(rng.normal());
      s.inverse_z.push_back(float(corner.inverse_z(x, y) * (1 + error)));
      s.weight.push_back(known ? 1.f : 0.f);
    }
  return s;
}

ImageF luma_of(const Corner& corner) {
  ImageF luma(kWidth, kHeight, 1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) luma.at(x, y) = x < corner.edge ? 0.3f : 0.7f;
  return luma;
}

TEST(PlaneFit, FindsBothPlanesOfACornerDespiteNoiseAndMistakes) {
  const Corner corner;
  const NormalMap map = fitted_normals(samples_of(corner, 0.002, 0.6), luma_of(corner), kCamera);
  double worst = 0, sum = 0;
  size_t count = 0;
  for (int y = 3; y < kHeight - 3; ++y)
    for (int x = 3; x < kWidth - 3; ++x) {
      if (std::abs(x - corner.edge) < 3) continue;
      EXPECT_GT(map.confidence.at(x, y), 0) << x << " " << y;
      const double angle = std::acos(std::min(1.0, dot(cast<double>(map.at(x, y)), corner.normal(x)))) * 57.29578;
      worst = std::max(worst, angle);
      sum += angle;
      ++count;
    }
  EXPECT_LT(sum / double(count), 4);  // seen: 1.9
  EXPECT_LT(worst, 30);
}

TEST(PlaneFit, IsLessSureWhereDepthsAreFewAndSilentWithoutAny) {
  const Corner corner;
  DepthSamples s = samples_of(corner, 0, 1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 10; x < kWidth; ++x) s.weight[size_t(y * kWidth + x)] = 0;
  const NormalMap map = fitted_normals(s, ImageF(kWidth, kHeight, 1, 0.5f), kCamera);
  EXPECT_GT(map.confidence.at(4, 20), 1.2f * map.confidence.at(16, 20));
  EXPECT_EQ(map.confidence.at(40, 20), 0);
  EXPECT_EQ(map.at(40, 20), (Vec3f{0, 0, 0}));
}

}  // namespace
}  // namespace vitrine
