#include "core/intake/poses/given_poses.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/scene/camera/view_set.h"
#include "stages/sfm/sfm.h"
#include "tests/core/intake/poses/synthetic_model.h"
#include "tests/stages/sfm/sfm_support.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

struct Matrix {
  double p[12];
};

// factor * K [R | t]
Matrix projection(double fx, double fy, double cx, double cy, double skew, const Rigid& cam_from_world, double factor) {
  Matrix m;
  for (size_t j = 0; j < 4; ++j) {
    const auto column = [&](size_t i) { return j < 3 ? cam_from_world.rotation(i, j) : cam_from_world.translation[i]; };
    m.p[j] = factor * (fx * column(0) + skew * column(1) + cx * column(2));
    m.p[4 + j] = factor * (fy * column(1) + cy * column(2));
    m.p[8 + j] = factor * column(2);
  }
  return m;
}

std::vector<Photo> photos_of(const ColmapModel& model, int width, int height) {
  std::vector<Photo> photos;
  for (const ColmapImage& image : model.images) {
    Photo p;
    p.name = p.source = image.name;
    p.stem = fs::path(image.name).stem().string();
    p.width = p.original_width = width, p.height = p.original_height = height;
    photos.push_back(p);
  }
  return photos;
}

TEST(DecomposedProjection, GivesBackCameraAndPoseWhateverTheFactor) {
  for (const Rigid& pose : ring(7, 3, 1, {0.6, 0.48, -0.64}, 0.3))
    for (const double factor : {1.0, -1.0, 1e-4, -250.0}) {
      const Matrix m = projection(820, 815, 333, 251, 0, pose, factor);
      const Decomposed d = decomposed_projection(m.p, "test");
      EXPECT_NEAR(d.fx, 820, 1e-8);
      EXPECT_NEAR(d.fy, 815, 1e-8);
      EXPECT_NEAR(d.cx, 333, 1e-8);
      EXPECT_NEAR(d.cy, 251, 1e-8);
      for (size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(d.cam_from_world.translation[i], pose.translation[i], 1e-9);
        for (size_t j = 0; j < 3; ++j) EXPECT_NEAR(d.cam_from_world.rotation(i, j), pose.rotation(i, j), 1e-11);
      }
    }
}

TEST(DecomposedProjection, RefusesSkewAndSingularMatrices) {
  const Rigid pose = ring(1, 3, 1, {0, 0, 1})[0];
  EXPECT_NO_THROW(decomposed_projection(projection(800, 800, 320, 240, 0.4, pose, 1).p, "P/1.txt"));
  const Error skew = error_of([&] { decomposed_projection(projection(800, 800, 320, 240, 5, pose, 1).p, "P/1.txt"); });
  EXPECT_EQ(skew.kind(), ErrorKind::Input);
  EXPECT_EQ(skew.detail().where, "P/1.txt");
  EXPECT_EQ(error_of([&] { decomposed_projection({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1}, "x"); }).kind(), ErrorKind::Input);
  EXPECT_EQ(error_of([&] { decomposed_projection({0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 1, 1}, "x"); }).kind(), ErrorKind::Input);
}

TEST(GivenPoses, MatricesOfLargerOriginalsAreScaledToThePhotos) {
  const ColmapModel truth = synthetic_model(ring(5, 3, 1, {0, 0, 1}), cloud(50, 1));
  const TemporaryFolder folder;
  for (const ColmapImage& image : truth.images) {
    // The originals were twice as large; principal point a little off the centre.
    const Matrix m = projection(1200, 1200, 655, 470, 0, image.cam_from_world(), -3);
    std::string text;
    for (int i = 0; i < 12; ++i) text += fmt::format("{:.17g}{}", m.p[i], i % 4 == 3 ? "\n" : " ");
    make_folders(folder.path() / "P");
    write_file(folder.path() / "P" / (fs::path(image.name).stem().string() + "_P.txt"), text);
  }
  const ColmapModel model = read_given_poses(folder.path(), photos_of(truth, 640, 480), 0);
  ASSERT_EQ(model.images.size(), 5u);
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(model.images[i].name, truth.images[i].name);
    EXPECT_LT(length(model.images[i].translation - truth.images[i].translation), 1e-9);
    const Intrinsics k = pinhole_part(*model.find_camera(model.images[i].camera_id));
    EXPECT_NEAR(k.fx, 600, 1e-8);
    EXPECT_NEAR(k.cx, 327.5, 1e-8);
  }
  // The user's word goes before the guess.
  EXPECT_NEAR(pinhole_part(read_given_poses(folder.path(), photos_of(truth, 640, 480), 0.25).cameras[0]).fx, 300, 1e-8);
}

TEST(GivenPoses, MatricesStoredByColumnsAreNamed) {
  const ColmapModel truth = synthetic_model(ring(5, 3, 1, {0, 0, 1}), cloud(50, 1));
  const TemporaryFolder folder;
  for (const ColmapImage& image : truth.images) {
    const Matrix m = projection(600, 600, 325, 236, 0, image.cam_from_world(), 1);
    std::string text;
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 3; ++row) text += fmt::format("{:.17g} ", m.p[4 * row + column]);
    write_file(folder.path() / (fs::path(image.name).stem().string() + ".txt"), text + "\n");
  }
  const Error e = error_of([&] { read_given_poses(folder.path(), photos_of(truth, 640, 480), 0); });
  EXPECT_EQ(e.detail().code, "POSES_BAD_MATRIX");
  EXPECT_NE(std::string(e.what()).find("stored by columns"), std::string::npos) << e.what();
  EXPECT_NE(e.detail().why.find("a focal length of 600"), std::string::npos) << e.detail().why;
}

// RealityScan writes FULL_OPENCV with zeros for pictures that it undistorted.
TEST(GivenPoses, LensesWhoseFurtherParametersAreZeroAreReadAsSimplerOnes) {
  const auto model_read = [](std::vector<double> params) {
    const ColmapCamera lens{1, colmap_camera_type("FULL_OPENCV")->id, 640, 480, std::move(params)};
    ColmapModel truth = synthetic_model(ring(5, 3, 1, {0, 0, 1}), cloud(50, 1));
    truth.cameras = {lens};
    const TemporaryFolder folder;
    write_colmap_model(folder.path(), truth, ColmapFormat::Text);
    const ColmapModel read = read_given_poses(folder.path(), photos_of(truth, 640, 480), 0);
    return std::string(colmap_camera_type(read.cameras.at(0).model_id)->name);
  };
  EXPECT_EQ(model_read({600, 600, 320, 240, 0, 0, 0, 0, 0, 0, 0, 0}), "PINHOLE");
  EXPECT_EQ(model_read({600, 600, 320, 240, 0.01, 0.002, 0, 0, 0, 0, 0, 0}), "OPENCV");
  EXPECT_EQ(model_read({600, 600, 320, 240, 0.01, 0.002, 0, 0, 0.003, 0, 0, 0}), "FULL_OPENCV");
}

TEST(GivenPoses, ColmapModelIsScaledToTheIngestedSizeAndKeepsItsPoints) {
  const ColmapModel truth = synthetic_model(ring(6, 3, 1, {0, 0, 1}), cloud(80, 1), {1, 2, 640, 480, {600, 320, 240, 0.01}});
  for (const ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text}) {
    const TemporaryFolder folder;
    make_folders(folder.path() / "sparse" / "0");
    write_colmap_model(folder.path() / "sparse" / "0", truth, format);
    std::vector<Photo> photos = photos_of(truth, 320, 240);
    photos.erase(photos.begin() + 2);  // one pose has no photo, one photo no pose
    photos.push_back(photos[0]);
    photos.back().name = photos.back().source = "other.jpg";
    photos.back().stem = "other";
    const ColmapModel model = read_given_poses(folder.path(), photos, 0);
    EXPECT_EQ(model.images.size(), 5u);
    EXPECT_GT(model.points.size(), 40u);
    EXPECT_EQ(model.cameras[0].params, (std::vector<double>{300, 160, 120, 0.01}));
    for (const ColmapPoint3D& p : model.points)
      for (const ColmapTrackElement& t : p.track) {
        const ColmapImage& image = *model.find_image(t.image_id);
        const Vec3d q = image.cam_from_world() * p.position;
        EXPECT_NEAR(project(model.cameras[0], {q.x / q.z, q.y / q.z}).x, image.points[t.point2d_index].x, 1e-6);
      }
  }
}

TEST(GivenPoses, TransformsJsonWithoutExtensionsMeansTheSamePhotos) {
  const ColmapModel truth = synthetic_model(ring(6, 3, 1, {0, 0, 1}), cloud(80, 1));
  const TemporaryFolder folder;
  std::vector<View> views;
  for (const ColmapImage& image : truth.images)
    views.push_back({.name = fs::path(image.name).stem().string(),
                     .intrinsics = pinhole_part(truth.cameras[0]),
                     .cam_from_world = image.cam_from_world()});
  write_transforms_json(folder.path() / "transforms.json", views, "images");
  for (const fs::path& path : {folder.path(), folder.path() / "transforms.json"}) {
    const ColmapModel model = read_given_poses(path, photos_of(truth, 640, 480), 0);
    ASSERT_EQ(model.images.size(), 6u);
    EXPECT_EQ(model.images[4].name, truth.images[4].name);
    EXPECT_LT(length(model.images[4].translation - truth.images[4].translation), 1e-6);
  }
}

TEST(GivenPoses, WithPointsNoFeatureIsUsedAndNoMaskIsRead) {
  const TemporaryFolder folder;
  const ColmapModel truth = synthetic_model(ring(6, 3, 1, {0, 0, 1}), cloud(120, 1), {1, 1, 64, 48, {60, 60, 32, 24}});
  make_folders(folder.path() / "photos");
  make_folders(folder.path() / "masks/specular");
  make_folders(folder.path() / "poses");
  for (const ColmapImage& image : truth.images) {
    write_ldr(folder.path() / "photos" / image.name, Image8(64, 48, 3, uint8_t{120}));
    // All black: refused wherever features are held to it.
    write_ldr(folder.path() / "masks/specular" / (image.name + ".png"), Image8(64, 48, 1));
  }
  make_ingest(folder.path() / "photos", folder.path() / "ingest");
  write_colmap_model(folder.path() / "poses", truth, ColmapFormat::Binary);
  RecordingContext context(
      {{"ingest", folder.path() / "ingest"}, {"poses", folder.path() / "poses"}, {"masks", folder.path() / "masks"}},
      folder.path());
  sfm_stage().run(context);
  EXPECT_EQ(load_view_set(context.output()).views.size(), 6u);
}

TEST(GivenPoses, AModelOfOtherPhotosEndsTheStage) {
  const TemporaryFolder folder;
  const ColmapModel truth = synthetic_model(ring(8, 3, 1, {0, 0, 1}), cloud(120, 1, 0.8), {1, 1, 320, 240, {300, 300, 160, 120}});
  make_folders(folder.path() / "photos");
  for (const ColmapImage& image : truth.images) {
    Image8 photo(320, 240, 3, uint8_t{20});  // a spot of its own colour for every place
    for (const ColmapPoint2D& p : image.points) {
      if (p.point3d_id == kNoPoint3D) continue;
      Rng rng(11, p.point3d_id);
      const uint8_t colour[] = {uint8_t(rng.below(256)), uint8_t(rng.below(256)), uint8_t(rng.below(256))};
      for (int y = std::max(0, int(p.y) - 4); y < std::min(240, int(p.y) + 5); ++y)
        for (int x = std::max(0, int(p.x) - 4); x < std::min(320, int(p.x) + 5); ++x) std::copy_n(colour, 3, photo.pixel(x, y));
    }
    write_ldr(folder.path() / "photos" / image.name, photo);
  }
  make_ingest(folder.path() / "photos", folder.path() / "ingest");
  const auto run = [&](const ColmapModel& model, const char* name) {
    make_folders(folder.path() / name);
    write_colmap_model(folder.path() / name, model, ColmapFormat::Binary);
    RecordingContext context({{"ingest", folder.path() / "ingest"}, {"poses", folder.path() / name}},
                             folder.path() / (std::string(name) + "_run"));
    sfm_stage().run(context);
    return context.last_summary;
  };
  EXPECT_NE(run(truth, "right").find("registered 8/8"), std::string::npos);
  ColmapModel shifted = truth;
  for (size_t i = 0; i < 8; ++i) shifted.images[i].name = truth.images[(i + 1) % 8].name;
  EXPECT_EQ(error_of([&] { run(shifted, "shifted"); }).detail().code, "POSES_DISAGREE");
}

TEST(GivenPoses, SaysWhatIsWrong) {
  const ColmapModel truth = synthetic_model(ring(6, 3, 1, {0, 0, 1}), cloud(80, 1));
  const TemporaryFolder folder;
  EXPECT_EQ(error_of([&] { read_given_poses(folder.path(), photos_of(truth, 640, 480), 0); }).detail().code, "POSES_MISSING");
  make_folders(folder.path() / "sparse" / "0");
  write_colmap_model(folder.path() / "sparse" / "0", truth, ColmapFormat::Binary);
  EXPECT_EQ(error_of([&] { read_given_poses(folder.path(), photos_of(truth, 480, 640), 0); }).detail().code, "POSES_SIZE");
  // Cropped by a sixtieth: the principal point would lie wrong.
  EXPECT_EQ(error_of([&] { read_given_poses(folder.path(), photos_of(truth, 640, 472), 0); }).detail().code, "POSES_SIZE");
  std::vector<Photo> strangers = photos_of(truth, 640, 480);
  for (Photo& p : strangers) p.name = p.source = "x" + p.name, p.stem = "x" + p.stem;
  EXPECT_EQ(error_of([&] { read_given_poses(folder.path(), strangers, 0); }).detail().code, "POSES_DO_NOT_MATCH");
}

}  // namespace
}  // namespace vitrine
