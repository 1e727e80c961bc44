// Do given poses agree with the photos? Matches and pictures of a synthetic scene, poses written wrong in the ways people do.
#include "core/intake/poses/pose_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include <fmt/format.h>

#include "core/intake/poses/pose_variants.h"
#include "tests/core/intake/poses/synthetic_model.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

constexpr size_t kPhotos = 12;

ColmapModel scene(size_t points = 400) {
  return synthetic_model(ring(kPhotos, 3, 1, {0, 0, 1}), cloud(points, 1, 0.8), {1, 1, 640, 480, {600, 600, 330, 235}});
}

// What a matcher would find: places that two neighbouring photos see, `noise_px` off, and wrong matches.
std::vector<PhotoMatches> matches_of(const ColmapModel& m, double noise_px = 0.5, double wrong = 0.05) {
  std::vector<PhotoMatches> out;
  Rng rng(5);
  for (size_t i = 0; i < m.images.size(); ++i)
    for (size_t step = 1; step <= 2; ++step) {
      const ColmapImage &a = m.images[i], &b = m.images[(i + step) % m.images.size()];
      PhotoMatches pair{a.name, b.name, {}, {}};
      for (const ColmapPoint2D& p : a.points)
        for (const ColmapPoint2D& q : b.points) {
          if (p.point3d_id == kNoPoint3D || p.point3d_id != q.point3d_id) continue;
          pair.in_a.push_back({p.x + noise_px * rng.normal(), p.y + noise_px * rng.normal()});
          pair.in_b.push_back({q.x + noise_px * rng.normal(), q.y + noise_px * rng.normal()});
          if (rng.uniform_double() < wrong) pair.in_b.back() = {640 * rng.uniform_double(), 480 * rng.uniform_double()};
        }
      out.push_back(std::move(pair));
    }
  return out;
}

PosePixels pixels_of(const ColmapModel& m, PoseSource source = PoseSource::Colmap) {
  PosePixels pixels{.source = source, .photos = {}, .oddly_resized = false, .notes = {}};
  for (const ColmapImage& image : m.images) {
    Photo photo;
    photo.name = image.name, photo.width = 640, photo.height = 480;
    pixels.photos.push_back(posed_photo(photo, 640, 480));
  }
  return pixels;
}

ColmapModel without_points(ColmapModel m) {
  m.points.clear();
  for (ColmapImage& image : m.images) image.points.clear();
  return m;
}

template <class F>
ColmapModel with_poses(ColmapModel m, F&& changed) {
  for (ColmapImage& image : m.images) {
    const Rigid pose = changed(image.cam_from_world());
    image.rotation = quaternion(pose.rotation);
    image.translation = pose.translation;
  }
  return without_points(std::move(m));
}

const Mat3d kFlip{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
Rigid flipped(const Rigid& pose) { return {kFlip * pose.rotation, kFlip * pose.translation}; }

// Turned and moved at random, so that places land about `px` pixels off.
Rigid shaken(const Rigid& pose, double px, Rng& rng) {
  const double angle = px / 600;
  const Quatd turn = normalized(Quatd{1, angle / 2 * rng.normal(), angle / 2 * rng.normal(), angle / 2 * rng.normal()});
  const Mat3d rotation = rotation_matrix(turn);
  return {rotation * pose.rotation, rotation * pose.translation};
}

CheckedPoses checked(const ColmapModel& poses, PoseSource source = PoseSource::Colmap) {
  PosePixels pixels = pixels_of(poses, source);
  return checked_with_matches(poses, pixels, matches_of(scene()), "poses");
}

Error refusal(const ColmapModel& poses, PoseSource source = PoseSource::Colmap) {
  return error_of([&] { checked(poses, source); });
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

bool warns(const CheckedPoses& c, const std::string& code) {
  return std::any_of(c.notes.begin(), c.notes.end(), [&](const Note& n) { return n.code == code; });
}

TEST(PoseCheck, RightPosesPassWithoutAWord) {
  const CheckedPoses c = checked(without_points(scene()));
  EXPECT_TRUE(c.checked);
  EXPECT_GT(c.agreement.share(), 0.9);
  EXPECT_LT(c.agreement.offset, 1);
  EXPECT_TRUE(c.notes.empty()) << c.notes[0].text;
}

TEST(PoseCheck, AnyMotionOfTheWorldIsAsGood) {
  ColmapModel moved = scene();
  transform_world(moved, {7, rotation_matrix(normalized(Quatd{0.3, -0.5, 0.7, 0.2})), {10, -3, 5}});
  EXPECT_TRUE(checked(without_points(moved)).notes.empty());
}

TEST(PoseCheck, PosesOfAPhonePassWithAWarningThatSaysHowFarTheyAreOff) {
  Rng rng(3);
  const CheckedPoses c = checked(with_poses(scene(), [&](const Rigid& p) { return shaken(p, 6, rng); }));  // 18 of 1920
  EXPECT_TRUE(c.checked);
  ASSERT_TRUE(warns(c, "POSES_INACCURATE"));
  EXPECT_TRUE(has(c.notes[0].text, "px in the median")) << c.notes[0].text;
}

TEST(PoseCheck, OtherCameraAxesAreNamed) {
  const Error opencv_in_transforms = refusal(with_poses(scene(), flipped), PoseSource::Transforms);
  EXPECT_EQ(opencv_in_transforms.kind(), ErrorKind::Input);
  EXPECT_EQ(opencv_in_transforms.detail().code, "POSES_DISAGREE");
  EXPECT_TRUE(has(opencv_in_transforms.detail().why, "x right, y down, z forward (OpenCV's)")) << opencv_in_transforms.what();
  EXPECT_TRUE(has(opencv_in_transforms.detail().hint, "negate the second and third column")) << opencv_in_transforms.what();
  EXPECT_TRUE(has(refusal(with_poses(scene(), flipped)).detail().why, "x right, y up, z backward (OpenGL's)"));
  // A camera that looks along its x axis, z up.
  const Mat3d forward_x{{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}};
  const Error robot = refusal(with_poses(scene(), [&](const Rigid& p) {
    return Rigid{transposed(forward_x) * p.rotation, transposed(forward_x) * p.translation};
  }));
  EXPECT_TRUE(has(robot.detail().why, "x forward, y left, z up")) << robot.what();
}

TEST(PoseCheck, InversePosesAreNamedWithAndWithoutOtherAxes) {
  const auto inverted = [](const Rigid& p) { return inverse(p); };
  EXPECT_TRUE(has(refusal(with_poses(scene(), inverted)).detail().why, "they are world-from-camera, not camera-from-world"));
  // transforms.json with COLMAP's own matrices: read as the inverse with other axes.
  const Error e = refusal(with_poses(scene(), [](const Rigid& p) { return flipped(inverse(p)); }), PoseSource::Transforms);
  EXPECT_TRUE(has(e.detail().why, "they are camera-from-world, not world-from-camera")) << e.what();
  EXPECT_TRUE(has(e.detail().why, "x right, y down, z forward (OpenCV's)")) << e.what();
}

TEST(PoseCheck, LeftHandedPosesAreNamed) {
  const Mat3d mirror{{1, 0, 0}, {0, -1, 0}, {0, 0, 1}};
  const Error e = refusal(with_poses(scene(), [&](const Rigid& p) {
    return Rigid{mirror * p.rotation * mirror, mirror * p.translation};
  }));
  EXPECT_TRUE(has(e.detail().why, "x right, y up, z forward (left-handed)")) << e.what();
}

TEST(PoseCheck, QuaternionsInAnotherOrderAndCentresAsTranslationsAreNamed) {
  ColmapModel xyzw = without_points(scene());
  for (ColmapImage& image : xyzw.images) {
    const Quatd q = image.rotation;
    image.rotation = {q.x, q.y, q.z, q.w};  // x y z w read as w x y z
  }
  EXPECT_TRUE(has(refusal(xyzw).detail().why, "x y z w")) << refusal(xyzw).what();
  const Error centres = refusal(with_poses(scene(), [](const Rigid& p) { return Rigid{p.rotation, inverse(p).translation}; }));
  EXPECT_TRUE(has(centres.detail().why, "their translations are the camera centres")) << centres.what();
}

// Both kinds of camera axes, of a file that holds (R^T, C), (R, C) or (R, t) where another pair is the rule.
TEST(PoseCheck, ARotationOrATranslationThatAloneIsInvertedIsNamedWithItsShare) {
  const auto as_transforms = [](const Mat3d& part, const Vec3d& column) {  // as transforms_file.cpp reads part and last column
    return inverse(Rigid{part * kFlip, column});
  };
  const auto centre = [](const Rigid& p) { return inverse(p).translation; };
  const auto why = [](const ColmapModel& m, PoseSource source) { return refusal(m, source).detail().why; };
  struct Case {
    const char* named;
    std::function<Rigid(const Rigid&)> read;
  };
  const Case transforms[] = {
      {"agree if the rotations are transposed", [&](const Rigid& p) { return as_transforms(p.rotation, centre(p)); }},
      {"agree if the rotations are transposed", [&](const Rigid& p) { return as_transforms(kFlip * p.rotation, centre(p)); }},
      {"agree if the rotations are transposed", [&](const Rigid& p) { return as_transforms(p.rotation * kFlip, centre(p)); }},
      {"agree if the last columns are the translations -R C",
       [&](const Rigid& p) { return as_transforms(transposed(p.rotation) * kFlip, p.translation); }},
      {"agree if the last columns are the translations -R C",
       [&](const Rigid& p) { return as_transforms(transposed(p.rotation), p.translation); }}};
  for (const Case& c : transforms) {
    const std::string text = why(with_poses(scene(), c.read), PoseSource::Transforms);
    EXPECT_TRUE(has(text, c.named) && has(text, "9")) << text;
  }
  const Case projections[] = {{"agree if the rotations are transposed (the translations are right)",
                               [](const Rigid& p) {
                                 return Rigid{transposed(p.rotation), p.translation};
                               }},
                              {"agree if the rotations are transposed (the camera centres are right)",
                               [&](const Rigid& p) {
                                 return Rigid{transposed(p.rotation), -(transposed(p.rotation) * centre(p))};
                               }},
                              {"agree if their translations are the camera centres", [&](const Rigid& p) {
                                 return Rigid{p.rotation, centre(p)};
                               }}};
  for (const PoseSource source : {PoseSource::Colmap, PoseSource::Matrices})
    for (const Case& c : projections) {
      const std::string text = why(with_poses(scene(), c.read), source);
      EXPECT_TRUE(has(text, c.named)) << text;
    }
}

TEST(PoseCheck, NormalisedIntrinsicsAreNamed) {
  const auto why = [](double fx, double fy, double cx, double cy) {
    ColmapModel m = without_points(scene());
    for (ColmapCamera& camera : m.cameras) camera.params = {fx, fy, cx, cy};
    return refusal(m, PoseSource::Transforms).detail().why;
  };
  const std::string sides = why(600 / 640., 600 / 480., 330 / 640., 235 / 480.);
  EXPECT_TRUE(has(sides, "fractions of the width and the height")) << sides;
  const std::string longest = why(600 / 640., 600 / 640., 10 / 640., -5 / 640.);
  EXPECT_TRUE(has(longest, "fractions of the longest side")) << longest;
  const std::string device = why(600 / 320., 600 / 240., 10 / 320., -5 / 240.);
  EXPECT_TRUE(has(device, "from -1 to 1")) << device;
  const std::string pixel_centre = why(600 / 640., 600 / 640., 330, 235);
  EXPECT_TRUE(has(pixel_centre, "fractions of the longest side")) << pixel_centre;
}

TEST(PoseCheck, PosesOfOtherPhotosAreRefusedAndAnOrderThatFitsIsNamed) {
  ColmapModel shuffled = without_points(scene());
  constexpr size_t kDealt[] = {7, 2, 10, 5, 0, 11, 3, 8, 1, 6, 4, 9};
  for (size_t i = 0; i < kPhotos; ++i) {
    shuffled.images[i].rotation = scene().images[kDealt[i]].rotation;
    shuffled.images[i].translation = scene().images[kDealt[i]].translation;
  }
  const Error other = refusal(shuffled);
  EXPECT_EQ(other.detail().code, "POSES_DISAGREE");
  EXPECT_TRUE(has(other.detail().why, "they may be of other photos")) << other.what();
  // Half a turn of photos, so that a shift is no turn of the world.
  const ColmapModel truth = synthetic_model(ring(kPhotos, 3, 1, {0, 0, 1}, 0.4, 2), cloud(400, 1, 0.8));
  ColmapModel reversed = without_points(truth);
  for (size_t i = 0; i < kPhotos; ++i) {
    reversed.images[i].rotation = truth.images[kPhotos - 1 - i].rotation;
    reversed.images[i].translation = truth.images[kPhotos - 1 - i].translation;
  }
  PosePixels pixels = pixels_of(reversed);
  const Error e = error_of([&] { checked_with_matches(reversed, pixels, matches_of(truth), "poses"); });
  EXPECT_TRUE(has(e.detail().why, "in reverse order")) << e.what();
}

TEST(PoseCheck, NumbersSortedAsWordsAreNamed) {
  ColmapModel truth = scene();
  std::vector<std::string> numbers, words;
  for (size_t i = 0; i < kPhotos; ++i) numbers.push_back(fmt::format("{}.jpg", i + 1));
  for (size_t i = 0; i < kPhotos; ++i) truth.images[i].name = numbers[i];
  words = numbers;
  std::sort(words.begin(), words.end());
  ColmapModel given = without_points(truth);  // the i-th pose got the i-th name in the order of words
  for (size_t i = 0; i < kPhotos; ++i) given.images[i].name = words[i];
  std::sort(given.images.begin(), given.images.end(), [](const ColmapImage& a, const ColmapImage& b) { return a.name < b.name; });
  PosePixels pixels = pixels_of(given);
  const Error e = error_of([&] { checked_with_matches(given, pixels, matches_of(truth), "poses"); });
  EXPECT_TRUE(has(e.detail().why, "in the order of numbers")) << e.what();
}

TEST(PoseCheck, AFocalLengthOfAnotherPictureSizeIsNamed) {
  ColmapModel twice = without_points(scene());
  for (ColmapCamera& camera : twice.cameras) camera.params[0] *= 2, camera.params[1] *= 2;
  EXPECT_TRUE(has(refusal(twice).detail().why, "the focal length is about 0.5 times as long")) << refusal(twice).what();
}

TEST(PoseCheck, APhotoWithTheWrongPoseIsNamedAndItsNeighboursAreNot) {
  ColmapModel poses = without_points(scene());
  std::swap(poses.images[3].rotation, poses.images[8].rotation);
  std::swap(poses.images[3].translation, poses.images[8].translation);
  const CheckedPoses c = checked(poses);
  ASSERT_TRUE(warns(c, "POSES_PHOTO_DISAGREES"));
  const std::string text = c.notes.back().text;
  EXPECT_TRUE(has(text, "the poses of 2 photos")) << text;
  EXPECT_TRUE(has(text, poses.images[3].name) && has(text, poses.images[8].name)) << text;
}

TEST(PoseCheck, TooFewMatchesAreSaidToBeTooFew) {
  const ColmapModel poses = without_points(scene());
  PosePixels pixels = pixels_of(poses);
  const CheckedPoses c = checked_with_matches(poses, pixels, {}, "poses");
  EXPECT_FALSE(c.checked);
  EXPECT_TRUE(warns(c, "POSES_UNCHECKED"));
}

TEST(PoseCheck, TheRoomAroundATurntableHasNoVote) {
  // Poses of the turning object are right; most matches lie on the room, which stands still in the pictures.
  std::vector<PhotoMatches> matches = matches_of(scene());
  Rng rng(9);
  for (PhotoMatches& m : matches)
    for (size_t i = m.in_a.size() * 5; i > 0; --i) {
      const Vec2d place{640 * rng.uniform_double(), 480 * rng.uniform_double()};
      m.in_a.push_back(place);
      m.in_b.push_back({place.x + 0.3 * rng.normal(), place.y + 0.3 * rng.normal()});
    }
  const ColmapModel poses = without_points(scene());
  PosePixels pixels = pixels_of(poses);
  EXPECT_TRUE(checked_with_matches(poses, pixels, matches, "poses").notes.empty());
}

TEST(PoseCheck, AllPosesAtOnePlaceAreSaidToBe) {
  const Error e = refusal(with_poses(scene(), [](const Rigid&) { return Rigid{}; }));
  EXPECT_TRUE(has(e.detail().why, "all cameras are at one place")) << e.what();
}

// --- pictures -------------------------------------------------------------------------------------------------------

// Every place has its colour; a photo is black with a disc of that colour at each observation.
std::function<Image8(const ColmapImage&)> painter(const ColmapModel& truth) {
  return [&truth](const ColmapImage& asked) {
    Image8 picture(640, 480, 3, uint8_t{20});
    for (const ColmapImage& image : truth.images) {
      if (image.name != asked.name) continue;
      for (const ColmapPoint2D& p : image.points) {
        if (p.point3d_id == kNoPoint3D) continue;
        Rng rng(11, p.point3d_id);
        const uint8_t colour[] = {uint8_t(rng.below(256)), uint8_t(rng.below(256)), uint8_t(rng.below(256))};
        for (int y = int(p.y) - 5; y <= int(p.y) + 5; ++y)
          for (int x = int(p.x) - 5; x <= int(p.x) + 5; ++x)
            if (x >= 0 && y >= 0 && x < 640 && y < 480) std::copy_n(colour, 3, picture.pixel(x, y));
      }
    }
    return picture;
  };
}

TEST(PoseCheck, AModelWithPointsIsHeldAgainstThePictures) {
  const ColmapModel truth = scene(120);
  PosePixels pixels = pixels_of(truth);
  const CheckedPoses right = checked_with_pictures(truth, pixels, painter(truth), "model");
  EXPECT_TRUE(right.checked);
  EXPECT_GT(right.agreement.share(), 0.9);
  EXPECT_TRUE(right.notes.empty()) << right.notes[0].text;
  ColmapModel shifted = truth;
  for (size_t i = 0; i < kPhotos; ++i) shifted.images[i].name = truth.images[(i + 1) % kPhotos].name;
  const Error e = error_of([&] { checked_with_pictures(shifted, pixels, painter(truth), "model"); });
  EXPECT_EQ(e.detail().code, "POSES_DISAGREE");
  EXPECT_TRUE(has(e.detail().why, "each photo has the pose of the photo before it")) << e.what();
}

TEST(PoseCheck, PicturesThatShowNothingAreSaidToShowNothing) {
  const ColmapModel truth = scene(120);
  PosePixels pixels = pixels_of(truth);
  const CheckedPoses c = checked_with_pictures(
      truth, pixels, [](const ColmapImage&) { return Image8(640, 480, 3, uint8_t{90}); }, "model");
  EXPECT_FALSE(c.checked);
  EXPECT_TRUE(warns(c, "POSES_UNCHECKED"));
}

TEST(PoseCheck, PointsAndPosesOfOneModelInOtherConventionsAreNamed) {
  ColmapModel model = scene(120);
  for (ColmapImage& image : model.images) {
    const Rigid pose = inverse(image.cam_from_world());
    image.rotation = quaternion(pose.rotation);
    image.translation = pose.translation;
  }
  PosePixels pixels = pixels_of(model);
  const Error e = error_of([&] { checked_with_pictures(model, pixels, painter(model), "model"); });
  EXPECT_TRUE(has(e.detail().why, "observations of the model's own points")) << e.what();
  EXPECT_TRUE(has(e.detail().why, "they are world-from-camera, not camera-from-world")) << e.what();
}

}  // namespace
}  // namespace vitrine
