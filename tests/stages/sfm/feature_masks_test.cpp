// Masks keep features out of sfm, and a turntable is told from a camera that walks by the matches that stand still.
#include "stages/sfm/feature_masks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/rng.h"
#include "core/scene/image/ldr.h"
#include "stages/sfm/reconstruct.h"
#include "tests/stages/sfm/sfm_support.h"

namespace vitrine {
namespace {

constexpr int kWidth = 100, kHeight = 80;

// White rectangle [x0, x1) x [0, height) of a picture half as large as the photo.
void write_stripe(const fs::path& path, int x0, int x1, int width = kWidth / 2, int height = kHeight / 2) {
  Image8 mask(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = x0; x < x1; ++x) mask.at(x, y) = 255;
  make_folders(path.parent_path());
  write_ldr(path, mask);
}

std::vector<SfmPhoto> photos(size_t n) {
  std::vector<SfmPhoto> list;
  for (size_t i = 0; i < n; ++i)
    list.push_back(
        {.name = fmt::format("p{}.jpg", i), .picture = {}, .width = kWidth, .height = kHeight, .focal_px = {}, .camera = {}});
  return list;
}

// A descriptor of length 512 that only features of the same tag have.
void append_feature(PhotoFeatures& f, double x, double y, uint64_t tag) {
  f.xy.push_back(float(x)), f.xy.push_back(float(y));
  std::vector<double> values(kDescriptorBytes);
  double square = 0;
  Rng rng(7, tag);
  for (double& v : values) v = std::pow(rng.uniform(), 3), square += v * v;
  for (double v : values) f.descriptors.push_back(uint8_t(std::min(255.0, 512 * v / std::sqrt(square))));
  ++f.count;
}

std::vector<size_t> one_to_one(size_t n) {
  std::vector<size_t> of(n);
  for (size_t i = 0; i < n; ++i) of[i] = i;
  return of;
}

size_t of(const std::array<size_t, kMaskClassCount>& counts, MaskClass kind) { return counts[size_t(kind)]; }

TEST(FeatureMasks, FeaturesOnMirrorsGlassAndPassersByAreTakenOutAndCounted) {
  const TemporaryFolder folder;
  write_stripe(folder.path() / "specular" / "p0.png", 0, 10);     // photo x in [0, 20)
  write_stripe(folder.path() / "transparent" / "p0.png", 5, 20);  // [10, 40)
  write_stripe(folder.path() / "ignore" / "p1.png", 45, 50);      // [90, 100)
  write_stripe(folder.path() / "object" / "p0.png", 20, 30);      // a room around an object: not for sfm
  const FeatureMasks masks(folder.path(), {}, Turntable::No, photos(2));
  EXPECT_FALSE(masks.has(MaskClass::Object));
  std::vector<PhotoFeatures> features(2);
  for (size_t p = 0; p < 2; ++p)
    for (int x : {5, 15, 30, 50, 95}) append_feature(features[p], x, 40, 100 * p + size_t(x));
  const std::vector<uint8_t> blank_before = features[0].descriptors;
  MaskEffect effect;
  const auto kept = suppress_features(masks, UsedFeatures::ByTurntable, one_to_one(2), features, effect);
  EXPECT_EQ(kept[0], (std::vector<uint32_t>{3, 4}));  // 5 mirrors, 15 both, 30 glass
  EXPECT_EQ(kept[1], (std::vector<uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(features[0].xy, (std::vector<float>{50, 40, 95, 40}));
  EXPECT_EQ(features[0].descriptors, std::vector<uint8_t>(blank_before.begin() + 3 * long(kDescriptorBytes), blank_before.end()));
  EXPECT_EQ(of(effect.removed, MaskClass::Specular), 2u);
  EXPECT_EQ(of(effect.removed, MaskClass::Transparent), 2u);
  EXPECT_EQ(of(effect.removed, MaskClass::Ignore), 1u);
  EXPECT_EQ(of(effect.removed, MaskClass::Object), 0u);
  EXPECT_EQ(of(effect.photos, MaskClass::Specular), 1u);
  EXPECT_EQ(effect.before, 10u);
  EXPECT_EQ(effect.after, 6u);
  EXPECT_EQ(effect.removed_of_photo, (std::vector<size_t>{3, 1}));
}

TEST(FeatureMasks, ADeclaredTurntableKeepsTheObjectAlone) {
  const TemporaryFolder folder;
  write_stripe(folder.path() / "p0.png", 10, 20);  // no folder of a class: masks of the object; [20, 40)
  const FeatureMasks masks(folder.path(), {}, Turntable::Yes, photos(2));
  std::vector<PhotoFeatures> features(2);
  for (size_t p = 0; p < 2; ++p)
    for (int x : {5, 30, 95}) append_feature(features[p], x, 40, size_t(x));
  MaskEffect effect;
  const auto kept = suppress_features(masks, UsedFeatures::ByTurntable, one_to_one(2), features, effect);
  EXPECT_EQ(kept[0], (std::vector<uint32_t>{1}));
  EXPECT_EQ(kept[1].size(), 3u);  // a photo without a mask is not emptied
  EXPECT_TRUE(effect.object_applied);
  EXPECT_EQ(of(effect.removed, MaskClass::Object), 2u);
}

TEST(FeatureMasks, WhatCannotBeRightIsRefused) {
  const TemporaryFolder folder;
  const auto code_of = [&](const std::string& below, const FeatureMasksConfig& config, Turntable turntable) {
    try {
      const FeatureMasks masks(folder.path() / below, config, turntable, photos(1));
      return fmt::format("accepted, {} of another shape", masks.other_shape());
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::Input);
      return e.detail().code;
    }
  };
  write_stripe(folder.path() / "glass/specular/p0.png", 0, 10);
  EXPECT_EQ(code_of("glass", {}, Turntable::Yes), "SFM_TURNTABLE_WITHOUT_MASKS");
  EXPECT_EQ(code_of("glass", {}, Turntable::Auto), "accepted, 0 of another shape");
  write_stripe(folder.path() / "black/specular/p0.png", 0, 0);
  EXPECT_EQ(code_of("black", {}, Turntable::Auto), "MASKS_ALL_BLACK");
  EXPECT_EQ(code_of("black", {.specular = FeatureMaskUse::Off}, Turntable::Auto), "accepted, 0 of another shape");
  // A class whose masks are black is absent where another one has pixels.
  write_stripe(folder.path() / "mixed/specular/p0.png", 0, 0);
  write_stripe(folder.path() / "mixed/transparent/p0.png", 0, 10);
  EXPECT_EQ(code_of("mixed", {}, Turntable::Auto), "accepted, 0 of another shape");
  EXPECT_FALSE(FeatureMasks(folder.path() / "mixed", {}, Turntable::Auto, photos(1)).has(MaskClass::Specular));
  write_stripe(folder.path() / "unknown/glass/p0.png", 0, 10);
  EXPECT_EQ(code_of("unknown", {}, Turntable::Auto), "MASKS_UNKNOWN_CLASS");
  write_stripe(folder.path() / "other/specular/q.png", 0, 10);
  EXPECT_EQ(code_of("other", {}, Turntable::Auto), "MASKS_MATCH_NO_PHOTO");
  write_stripe(folder.path() / "turned/specular/p0.png", 0, 10, kHeight, kWidth);
  EXPECT_EQ(code_of("turned", {}, Turntable::Auto), "MASK_WRONG_SIZE");
  write_stripe(folder.path() / "undistorted/specular/p0.png", 0, 10, 60, 40);
  EXPECT_EQ(code_of("undistorted", {}, Turntable::Auto), "accepted, 1 of another shape");
}

// Eight photos, object masks in the middle; what stands outside and what is inside moves by so many pixels a photo.
MaskEffect capture(double outside_step, double inside_step, int outside_features = 12) {
  const TemporaryFolder folder;
  const size_t n = 8;
  for (size_t p = 0; p < n; ++p) write_stripe(folder.path() / "object" / fmt::format("p{}.png", p), 15, 35);  // [30, 70)
  const FeatureMasks masks(folder.path(), {}, Turntable::Auto, photos(n));
  std::vector<PhotoFeatures> features(n);
  for (size_t p = 0; p < n; ++p) {
    for (int k = 0; k < outside_features; ++k) append_feature(features[p], 2 + outside_step * double(p), 3 + 6 * k, uint64_t(k));
    for (int k = 0; k < 12; ++k) append_feature(features[p], 32 + inside_step * double(p), 3 + 6 * k, uint64_t(1000 + k));
  }
  MaskEffect effect;
  suppress_features(masks, UsedFeatures::ByTurntable, one_to_one(n), features, effect);
  return effect;
}

TEST(FeatureMasks, WhatOtherMasksTakeHasNoVoteOnTheTurntable) {
  // The camera walks; a hand in every photo's corner stands still, and is to be ignored.
  const TemporaryFolder folder;
  const size_t n = 8;
  for (size_t p = 0; p < n; ++p) {
    write_stripe(folder.path() / "object" / fmt::format("p{}.png", p), 15, 35);  // [30, 70)
    write_stripe(folder.path() / "ignore" / fmt::format("p{}.png", p), 45, 50);  // [90, 100)
  }
  std::vector<PhotoFeatures> features(n);
  for (size_t p = 0; p < n; ++p)
    for (int k = 0; k < 12; ++k) {
      append_feature(features[p], 2 + 2.0 * double(p), 3 + 6 * k, uint64_t(k));
      append_feature(features[p], 32 + 3.0 * double(p), 3 + 6 * k, uint64_t(1000 + k));
      append_feature(features[p], 92, 3 + 6 * k, uint64_t(2000 + k));
      append_feature(features[p], 97, 3 + 6 * k, uint64_t(3000 + k));
    }
  MaskEffect effect;
  const auto kept = suppress_features(FeatureMasks(folder.path(), {}, Turntable::Auto, photos(n)), UsedFeatures::ByTurntable,
                                      one_to_one(n), features, effect);
  EXPECT_FALSE(effect.object_applied) << effect.evidence->why;
  EXPECT_EQ(effect.evidence->outside_still, 0u);
  EXPECT_EQ(effect.evidence->outside_told, 12u);
  EXPECT_EQ(of(effect.removed, MaskClass::Ignore), n * 24u);
  EXPECT_EQ(of(effect.removed, MaskClass::Object), 0u);
  EXPECT_EQ(kept[0].size(), 24u);
  EXPECT_EQ(kept[0][2], 4u);  // what it was called before
  EXPECT_EQ(features[0].xy[4], 2.f);
}

TEST(FeatureMasks, ATurntableIsToldByARoomThatStandsStill) {
  const MaskEffect turning = capture(0.0, 3.0);
  ASSERT_TRUE(turning.evidence.has_value());
  EXPECT_EQ(turning.evidence->pairs, 7u + 5u);
  EXPECT_EQ(turning.evidence->outside_still, 12u) << turning.evidence->why;
  EXPECT_EQ(turning.evidence->inside_moves, 12u);
  EXPECT_TRUE(turning.object_applied);
  EXPECT_EQ(of(turning.removed, MaskClass::Object), 8u * 12u);

  const MaskEffect walking = capture(2.0, 3.0);
  EXPECT_FALSE(walking.object_applied) << walking.evidence->why;
  EXPECT_EQ(walking.evidence->outside_still, 0u);
  EXPECT_EQ(walking.before, walking.after);

  const MaskEffect still_life = capture(0.0, 0.0);
  EXPECT_FALSE(still_life.object_applied) << still_life.evidence->why;
  const MaskEffect bare_wall = capture(0.0, 3.0, 4);
  EXPECT_FALSE(bare_wall.object_applied) << bare_wall.evidence->why;
  EXPECT_EQ(bare_wall.evidence->outside_told, 0u);
}

}  // namespace
}  // namespace vitrine
