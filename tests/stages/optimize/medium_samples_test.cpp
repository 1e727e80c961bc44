// Colours of points at several distances and the darkest pixels, of photos of a textured floor in air and in haze.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/rng.h"
#include "stages/optimize/medium_fit.h"

namespace vitrine {
namespace {

const MediumCoefficients<double> kFloorHaze{{0.4, 0.4, 0.4}, {0.4, 0.4, 0.4}, {0.5, 0.55, 0.6}};
constexpr int kFloorWidth = 64, kFloorHeight = 48, kSubpixels = 4;
constexpr double kCell = 0.03;  // of the floor; a pixel covers 0.017 in the nearest photo and 0.052 in the farthest
constexpr float kDarkestCell = 0.2f, kBrightestCell = 0.8f;

float floor_radiance(double x, double y) {
  const auto cell = [](double v) { return static_cast<uint64_t>(std::floor(v / kCell) + 1000); };
  Rng rng(cell(x), cell(y));
  return kDarkestCell + (kBrightestCell - kDarkestCell) * rng.uniform();
}

// Seven cameras look down on the floor z = 0, from 1 to 3 above it.
struct FloorCapture {
  Capture capture;
  Targets targets;
  DenseDepth dense;

  explicit FloorCapture(const std::optional<MediumCoefficients<double>>& medium) {
    dense.background = kWithoutParallax;
    for (uint32_t i = 0; i < 7; ++i) {
      View view;
      view.name = fmt::format("view_{}.png", i);
      view.intrinsics = {kFloorWidth, kFloorHeight, 0.9 * kFloorWidth, 0.9 * kFloorWidth, 0.5 * kFloorWidth, 0.5 * kFloorHeight};
      const Vec3d eye{0.013 * i, 0.007 * i, 1 + i / 3.0};
      view.cam_from_world = inverse(Rigid{Mat3d{Vec3d{1, 0, 0}, Vec3d{0, -1, 0}, Vec3d{0, 0, -1}}, eye});
      capture.view_set.views.push_back(view);
      capture.photos.push_back(make_photo(view, photo(view, eye, medium), kFloorWidth));
      capture.train.push_back(i);
      StereoPhoto stereo;
      stereo.view = view;
      dense.photos.push_back(stereo);
      DepthMap map;
      map.width = kFloorWidth, map.height = kFloorHeight;
      map.zdepth.assign(size_t(kFloorWidth * kFloorHeight), float(eye.z));
      map.trusted.assign(size_t(kFloorWidth * kFloorHeight), 1);
      dense.maps.push_back(map);
    }
    targets.photos.resize(capture.photos.size());
  }

  static ImageF photo(const View& view, const Vec3d& eye, const std::optional<MediumCoefficients<double>>& m) {
    ImageF image(kFloorWidth, kFloorHeight, 3);
    for (int y = 0; y < kFloorHeight; ++y)
      for (int x = 0; x < kFloorWidth; ++x) {
        double sum = 0;
        for (int s = 0; s < kSubpixels * kSubpixels; ++s) {
          const Vec3d ray =
              view.intrinsics.ray(x + (s % kSubpixels + 0.5) / kSubpixels, y + (double(s / kSubpixels) + 0.5) / kSubpixels);
          sum += double(floor_radiance(eye.x + eye.z * ray.x, eye.y - eye.z * ray.y)) / (kSubpixels * kSubpixels);
        }
        const double z = eye.z * length(view.intrinsics.ray(x + 0.5, y + 0.5));
        for (size_t c = 0; c < 3; ++c)
          image.pixel(x, y)[c] = float(m ? seen_through_medium(sum, z, 1.0, m->direct[c], m->backscatter[c], m->veil[c]) : sum);
      }
    return image;
  }
};

// One pixel per photo instead of equal parts of the surface gives 0.81 and b = 0.80.
TEST(MediumSamples, DetailThatBlursWithTheDistanceIsNoHaze) {
  const FloorCapture air(std::nullopt);
  const auto fit = fitted_medium(medium_samples(air.capture, air.targets, air.dense, 1), MediumKind::Haze);
  ASSERT_TRUE(fit);
  EXPECT_GT(fit->points, 500u);
  EXPECT_LT(fit->depth, 0.1);
  const FloorCapture haze(kFloorHaze);
  const auto found = fitted_medium(medium_samples(haze.capture, haze.targets, haze.dense, 1), MediumKind::Haze);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->medium.direct.x, kFloorHaze.direct.x, 0.05);
}

TEST(MediumSamples, DarkLevelsAreThoseOfTheFloorAndIgnoreMaskedPixels) {
  FloorCapture air(std::nullopt);
  constexpr size_t kBlack = 400;  // pixels of each photo, more than 1 % of a range
  for (uint32_t photo : air.capture.train) {
    PhotoLevel& level = air.capture.photos[photo].levels[0];
    auto& ignored = air.targets.photos[photo][0].masks[size_t(MaskClass::Ignore)];
    ignored.assign(level.view.intrinsics.pixel_count(), 0);
    for (size_t i = 0; i < kBlack; ++i) {
      ignored[i] = 255;
      for (size_t c = 0; c < 3; ++c) level.srgb[c * ignored.size() + i] = 0;
    }
  }
  const std::vector<DarkLevel> levels = dark_levels(air.capture, air.targets, air.dense);
  ASSERT_GT(levels.size(), 6u);
  for (size_t i = 0; i < levels.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_GE(levels[i].distance[c], i == 0 ? 1 : levels[i - 1].distance[c]);
      EXPECT_LT(levels[i].distance[c], 4);
      EXPECT_GE(levels[i].linear[c], double(kDarkestCell) - 1e-3);
      EXPECT_LT(levels[i].linear[c], 0.45);
    }
  air.targets = {};
  air.targets.photos.resize(air.capture.photos.size());
  EXPECT_LT(dark_levels(air.capture, air.targets, air.dense)[0].linear.x, 0.01);
}

}  // namespace
}  // namespace vitrine
