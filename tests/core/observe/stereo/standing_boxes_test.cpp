#include "core/observe/stereo/upright_edges.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/foundation/base/rng.h"
#include "core/observe/stereo/edge_field.h"
#include "tests/core/observe/stereo/silhouettes_of_rays.h"

namespace vitrine {
namespace {

constexpr double kGlassTurn = 0.35;
const Vec3d kGlassHalf{0.15, 0.11, 0.16};  // about the origin
const Bounds3 kAboutGlass{{-0.32, -0.32, -0.3}, {0.32, 0.32, 0.3}};

enum class Thing { None, Glass, TwoWires };
constexpr double kLeastPosts = 24;

// Tiles of many colours all around, far away, none of them upright.
float surrounding_tile(const Vec3d& d, int c) {
  const Vec3d p = 7.0 * Vec3d{0.8 * d.x + 0.6 * d.z, 0.48 * d.x + 0.6 * d.y - 0.64 * d.z, -0.36 * d.x + 0.8 * d.y + 0.48 * d.z};
  const uint64_t t = mix64(mix64(uint64_t(std::floor(p.x) + 99), uint64_t(std::floor(p.y) + 99)), uint64_t(std::floor(p.z) + 99));
  return 0.15f + 0.7f * float((t >> (8 * c)) % 101) / 100;
}

// Of the glass, over its middle.
Vec3d rim_corner(size_t i) {
  const double x = i & 1 ? kGlassHalf.x : -kGlassHalf.x, y = i & 2 ? kGlassHalf.y : -kGlassHalf.y, c = std::cos(kGlassTurn),
               s = std::sin(kGlassTurn);
  return {c * x - s * y, s * x + c * y, 0};
}

// Cameras all around at the height of the thing and above; a pane of glass lets nine tenths through and reflects a little.
std::vector<EdgePhoto> photos_with(Thing thing, int count = 14) {
  std::vector<EdgePhoto> photos;
  for (int i = 0; i < count; ++i) {
    const double azimuth = 2 * std::numbers::pi * i / count, elevation = i % 2 == 0 ? 0.25 : 0.6;
    const Vec3d eye{std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation), std::sin(elevation)};
    const Vec3d forward = normalized(-eye), right = normalized(cross(forward, Vec3d{0, 0, 1}));
    EdgePhoto& photo = photos.emplace_back();
    photo.view.intrinsics = {150, 120, 150, 150, 75, 60};
    photo.view.cam_from_world = inverse(Rigid{Mat3d{right, cross(forward, right), forward}, eye});
    const Intrinsics& k = photo.view.intrinsics;
    photo.srgb = ImageF(k.width, k.height, 3);
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x) {
        const Vec3d ray = normalized(photo.view.ray(x + 0.5, y + 0.5));
        const bool glass = thing == Thing::Glass && meets_box(kGlassHalf, kGlassTurn, eye, ray);
        bool wire = false;
        for (size_t i = 0; thing == Thing::TwoWires && i < 2; ++i)
          wire |= meets_box({0.004, 0.004, kGlassHalf.z}, kGlassTurn, eye - rim_corner(i), ray);
        for (int c = 0; c < 3; ++c) {
          const float value = surrounding_tile(ray, c);
          photo.srgb.at(x, y, c) = wire ? 0.9f : glass ? 0.81f * value + 0.04f : value;
        }
      }
  }
  return photos;
}

TEST(EdgeField, TellsAnEdgeFromItsDirectionAndFromWhatSurroundsIt) {
  EdgePhoto photo;
  photo.view.intrinsics = {80, 60, 80, 80, 40, 30};
  photo.srgb = ImageF(80, 60, 3, 0.5f);
  for (int y = 0; y < 60; ++y)
    for (int x = 40; x < 80; ++x)
      for (int c = 0; c < 3; ++c) photo.srgb.at(x, y, c) = 0.52f;  // a faint upright edge through the middle
  const EdgeField faint(photo);
  const Vec3d on{0, 0, 1}, beside{0.1, 0, 1}, down{0, 1, 0}, across{1, 0, 0};
  EXPECT_GT(faint.along(on, down), 0.4f);
  EXPECT_EQ(faint.along(on, across), 0.f);
  EXPECT_EQ(faint.along(beside, down), 0.f);
  EXPECT_LT(faint.along({0, 0, -1}, down), 0) << "behind the camera";
  EXPECT_LT(faint.along({5, 0, 1}, down), 0) << "outside the photo";
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x)
      for (int c = 0; c < 3; ++c) photo.srgb.at(x, y, c) += 0.3f * float((x / 3 + y / 3) % 2);
  EXPECT_LT(EdgeField(photo).along(on, down), 0.6f * faint.along(on, down)) << "among tiles the same edge counts less";
}

TEST(StandingBoxes, AFramelessCaseOfGlassIsFoundWhereItIs) {
  const std::vector<StandingBox> found = standing_boxes(photos_with(Thing::Glass), kAboutGlass, kLeastPosts);
  ASSERT_FALSE(found.empty());
  const StandingBox& best = found.front();
  double worst = 0;
  for (size_t i = 4; i < 8; ++i) {  // of the rim; its foot is nobody's yet
    double nearest = 1e9;
    for (size_t j = 0; j < 4; ++j)
      nearest = std::min(nearest, length(best.box.corner(i) - rim_corner(j) - Vec3d{0, 0, kGlassHalf.z}));
    worst = std::max(worst, nearest);
  }
  fmt::print("{} found; uprights {:.1f}, rim {:.1f}, corners {:.4f} off\n", found.size(), best.posts, best.rim, worst);
  EXPECT_LT(worst, 0.0134);  // two pixels of these small photos
  for (const StandingBox& other : found) EXPECT_LE(other.posts * other.rim, best.posts * best.rim);
}

TEST(StandingBoxes, FewPhotosNoPlaceToLookAndNothingToSeeGiveNone) {
  EXPECT_TRUE(standing_boxes(photos_with(Thing::Glass, 6), kAboutGlass, kLeastPosts).empty());
  EXPECT_TRUE(standing_boxes(photos_with(Thing::Glass), Bounds3{}, kLeastPosts).empty());
  EXPECT_TRUE(standing_boxes(photos_with(Thing::None), kAboutGlass, kLeastPosts).empty());
}

TEST(StandingBoxes, TwoCornersAreNoBox) {
  EXPECT_TRUE(standing_boxes(photos_with(Thing::TwoWires), kAboutGlass, kLeastPosts).empty());
}

}  // namespace
}  // namespace vitrine
