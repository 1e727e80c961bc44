#include "stages/sfm/diagnosis.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/math/vec.h"
#include "stages/sfm/sfm.h"

namespace vitrine {
namespace {

Reconstruction capture(size_t photos, size_t features, size_t registered, std::vector<size_t> groups) {
  Reconstruction r;
  for (size_t i = 0; i < photos; ++i) {
    PhotoReport p;
    p.name = fmt::format("p{}.jpg", i);
    p.features = features;
    p.matches = 100, p.verified = 80, p.neighbours = 2;
    p.registered = i < registered;
    r.photos.push_back(p);
  }
  r.model.images.resize(registered);
  r.groups = std::move(groups);
  r.pairs_compared = 45, r.pairs_matched = 30, r.pairs_verified = 25;
  return r;
}

TEST(Diagnosis, AcceptsEnoughPhotos) {
  EXPECT_EQ(diagnosed(capture(10, 3000, 6, {10}), {}).code, "");
  EXPECT_EQ(diagnosed(capture(10, 3000, 5, {10}), {}).code, "SFM_TOO_FEW_REGISTERED");
  EXPECT_EQ(diagnosed(capture(3, 3000, 2, {3}), {}).code, "SFM_TOO_FEW_REGISTERED");  // two views are no model
}

TEST(Diagnosis, NamesTheCause) {
  EXPECT_EQ(diagnosed(capture(10, 40, 0, {10}), {}).code, "SFM_TOO_FEW_FEATURES");
  EXPECT_EQ(diagnosed(capture(10, 3000, 0, {4, 2, 2, 2}), {}).code, "SFM_NO_OVERLAP");
  EXPECT_EQ(diagnosed(capture(10, 3000, 0, {4, 4, 2}), {}).code, "SFM_SPLIT_MODELS");
  EXPECT_EQ(diagnosed(capture(10, 3000, 2, {10}), {}).code, "SFM_REFLECTIONS_DOMINATE") << "pairs that contradict each other";
  Reconstruction r = capture(10, 3000, 0, {10});
  r.rotation_share = 0.9;
  EXPECT_EQ(diagnosed(r, {}).code, "SFM_PURE_ROTATION");
  r = capture(10, 3000, 0, {10});
  r.uncalibrated_share = 0.9;
  EXPECT_EQ(diagnosed(r, {}).code, "SFM_BAD_FOCAL");
  r = capture(10, 100, 0, {10});
  for (PhotoReport& p : r.photos) p.blur_px = 4;
  EXPECT_EQ(diagnosed(r, {}).code, "SFM_MOTION_BLUR");
  EXPECT_EQ(cause_left_out(r.photos[3], r), "motion_blur");
  for (size_t i = 0; i < 10; ++i) r.photos[i].brightness_ev = i < 4 ? -7 : -2;
  EXPECT_EQ(diagnosed(r, {}).code, "SFM_MIXED_EXPOSURE");
  EXPECT_EQ(cause_left_out(r.photos[3], r), "mixed_exposure");
  EXPECT_EQ(diagnosed(capture(10, 3000, 0, {10}), {}).code, "SFM_NO_MODEL");
}

TEST(Diagnosis, FeaturesThatMasksTakeDoNotCount) {
  Reconstruction r = capture(10, 3000, 0, {10});
  for (PhotoReport& p : r.photos) p.masked = 2900;
  const Diagnosis masked = diagnosed(r, {});
  EXPECT_EQ(masked.code, "SFM_TOO_FEW_FEATURES");
  EXPECT_NE(masked.why.find("the masks leave too little texture: median 100 features a photo (3000 before masks)"),
            std::string::npos)
      << masked.why;
  EXPECT_NE(masked.hint.find("sfm.masks.specular=off"), std::string::npos) << masked.hint;
  for (PhotoReport& p : r.photos) p.masked = 1000;
  EXPECT_EQ(diagnosed(r, {}).code, "SFM_NO_MODEL");
}

TEST(Diagnosis, SuspectsReflectionsWhenMatchesDisagree) {
  Reconstruction r = capture(10, 3000, 4, {10});
  EXPECT_EQ(diagnosed(r, {}).why.find("polished"), std::string::npos);
  r.pairs_verified = 5;
  EXPECT_NE(diagnosed(r, {}).why.find("polished"), std::string::npos);
}

TEST(Diagnosis, IsExitCode4WithCauseEvidenceAndWhatToTry) {
  Reconstruction r = capture(10, 3000, 4, {10});
  r.photos[7].weak_points = 31;
  r.photos[8].features = 12;
  try {
    throw_diagnosis(diagnosed(r, {}), "scratch/report.json");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(exit_code(e.kind()), 4);
    EXPECT_EQ(
        std::string(e.what()),
        "4 of 10 photos have poses (40 %, need 60 % and at least 3)\n"
        "  where  scratch/report.json\n"
        "  why    median 3000 features a photo; of 45 pairs compared 30 had at least 15 matches and 25 agree on a camera motion\n"
        "         p4.jpg (80 verified matches with 2 photos, too few with known points)\n"
        "         p5.jpg (80 verified matches with 2 photos, too few with known points)\n"
        "         p6.jpg (80 verified matches with 2 photos, too few with known points)\n"
        "         p7.jpg (its pose would hang on 31 points only)\n"
        "         p8.jpg (12 features: blurred, dark or without texture)\n"
        "         p9.jpg (80 verified matches with 2 photos, too few with known points)\n"
        "  try    1. add photos between those with a pose and those without\n"
        "         2. put a printed pattern under the object, keep the surroundings in the picture\n"
        "         3. supply poses: --poses transforms.json, or a COLMAP model\n"
        "         4. accept fewer: --set sfm.min_registered=0.3");
  }
}

constexpr int kPanWidth = 640, kPanHeight = 480;
constexpr double kFocal = 600;

VerifiedPair pair_of(const Mat3d& euclidean) {
  const Mat3d k{{kFocal, 0, 0}, {0, kFocal, 0}, {320, 240, 1}},
      inverse{{1 / kFocal, 0, 0}, {0, 1 / kFocal, 0}, {-320 / kFocal, -240 / kFocal, 1}};
  const Mat3d h = k * euclidean * inverse;
  return {.image_a = 1,
          .image_b = 2,
          .inliers = 100,
          .config = 6,
          .homography = {h.c0.x, h.c1.x, h.c2.x, h.c0.y, h.c1.y, h.c2.y, h.c0.z, h.c1.z, h.c2.z}};
}

Mat3d turned(double degrees) {
  const double a = degrees * 3.14159265358979 / 180;
  return {{std::cos(a), 0, -std::sin(a)}, {0, 1, 0}, {std::sin(a), 0, std::cos(a)}};
}

TEST(RotationPairs, KnowATurnFromAPlane) {
  std::vector<VerifiedPair> turns, planes, still;
  for (int i = 1; i <= 6; ++i) {
    turns.push_back(pair_of(turned(5.0 * i)));
    still.push_back(pair_of(turned(0)));
    Mat3d plane = turned(4.0 * i);  // R + t n^T / d, with n = z
    plane.c2 += Vec3d{0.12 * i, 0.02, 0.05 * i};
    planes.push_back(pair_of(plane));
  }
  EXPECT_EQ(rotation_share(turns, kPanWidth, kPanHeight), 1);
  EXPECT_LE(rotation_share(planes, kPanWidth, kPanHeight), 0.34)
      << "one focal length can make one plane look like a turn, not all";
  EXPECT_EQ(rotation_share(still, kPanWidth, kPanHeight), 0);
  for (VerifiedPair& p : turns) p.config = kCalibratedPair;
  EXPECT_EQ(rotation_share(turns, kPanWidth, kPanHeight), 0) << "they have depth";
}

}  // namespace
}  // namespace vitrine
