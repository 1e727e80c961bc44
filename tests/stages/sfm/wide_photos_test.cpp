// Fisheye photos with known poses become views: cameras, observations, pictures and lenses agree with the photos.
#include "stages/sfm/wide_photos.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/intake/poses/photo_orientation.h"
#include "core/scene/camera/colmap_lens.h"
#include "core/scene/camera/holdout.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "stages/sfm/outputs.h"
#include "stages/sfm/photo_gains.h"
#include "tests/core/intake/poses/synthetic_model.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

constexpr int kSide = 120;
const ColmapCamera kFisheye{7, 5, kSide, kSide, {38.2, 38.2, 60, 60, 0, 0, 0, 0}};  // 180 degrees
const ColmapCamera kPinhole{9, 1, 80, 60, {70, 70, 40, 30}};

// Brightness by direction in the camera; black outside the circle.
ImageF fisheye_picture() {
  ImageF picture(kSide, kSide, 3, 0.f);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const auto ray = ray_of_pixel(kFisheye, {x + 0.5, y + 0.5});
      if (!ray || std::hypot(x + 0.5 - 60, y + 0.5 - 60) > 60) continue;
      const Vec3d d = normalized(*ray);
      picture.at(x, y, 0) = float(0.5 + 0.3 * d.x), picture.at(x, y, 1) = float(0.5 + 0.3 * d.y);
      picture.at(x, y, 2) = float(0.3 + 0.3 * d.z);
    }
  return picture;
}

class WidePhotos : public testing::Test {
 protected:
  WidePhotos() {
    // Three fisheye photos in a cloud of points, one pinhole photo.
    const std::vector<Rigid> poses{
        camera_looking({0, 0, 0}, {1, 0.2, 0}, {0, 0, 1}), camera_looking({0.3, 0, 0.1}, {0, 1, 0}, {0, 0, 1}),
        camera_looking({0, 0.3, 0}, {-1, 0, 0.3}, {0, 0, 1}), camera_looking({0, 0, 0.2}, {1, 1, 0}, {0, 0, 1})};
    model.cameras = {kFisheye, kPinhole};
    const std::vector<Vec3d> points = cloud(200, 3, 2.0);
    for (size_t p = 0; p < points.size(); ++p) model.points.push_back({.id = p + 1, .position = points[p]});
    for (size_t i = 0; i < poses.size(); ++i) {
      const ColmapCamera& camera = i < 3 ? kFisheye : kPinhole;
      ColmapImage image{.id = uint32_t(i) + 1,
                        .rotation = quaternion(poses[i].rotation),
                        .translation = poses[i].translation,
                        .camera_id = camera.id,
                        .name = std::string("set/") + char('a' + i) + ".png",
                        .points = {{1, 1, kNoPoint3D}}};
      for (ColmapPoint3D& point : model.points) {
        const Vec3d ray = normalized(poses[i] * point.position);
        if (ray.z < (i < 3 ? 0.02 : 0.8)) continue;
        const Vec2d pixel = project_ray(camera, ray);
        if (pixel.x < 0 || pixel.y < 0 || pixel.x > double(camera.width) || pixel.y > double(camera.height)) continue;
        point.track.push_back({image.id, uint32_t(image.points.size())});
        image.points.push_back({pixel.x, pixel.y, point.id});
      }
      Photo photo{.name = image.name, .stem = fs::path(image.name).replace_extension().generic_string(), .source = image.name};
      photo.width = photo.original_width = int(camera.width), photo.height = photo.original_height = int(camera.height);
      const ImageF picture = i < 3 ? fisheye_picture() : ImageF(80, 60, 3, 0.4f);
      for (const fs::path& path : {ingested_linear_path(ingest(), photo), ingested_ldr_path(ingest(), photo)})
        make_folders(path.parent_path());
      write_exr_rgb(ingested_linear_path(ingest(), photo), picture);
      write_ldr(ingested_ldr_path(ingest(), photo), srgb8_from_linear(picture));
      photos.push_back(photo);
      model.images.push_back(std::move(image));
    }
    std::erase_if(model.points, [&](const ColmapPoint3D& p) {
      if (p.track.size() >= 2) return false;
      for (const ColmapTrackElement& t : p.track) model.images[t.image_id - 1].points[t.point2d_index].point3d_id = kNoPoint3D;
      return true;
    });
    check_colmap_model(model, "test");
  }
  fs::path ingest() const { return folder.path() / "ingest"; }

  TemporaryFolder folder;
  ColmapModel model;
  std::vector<Photo> photos;
};

TEST_F(WidePhotos, BecomeViewsThatShareThePlaceOfTheirPhoto) {
  const CutPhotos cut = cut_photos(model, photos, ingest());
  EXPECT_EQ(cut.cut, 3u);
  ASSERT_EQ(cut.model.images.size(), 3u * 5 + 1);
  EXPECT_EQ(cut.photos.size(), 16u);
  EXPECT_EQ(cut.model.images[6].name, "set/b/view_01.png");
  EXPECT_EQ(cut.photos[6].rig->panorama, "set/b.png");
  EXPECT_EQ(cut.photo_of(cut.photos[6]).name, "set/b.png");
  EXPECT_EQ(cut.photo_of(cut.photos[15]).name, "set/d.png");
  EXPECT_NEAR(cut.undistortions[0].circle_px, 58.5, 1.5) << "the circle is found in the photos";

  const ColmapModel views = undistorted(cut.model, cut.undistortions);
  size_t seen = 0, before = 0;
  double worst = 0;
  for (const ColmapImage& image : model.images)
    for (const ColmapPoint2D& p : image.points) before += p.point3d_id != kNoPoint3D;
  for (const ColmapImage& image : views.images) {
    const Photo& photo = cut.photo_of(*std::ranges::find(cut.photos, image.name, &Photo::name));
    const ColmapImage& taken = *std::ranges::find(model.images, photo.name, &ColmapImage::name);
    EXPECT_LT(length(inverse(image.cam_from_world()).translation - inverse(taken.cam_from_world()).translation), 1e-12);
    for (const ColmapPoint2D& p : image.points) {
      const Vec3d q = image.cam_from_world() * views.find_point(p.point3d_id)->position;
      const Vec2d pixel = project(*views.find_camera(image.camera_id), {q.x / q.z, q.y / q.z});
      worst = std::max(worst, std::hypot(pixel.x - p.x, pixel.y - p.y));
      ++seen;
    }
  }
  EXPECT_LT(worst, 1e-6) << "observations lie where the views show their points";
  EXPECT_GT(double(seen), 0.95 * double(before)) << "hardly any is lost";
  ColmapModel again = views;
  check_colmap_model(again, "views");
}

TEST_F(WidePhotos, HaveTheirPicturesAndLensesOnDisk) {
  const CutPhotos cut = cut_photos(model, photos, ingest());
  const ColmapModel views = undistorted(cut.model, cut.undistortions);
  const fs::path out = folder.path() / "sfm";
  make_folders(out / "sfm");
  write_pictures({.ingest = ingest(), .output = out, .photos = &cut, .progress = {}});
  write_lenses(out / "sfm/lenses.json", cut.undistortions, views, {}, cut.photos);
  write_colmap_model(out / "sparse/0", views, ColmapFormat::Binary);
  write_scene_info(out / "scene.json", {});
  Gains gains;
  Rigs rigs;
  for (const Photo& p : cut.photos) gains[p.name] = {1, 1, 1};
  for (const auto& [view, photo] : cut.ingested) rigs[view] = photo.name;
  write_gains(out / "sfm/gains.json", gains);
  write_rigs(out, rigs);

  const ViewSet set = load_view_set(out);
  const PhotoLenses lenses = read_photo_lenses(out, set);
  ASSERT_EQ(lenses.undistortions.size(), 16u);
  EXPECT_EQ(lenses.photos[6], "set/b.png");
  EXPECT_EQ(lenses.photos[15], "set/d.png");
  for (size_t v = 0; v < 15; ++v) {
    const Undistortion& u = lenses.undistortions[v];
    ASSERT_TRUE(u.rotation);
    const ImageF picture = read_exr_rgb(linear_image_path(out, set.views[v])), unseen = unseen_pixels(u);
    ASSERT_EQ(picture.width(), u.target.width);
    double worst = 0;
    for (int y = 0; y < picture.height(); ++y)
      for (int x = 0; x < picture.width(); ++x) {
        if (unseen.pixel_count() > 0 && unseen.at(x, y) > 0) {
          EXPECT_EQ(picture.at(x, y, 0), 0);
          continue;
        }
        const Vec3d d = normalized(transposed_times(*u.rotation, u.target.ray(x + 0.5, y + 0.5)));
        worst = std::max(worst, std::abs(picture.at(x, y, 0) - (0.5 + 0.3 * d.x)));
      }
    EXPECT_LT(worst, 0.01) << set.views[v].name;
  }
  const std::vector<uint8_t> heldout = heldout_views(out, set.views, 2);
  for (size_t v = 0; v < 16; ++v) EXPECT_EQ(heldout[v] != 0, v / 5 % 2 == 0) << "by photo: " << set.views[v].name;
}

TEST_F(WidePhotos, AllViewsOfAPhotoHaveItsExposure) {
  const CutPhotos cut = cut_photos(model, photos, ingest());
  const ColmapModel views = undistorted(cut.model, cut.undistortions);
  test::RecordingContext context({});
  for (const ColmapImage& image : views.images) {
    const ColmapCamera& camera = *views.find_camera(image.camera_id);
    const float level = image.name.starts_with("set/b") ? 0.2f : 0.4f;
    const fs::path path = context.output() / "linear" / fs::path(image.name).replace_extension(".exr");
    make_folders(path.parent_path());
    write_exr_rgb(path, ImageF(int(camera.width), int(camera.height), 3, level));
  }
  const Gains gains = photo_gains(views, cut.photos, context.output(), context);
  ASSERT_EQ(gains.size(), 16u);
  for (const auto& [name, gain] : gains) {
    if (name == "set/d.png") continue;  // few tracks of its own
    const bool dark = name.starts_with("set/b");
    EXPECT_NEAR(gain.y, gains.at(dark ? "set/b/view_00.png" : "set/a/view_00.png").y, 0.02) << name;
  }
  EXPECT_NEAR(gains.at("set/a/view_03.png").y / gains.at("set/b/view_03.png").y, 2, 0.1);
}

TEST_F(WidePhotos, DamagedRotationsAreRefused) {
  const CutPhotos cut = cut_photos(model, photos, ingest());
  const fs::path out = folder.path() / "sfm";
  make_folders(out / "sfm");
  const ColmapModel views = undistorted(cut.model, cut.undistortions);
  write_colmap_model(out / "sparse/0", views, ColmapFormat::Binary);
  for (const char* rotation : {"[1, 0, 0]", "[2, 0, 0, 0]", "\"none\""}) {
    write_file(out / "sfm/lenses.json",
               R"({"cameras": [{"photographed": {"id": 1, "model": "OPENCV_FISHEYE", "width": 120, "height": 120,
                   "params": [38, 38, 60, 60, 0, 0, 0, 0]}, "circle_px": 58, "view_from_photo": )" +
                   std::string(rotation) + "}]}");
    EXPECT_EQ(error_of([&] { read_photo_lenses(out, {}); }).kind(), ErrorKind::Input) << rotation;
  }
}

TEST_F(WidePhotos, NarrowPhotosStayAsTheyAre) {
  for (ColmapCamera& camera : model.cameras)
    if (camera.model_id == 5) camera.params[0] = camera.params[1] = 70;  // 98 degrees
  for (ColmapImage& image : model.images) image.points.clear();
  model.points.clear();
  const CutPhotos cut = cut_photos(model, photos, ingest());
  EXPECT_EQ(cut.cut, 0u);
  EXPECT_EQ(cut.model, model);
  EXPECT_EQ(cut.photos, photos);
}

}  // namespace
}  // namespace vitrine
