// Transient content on a textured floor: found in the photo that shows it, and nowhere else.
#include "stages/optimize/transients.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/foundation/base/hash.h"
#include "core/foundation/math/color.h"
#include "core/scene/image/ldr.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"

namespace vitrine {
namespace {

constexpr int kWidth = 120, kHeight = 90;
constexpr size_t kPhotos = 9, kVisited = 4;

double texture(const Vec3d& p, size_t channel) {
  return 0.3 + 0.15 * std::sin(14 * p.x + double(channel)) + 0.1 * std::cos(11 * p.y - 2 * double(channel));
}

// A floor at z = 0 that every picture explains; the exposures of the photos differ.
class VisitedFloor : public ::testing::Test {
 protected:
  VisitedFloor() {
    for (const View& view : testing::ring_of_views(kPhotos, kWidth, kHeight)) {
      TransientPhoto photo{.view = view, .photo = {}, .picture = {}, .zdepth = {}, .excluded = {}};
      const Intrinsics& k = view.intrinsics;
      const Rigid world_from_cam = inverse(view.cam_from_world);
      photo.zdepth.resize(k.pixel_count(), 0.f), photo.photo.resize(3 * k.pixel_count(), 0.f);
      for (int y = 0; y < k.height; ++y)
        for (int x = 0; x < k.width; ++x) {
          const Vec3d ray = view.ray(x + 0.5, y + 0.5), eye = world_from_cam.translation;
          if (ray.z >= -0.05) continue;
          const double z = -eye.z / ray.z;
          photo.zdepth[k.index(x, y)] = float(z);
          for (size_t c = 0; c < 3; ++c)
            photo.photo[c * k.pixel_count() + k.index(x, y)] =
                float(srgb_from_linear(std::min(1.0, view.gain[c] * texture(eye + z * ray, c))));
        }
      photo.picture = photo.photo;
      photos_.push_back(std::move(photo));
    }
  }

  static bool in_disc(int x, int y) { return std::hypot(x - 60, y - 55) < 14; }
  static void paint(std::vector<float>& srgb) {
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        if (in_disc(x, y))
          for (size_t c = 0; c < 3; ++c) srgb[(c * kHeight + size_t(y)) * kWidth + size_t(x)] = c == 1 ? 0.95f : 0.1f;
  }
  // [photo] number of transient pixels
  std::vector<size_t> found() {
    masks_.clear();
    std::vector<size_t> counts;
    const std::vector<TransientEvidence> evidence = transient_evidence(photos_);
    for (size_t v = 0; v < kPhotos; ++v) {
      masks_.push_back(transient_regions(evidence[v], photos_[v].excluded, kWidth, kHeight));
      counts.push_back(size_t(std::ranges::count(masks_.back(), 255)));
    }
    return counts;
  }

  std::vector<TransientPhoto> photos_;
  std::vector<std::vector<uint8_t>> masks_;
};

TEST_F(VisitedFloor, AnEmptyFloorHasNone) { EXPECT_EQ(found(), std::vector<size_t>(kPhotos, 0)); }

TEST_F(VisitedFloor, TheVisitorOfOnePhotoIsFoundThereAlone) {
  paint(photos_[kVisited].photo);
  const std::vector<size_t> counts = found();
  size_t inside = 0, all = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      if (in_disc(x, y)) ++all, inside += masks_[kVisited].empty() ? 0 : masks_[kVisited][size_t(y) * kWidth + size_t(x)] == 255;
  EXPECT_GT(double(inside), 0.97 * double(all));
  EXPECT_LT(double(counts[kVisited]), 1.7 * double(all));
  EXPECT_EQ(std::ranges::count(counts, 0u), long(kPhotos - 1));
}

// A surface that the pictures explain in no photo, such as a mirror, is not transient.
TEST_F(VisitedFloor, WhatNoPictureExplainsIsNotTransient) {
  paint(photos_[kVisited].photo);
  for (TransientPhoto& photo : photos_)
    for (size_t i = 0; i < photo.picture.size(); ++i) photo.picture[i] = photo.photo[i] > 0 ? photo.picture[i] * 0.5f : 0;
  EXPECT_EQ(found()[(kVisited + 1) % kPhotos], 0u);
}

// The picture may have learnt the visitor; and a picture may be wrong where the photos agree. Neither alone is evidence.
TEST_F(VisitedFloor, PhotoAndPictureMustBothDisagree) {
  paint(photos_[kVisited].picture);
  EXPECT_EQ(found(), std::vector<size_t>(kPhotos, 0));
  paint(photos_[kVisited].photo);
  EXPECT_EQ(found(), std::vector<size_t>(kPhotos, 0));
}

TEST_F(VisitedFloor, GlassAndMirrorsAreNoEvidence) {
  paint(photos_[kVisited].photo);
  photos_[kVisited].excluded.assign(kWidth * kHeight, 1);
  EXPECT_EQ(found(), std::vector<size_t>(kPhotos, 0));
}

TEST(TransientRegions, LinesAndSpecksAreNone) {
  TransientEvidence evidence{std::vector<float>(160 * 120, 0.f), std::vector<float>(160 * 120, 0.01f)};
  for (size_t x = 0; x < 160; ++x) evidence.residual[60 * 160 + x] = evidence.residual[61 * 160 + x] = 0.5f;
  for (size_t y = 20; y < 23; ++y)
    for (size_t x = 20; x < 23; ++x) evidence.residual[y * 160 + x] = 0.5f;
  EXPECT_TRUE(transient_regions(evidence, {}, 160, 120).empty());
}

// The mask of a photo holds at every size of its pyramid, together with that of the user, and is written at photo size.
TEST(Transients, BecomeIgnoreMasks) {
  const TemporaryFolder folder("transients");
  Capture capture;
  capture.view_set.views = testing::ring_of_views(2, 32, 24);
  for (const View& view : capture.view_set.views) capture.photos.push_back(make_photo(view, ImageF(32, 24, 3), 32));
  Targets targets;
  targets.photos.resize(2);
  targets.photos[1][0].masks[size_t(MaskClass::Ignore)].assign(32 * 24, 0);
  targets.photos[1][0].masks[size_t(MaskClass::Ignore)][31] = 255;
  Transients transients{.level = 1, .masks = std::vector<std::vector<uint8_t>>(2), .photos = 1};
  transients.masks[1].assign(16 * 12, 0);
  transients.masks[1][5 * 16 + 7] = 255;
  ignore_transients(transients, targets, capture);
  EXPECT_TRUE(targets.any(MaskClass::Ignore));
  EXPECT_TRUE(targets.photos[0][0].masks[size_t(MaskClass::Ignore)].empty());
  const auto ignored = [&](size_t level) {
    return std::ranges::count(targets.photos[1][level].masks[size_t(MaskClass::Ignore)], 255);
  };
  EXPECT_EQ(ignored(0), 5);  // four pixels, and that of the user
  EXPECT_EQ(ignored(1), 1);
  EXPECT_EQ(targets.photos[1][2].masks[size_t(MaskClass::Ignore)].size(), 8u * 6u);
  write_transients(folder.path(), transients, capture);
  const Image8 written = read_grey8(folder.path() / "masks/ignore/view_01.png");
  EXPECT_EQ(written.width(), 32);
  EXPECT_EQ(written.at(14, 10, 0), 255);
  EXPECT_EQ(written.at(13, 10, 0), 0);
  EXPECT_FALSE(fs::exists(folder.path() / "masks/ignore/view_00.png"));
  EXPECT_TRUE(fs::exists(folder.path() / "contact_sheet.png"));
}

// Only where asked for, where the photos are enough; with the same bytes for any number of threads.
TEST(Transients, AreLookedForByOption) {
  const TemporaryFolder folder("transients");
  testing::write_tiny_sfm(folder.path() / "sfm", 12);
  Digest digests[2];
  for (const int threads : {1, 2}) {
    OptimizeConfig config = testing::tiny_config(24);
    config.transients = WantedTransients::Auto;
    testing::TestContext context(folder.path() / "sfm", folder.path() / fmt::format("auto{}", threads));
    context.thread_count = threads;
    run_optimize(config, context);
    EXPECT_TRUE(context.metrics.contains("transient_photos"));
    digests[threads - 1] = digest_folder(context.output());
  }
  EXPECT_EQ(digests[0], digests[1]);
  testing::TestContext off(folder.path() / "sfm", folder.path() / "off");
  run_optimize(testing::tiny_config(24), off);
  EXPECT_FALSE(off.metrics.contains("transient_photos"));
}

}  // namespace
}  // namespace vitrine
