// For which pixels given poses are: stored or upright, resized or undistorted.
#include "core/intake/poses/pose_pixels.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/intake/poses/given_poses.h"
#include "core/intake/poses/pose_check.h"
#include "core/intake/poses/pose_variants.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/ldr.h"
#include "tests/core/intake/poses/synthetic_model.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

const ColmapCamera kLens{1, 4, 640, 480, {600, 590, 330, 225, -0.05, 0.01, 0.004, -0.006}};  // OPENCV

ColmapModel lens_scene(const ColmapCamera& camera = kLens) {
  return synthetic_model(ring(8, 3, 1, {0, 0, 1}), cloud(200, 1, 0.8), camera);
}

int back(int orientation) { return orientation == 6 ? 8 : orientation == 8 ? 6 : orientation; }

// The model that a program finds that ignores EXIF: of the stored pixels of photos with these orientations.
ColmapModel as_stored(const ColmapModel& upright, const std::vector<int>& orientations) {
  ColmapModel m = upright;
  m.cameras.clear();
  bool mirrored = false;
  for (size_t i = 0; i < m.images.size(); ++i) {
    ColmapImage& image = m.images[i];
    const int turn = back(orientations[i]);
    ColmapCamera camera = upright_camera(upright.cameras[0], turn);
    camera.id = image.camera_id = uint32_t(i) + 1;
    m.cameras.push_back(camera);
    const Rigid pose = upright_pose(image.cam_from_world(), turn);
    image.rotation = quaternion(pose.rotation);
    image.translation = pose.translation;
    for (ColmapPoint2D& p : image.points) {
      const Vec2d to = upright_pixel({p.x, p.y}, turn, {640, 480});
      p.x = to.x, p.y = to.y;
    }
    mirrored |= is_mirrored(turn);
  }
  if (mirrored)
    for (ColmapPoint3D& p : m.points) p.position = mirrored_world(p.position);
  return m;
}

std::vector<Photo> turned_photos(const ColmapModel& model, const std::vector<int>& orientations) {
  std::vector<Photo> photos;
  for (size_t i = 0; i < model.images.size(); ++i) {
    Photo p;
    p.name = p.source = model.images[i].name;
    p.stem = fs::path(p.name).stem().string();
    p.width = p.original_width = 640, p.height = p.original_height = 480;  // upright
    p.orientation = orientations[i];
    photos.push_back(p);
  }
  return photos;
}

ColmapModel read(const ColmapModel& model, const std::vector<Photo>& photos, PosePixels& pixels) {
  const TemporaryFolder folder;
  write_colmap_model(folder.path(), model, ColmapFormat::Binary);
  return read_given_poses(folder.path(), photos, 0, &pixels);
}

double worst_reprojection(const ColmapModel& m) {
  double worst = 0;
  for (const ColmapPoint3D& p : m.points)
    for (const ColmapTrackElement& t : p.track) {
      const ColmapImage& image = *m.find_image(t.image_id);
      const Vec3d q = image.cam_from_world() * p.position;
      const Vec2d at = project(*m.find_camera(image.camera_id), {q.x / q.z, q.y / q.z});
      const ColmapPoint2D& seen = image.points[t.point2d_index];
      worst = std::max(worst, std::hypot(at.x - seen.x, at.y - seen.y));
    }
  return worst;
}

bool notes(const PosePixels& pixels, const std::string& code, const std::string& part) {
  return std::any_of(pixels.notes.begin(), pixels.notes.end(),
                     [&](const Note& n) { return n.code == code && n.text.find(part) != std::string::npos; });
}

TEST(PosePixels, PosesOfStoredPixelsAreTurnedWithTheirPhotos) {
  const ColmapModel truth = lens_scene();
  for (int orientation = 2; orientation <= 8; ++orientation) {
    const std::vector<int> orientations(8, orientation);
    PosePixels pixels;
    const ColmapModel model = read(as_stored(truth, orientations), turned_photos(truth, orientations), pixels);
    ASSERT_EQ(model.images.size(), 8u) << orientation;
    EXPECT_EQ(pixels.open(), !swaps_sides(orientation)) << "only sides that are swapped settle it: " << orientation;
    for (size_t i = 0; i < 8; ++i) {
      const ColmapCamera& camera = *model.find_camera(model.images[i].camera_id);
      EXPECT_EQ(camera.width, 640u);
      for (size_t k = 0; k < 8; ++k) EXPECT_NEAR(camera.params[k], truth.cameras[0].params[k], 1e-9) << orientation;
      EXPECT_LT(length(model.images[i].translation - truth.images[i].translation), 1e-9) << orientation;
    }
    EXPECT_GT(model.points.size(), 100u);
    EXPECT_LT(worst_reprojection(model), 1e-6) << orientation;
    EXPECT_EQ(notes(pixels, "POSES_MIRRORED", "the world is mirrored"), is_mirrored(orientation)) << orientation;
  }
}

TEST(PosePixels, APhotoOfSwappedSidesDecidesForThoseTurnedUpsideDown) {
  const ColmapModel truth = lens_scene();
  const std::vector<int> orientations{1, 6, 3, 8, 1, 3, 1, 1};
  PosePixels pixels;
  const ColmapModel stored = read(as_stored(truth, orientations), turned_photos(truth, orientations), pixels);
  EXPECT_FALSE(pixels.open());
  EXPECT_LT(worst_reprojection(stored), 1e-6);
  for (size_t i = 0; i < 8; ++i) EXPECT_EQ(pixels.photos[i].for_stored, orientations[i] != 1);
  // The same photos, and poses of a program that heeds EXIF: nothing is turned.
  PosePixels heeded;
  EXPECT_EQ(read(truth, turned_photos(truth, orientations), heeded).images[2].rotation, truth.images[2].rotation);
  EXPECT_FALSE(heeded.open());
}

TEST(PosePixels, OneCameraOfTheFilesSizeServesUprightAndLyingPhotos) {
  // transforms.json with one w and h for all: 480 x 640 as stored, where most photos are upright 640 x 480 by EXIF.
  const ColmapModel truth = lens_scene({1, 1, 640, 480, {600, 600, 320, 240}});
  const std::vector<int> orientations(8, 6);
  const ColmapModel stored = as_stored(truth, orientations);
  const TemporaryFolder folder;
  std::vector<View> views;
  for (const ColmapImage& image : stored.images)
    views.push_back({.name = image.name,
                     .intrinsics = pinhole_part(*stored.find_camera(image.camera_id)),
                     .cam_from_world = image.cam_from_world()});
  write_transforms_json(folder.path() / "transforms.json", views, "images");
  PosePixels pixels;
  const ColmapModel model = read_given_poses(folder.path(), turned_photos(truth, orientations), 0, &pixels);
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(model.find_camera(model.images[i].camera_id)->width, 640u);
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(model.images[i].cam_from_world().rotation(r, c), truth.images[i].cam_from_world().rotation(r, c), 1e-9);
  }
}

TEST(PosePixels, APrincipalPointInTheMiddleOfTheStoredPhotoOutweighsTheSize) {
  // The size is that of the upright photo (a reader's guess, or another tool's); everything else is for the stored pixels.
  const ColmapModel truth = lens_scene({1, 1, 640, 480, {600, 600, 320, 240}});
  const std::vector<int> orientations(8, 6);
  ColmapModel stored = as_stored(truth, orientations);
  for (ColmapCamera& camera : stored.cameras) std::swap(camera.width, camera.height);
  PosePixels pixels;
  const ColmapModel model = read(stored, turned_photos(truth, orientations), pixels);
  EXPECT_LT(worst_reprojection(model), 1e-6);
  EXPECT_EQ(model.find_camera(model.images[0].camera_id)->params, truth.cameras[0].params);
}

TEST(PosePixels, MatricesOfStoredPixelsAreTurnedWhenTheirPrincipalPointSaysSo) {
  const ColmapModel truth = lens_scene({1, 1, 640, 480, {600, 600, 324, 238}});
  const std::vector<int> orientations(8, 8);
  const ColmapModel stored = as_stored(truth, orientations);
  const TemporaryFolder folder;
  for (const ColmapImage& image : stored.images) {
    const Intrinsics k = pinhole_part(*stored.find_camera(image.camera_id));
    const Rigid pose = image.cam_from_world();
    std::string text;
    for (size_t r = 0; r < 3; ++r)
      for (size_t c = 0; c < 4; ++c) {
        const auto at = [&](size_t row) { return c < 3 ? pose.rotation(row, c) : pose.translation[row]; };
        text += fmt::format("{:.17g} ", r == 0 ? k.fx * at(0) + k.cx * at(2) : r == 1 ? k.fy * at(1) + k.cy * at(2) : at(2));
      }
    write_file(folder.path() / (fs::path(image.name).stem().string() + "_P.txt"), text);
  }
  PosePixels pixels;
  const ColmapModel model = read_given_poses(folder.path(), turned_photos(truth, orientations), 0, &pixels);
  EXPECT_FALSE(pixels.open());
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(pinhole_part(*model.find_camera(model.images[i].camera_id)).cx, 324, 1e-6);
    EXPECT_LT(length(model.images[i].translation - truth.images[i].translation), 1e-9);
  }
}

TEST(PosePixels, MirroredPhotosAmongOthersAreLeftOutOrTakenForUpright) {
  const ColmapModel truth = lens_scene();
  PosePixels pixels;
  // Sides are swapped and mirrored: the pose is of a mirrored picture in a world that is not.
  std::vector<int> orientations(8, 6);
  orientations[4] = 5;
  ColmapModel stored = as_stored(truth, orientations);
  const ColmapModel model = read(stored, turned_photos(truth, orientations), pixels);
  EXPECT_EQ(model.images.size(), 7u);
  EXPECT_TRUE(notes(pixels, "POSES_MIRRORED", "1 photos are left out"));
  // Mirrored without swapped sides: no program places such a picture as stored.
  std::vector<int> flips(8, 1);
  flips[4] = 2;
  PosePixels flipped;
  EXPECT_EQ(read(truth, turned_photos(truth, flips), flipped).images.size(), 8u);
  EXPECT_FALSE(flipped.open());
}

TEST(PosePixels, WhatSizesLeaveOpenIsAWarningUntilThePicturesSettleIt) {
  const ColmapModel truth = lens_scene();
  const std::vector<int> orientations{1, 3, 1, 3, 1, 3, 1, 3};
  const auto picture = [&](const ColmapImage& asked) {  // upright, as ingested: a colour for every place
    Image8 out(640, 480, 3, uint8_t{20});
    for (const ColmapImage& image : truth.images)
      for (const ColmapPoint2D& p : image.points) {
        if (image.name != asked.name || p.point3d_id == kNoPoint3D) continue;
        Rng rng(11, p.point3d_id);
        const uint8_t colour[] = {uint8_t(rng.below(256)), uint8_t(rng.below(256)), uint8_t(rng.below(256))};
        for (int y = std::max(0, int(p.y) - 5); y < std::min(480, int(p.y) + 6); ++y)
          for (int x = std::max(0, int(p.x) - 5); x < std::min(640, int(p.x) + 6); ++x) std::copy_n(colour, 3, out.pixel(x, y));
      }
    return out;
  };
  for (const bool heeds_exif : {false, true}) {
    PosePixels pixels;
    ColmapModel given = read(heeds_exif ? truth : as_stored(truth, orientations), turned_photos(truth, orientations), pixels);
    EXPECT_TRUE(pixels.open());
    EXPECT_TRUE(notes(pixels, "POSES_ORIENTATION", "as stored is assumed")) << "COLMAP ignores EXIF";
    const CheckedPoses checked = checked_with_pictures(std::move(given), pixels, picture, "model");
    EXPECT_FALSE(pixels.open());
    EXPECT_FALSE(notes(pixels, "POSES_ORIENTATION", "")) << "settled";
    EXPECT_LT(worst_reprojection(checked.model), 1e-6);
    for (size_t i = 0; i < 8; ++i)
      EXPECT_LT(length(checked.model.images[i].translation - truth.images[i].translation), 1e-9) << heeds_exif;
  }
}

ColmapModel resized_model(ColmapModel m, uint64_t width, uint64_t height) {
  const double s = double(width) / double(m.cameras[0].width);
  m.cameras[0].width = width, m.cameras[0].height = height;
  for (size_t k = 0; k < 4; ++k) m.cameras[0].params[k] *= s;
  for (ColmapImage& image : m.images)
    for (ColmapPoint2D& p : image.points) p.x *= s, p.y *= s;
  return m;
}

TEST(PosePixels, UsualSizesAreScaledQuietlyAndOddOnesWithAWarning) {
  const ColmapModel truth = lens_scene({1, 1, 640, 480, {600, 600, 320, 240}});
  for (const auto& [width, height, code] :
       {std::tuple(320, 240, ""), std::tuple(1280, 960, ""), std::tuple(160, 120, ""), std::tuple(1600, 1200, ""),
        std::tuple(624, 468, "POSES_RESIZED"), std::tuple(652, 489, "POSES_RESIZED")}) {
    PosePixels pixels;
    const ColmapModel model =
        read(resized_model(truth, uint64_t(width), uint64_t(height)), turned_photos(truth, std::vector<int>(8, 1)), pixels);
    EXPECT_NEAR(model.cameras[0].params[0], 600, 1e-9);
    ASSERT_EQ(pixels.notes.size(), 1u) << width;
    EXPECT_EQ(pixels.notes[0].code, code) << width;
    EXPECT_EQ(pixels.oddly_resized, std::string_view(code) == "POSES_RESIZED");
  }
}

// Networks of patches of 14 pixels: 640 x 480 becomes 518 x 392, 0.9 % off.
TEST(PosePixels, SizesRoundedToMultiplesAreScaledBySide) {
  const ColmapCamera lenses[] = {{1, 1, 640, 480, {600, 600, 320, 240}},
                                 {1, 0, 640, 480, {600, 320, 240}},
                                 {1, 2, 640, 480, {600, 320, 240, 0.02}},
                                 {1, 3, 640, 480, {600, 320, 240, 0.02, -0.01}}};
  for (const ColmapCamera& lens : lenses) {
    const ColmapModel truth = lens_scene(lens);
    const double sx = 518.0 / 640, sy = 392.0 / 480;
    ColmapModel given = truth;  // pictures resized by side; a camera of one focal length has that of the width
    given.cameras[0].width = 518, given.cameras[0].height = 392;
    for (size_t k = 0; k < (lens.model_id == 1 ? 4 : 3); ++k)
      given.cameras[0].params[k] *= (lens.model_id == 1 ? k % 2 == 1 : k == 2) ? sy : sx;
    PosePixels pixels;
    const ColmapModel model = read(given, turned_photos(truth, std::vector<int>(8, 1)), pixels);
    const Intrinsics k = pinhole_part(model.cameras[0]);
    EXPECT_NEAR(k.fx, 600, 1e-9);
    EXPECT_NEAR(k.fy, lens.model_id == 1 ? 600 : 600 * sx / sy, 1e-9);
    EXPECT_NEAR(k.cx, 320, 1e-9);
    EXPECT_NEAR(k.cy, 240, 1e-9);
    EXPECT_EQ(is_distorted(model.cameras[0]), lens.model_id > 1);
    ASSERT_EQ(pixels.notes.size(), 1u);
    EXPECT_EQ(pixels.notes[0].code, "POSES_RESIZED");
    EXPECT_NE(pixels.notes[0].text.find("the aspect ratio differs by 0.9 %: each side has its own scale"), std::string::npos)
        << pixels.notes[0].text;
  }
  // Off by more, and off by as much without being rounded.
  const ColmapModel truth = lens_scene({1, 1, 640, 480, {600, 600, 320, 240}});
  for (const auto& [width, height] : {std::pair(518, 378), {636, 481}, {517, 391}}) {
    ColmapModel given = truth;
    given.cameras[0].width = uint64_t(width), given.cameras[0].height = uint64_t(height);
    PosePixels pixels;
    EXPECT_EQ(error_of([&] { read(given, turned_photos(truth, std::vector<int>(8, 1)), pixels); }).detail().code, "POSES_SIZE");
  }
}

TEST(PosePixels, PosesOfUndistortedPicturesAreRefusedAndThePicturesNamed) {
  const ColmapModel truth = lens_scene({1, 1, 640, 480, {600, 600, 320, 240}});
  const std::vector<Photo> photos = turned_photos(truth, std::vector<int>(8, 1));
  const ColmapModel cropped = resized_model(truth, 624, 468);
  // Pictures of the cameras' size beside the model, in COLMAP's layout and in ours.
  for (const char* layout : {"sparse", "sparse/0"}) {
    const TemporaryFolder folder;
    make_folders(folder.path() / layout);
    make_folders(folder.path() / "images");
    write_colmap_model(folder.path() / layout, cropped, ColmapFormat::Binary);
    for (const ColmapImage& image : cropped.images) write_ldr(folder.path() / "images" / image.name, Image8(624, 468, 3));
    const Error e = error_of([&] { read_given_poses(folder.path(), photos, 0); });
    EXPECT_EQ(e.detail().code, "POSES_UNDISTORTED");
    EXPECT_NE(e.detail().hint.find((folder.path() / "images").string()), std::string::npos) << e.what();
  }
  // Half the size, and the pictures of the model beside it: images given where the poses are for images_2.
  const TemporaryFolder halves;
  make_folders(halves.path() / "sparse/0");
  make_folders(halves.path() / "images");
  const ColmapModel half = resized_model(truth, 320, 240);
  write_colmap_model(halves.path() / "sparse/0", half, ColmapFormat::Binary);
  for (const ColmapImage& image : half.images) write_ldr(halves.path() / "images" / image.name, Image8(320, 240, 3));
  EXPECT_NO_THROW(read_given_poses(halves.path(), photos, 0));
}

TEST(PosePixels, AnEarlierRunsReportTellsItsUndistortedPictures) {
  const ColmapModel truth = lens_scene({1, 1, 640, 480, {600, 600, 320, 240}});
  const TemporaryFolder folder;
  make_folders(folder.path() / "sparse/0");
  make_folders(folder.path() / "sfm");
  write_colmap_model(folder.path() / "sparse/0", resized_model(truth, 600, 450), ColmapFormat::Binary);
  write_file(folder.path() / "sfm/lenses.json", R"({"cameras": [{"photographed": {"width": 640, "height": 480},
      "undistorted": {"width": 600, "height": 450}, "resampled": true}]})");
  const Error e = error_of([&] { read_given_poses(folder.path(), turned_photos(truth, std::vector<int>(8, 1)), 0); });
  EXPECT_EQ(e.detail().code, "POSES_UNDISTORTED") << "600 is a usual size, but the report is certain";
}

TEST(PosePixels, CroppedOrResizedIsDecidedByMatches) {
  const ColmapModel truth = lens_scene({1, 1, 640, 480, {600, 600, 320, 240}});
  std::vector<PhotoMatches> matches;
  for (size_t i = 0; i < truth.images.size(); ++i) {
    const ColmapImage &a = truth.images[i], &b = truth.images[(i + 1) % truth.images.size()];
    PhotoMatches& m = matches.emplace_back(PhotoMatches{a.name, b.name, {}, {}});
    for (const ColmapPoint2D& p : a.points)
      for (const ColmapPoint2D& q : b.points)
        if (p.point3d_id != kNoPoint3D && p.point3d_id == q.point3d_id)
          m.in_a.push_back({p.x, p.y}), m.in_b.push_back({q.x, q.y});
  }
  ColmapModel cropped = truth;
  cropped.cameras[0] = {1, 1, 624, 468, {600, 600, 312, 234}};
  for (ColmapImage& image : cropped.images)
    for (ColmapPoint2D& p : image.points) p.x -= 8, p.y -= 6;
  PosePixels pixels;
  const ColmapModel as_crop = read(cropped, turned_photos(truth, std::vector<int>(8, 1)), pixels);
  EXPECT_EQ(error_of([&] { checked_with_matches(as_crop, pixels, matches, "poses"); }).detail().code, "POSES_CROPPED");
  const ColmapModel as_size = read(resized_model(truth, 624, 468), turned_photos(truth, std::vector<int>(8, 1)), pixels = {});
  checked_with_matches(as_size, pixels, matches, "poses");
  EXPECT_FALSE(notes(pixels, "POSES_RESIZED", "")) << "the matches say that they are resized";
  EXPECT_TRUE(notes(pixels, "", "fit them resized"));
}

}  // namespace
}  // namespace vitrine
