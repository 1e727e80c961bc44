// The height of walls, from what a mirror shows of them.
#include "stages/decompose/wall_extension.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/foundation/math/rigid.h"
#include "core/foundation/math/spherical_harmonics.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {
namespace {

constexpr Vec3f kPlace{0.3f, -0.2f, 0.1f};  // of what is polished

// A dome of surfels at a distance of 2 around the polished thing: `wall` up to the sine `top`, `sky` above.
SplatLayer dome(float top, float wall, float sky) {
  constexpr size_t kCount = 4000;
  SplatLayer layer(LayerKind::Reflection, 0, kCount);
  for (size_t i = 0; i < kCount; ++i) {
    const double z = (double(i) + 0.5) / double(kCount), a = double(i) * std::numbers::pi * (3 - std::sqrt(5.0));
    const Vec3d out{std::sqrt(1 - z * z) * std::cos(a), std::sqrt(1 - z * z) * std::sin(a), z}, n = -out;
    const Vec3d helper = std::abs(n.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0}, u = normalized(cross(helper, n));
    const Quatd q = quaternion(Mat3d{u, cross(n, u), n});
    const double rotation[] = {q.w, q.x, q.y, q.z};
    for (size_t c = 0; c < 4; ++c) layer.at(Attribute::Rotation, i)[c] = float(rotation[c]);
    for (size_t c = 0; c < 3; ++c) {
      layer.at(Attribute::Mean, i)[c] = kPlace[c] + float(2 * out[c]);
      layer.at(Attribute::ShDc, i)[c] = ((z < double(top) ? wall : sky) - 0.5f) / kShDc;
    }
    for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = std::log(0.07f);
    *layer.at(Attribute::Opacity, i) = logit(0.95f);
  }
  return layer;
}

std::vector<LitPoint> ball(size_t count, float specular_weight, float transmission = 0) {
  std::vector<LitPoint> points(count);
  for (size_t i = 0; i < count; ++i) {
    const float a = float(i + 1);
    points[i].position = kPlace + 0.1f * normalized(Vec3f{std::sin(a), std::sin(2.3f * a), std::sin(3.1f * a)});
    points[i].specular_weight = specular_weight;
    points[i].transmission = transmission;
  }
  return points;
}

TEST(MirroredSky, BeginsWhereTheWallsEnd) {
  for (const float top : {0.3f, 0.5f, 0.65f}) {
    const auto found = mirrored_horizon(dome(top, 0.1f, 0.7f), ball(300, 0.9f));
    ASSERT_TRUE(found) << top;
    EXPECT_NEAR(*found, top, 0.04) << top;
  }
}

TEST(MirroredSky, IsNotGuessed) {
  const SplatLayer room = dome(0.5f, 0.1f, 0.7f);
  EXPECT_FALSE(mirrored_horizon(room, {})) << "nothing polished";
  EXPECT_FALSE(mirrored_horizon(room, ball(20, 0.9f))) << "too little of it";
  EXPECT_FALSE(mirrored_horizon(room, ball(300, 0.2f))) << "dull";
  EXPECT_FALSE(mirrored_horizon(room, ball(300, 0.9f, 0.9f))) << "glass";
  EXPECT_FALSE(mirrored_horizon(dome(0.5f, 0.5f, 0.7f), ball(300, 0.9f))) << "no brighter above";
  EXPECT_FALSE(mirrored_horizon(SplatLayer(LayerKind::Reflection, 0, 0), ball(300, 0.9f))) << "no reflections";
  SplatLayer faint = room;
  for (size_t i = 0; i < faint.size(); ++i) *faint.at(Attribute::Opacity, i) = logit(0.02f);
  EXPECT_FALSE(mirrored_horizon(faint, ball(300, 0.9f))) << "never mirrored";
}

}  // namespace
}  // namespace vitrine
