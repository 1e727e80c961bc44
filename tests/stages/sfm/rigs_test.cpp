#include "stages/sfm/rigs.h"

#include <gtest/gtest.h>

#include "core/scene/camera/panorama_views.h"

namespace vitrine {
namespace {

const Rigid kPose{rotation_matrix(normalized(Quatd{1, 0.2, -0.3, 0.4})), {0.5, -1, 2}};

std::vector<SfmPhoto> panorama_photos() {
  std::vector<SfmPhoto> photos;
  for (int v = 0; v < kPanoramaViews; ++v)
    photos.push_back({.name = fmt::format("a/view_{:02}.png", v),
                      .picture = {},
                      .width = 120,
                      .height = 120,
                      .focal_px = 60,
                      .camera = {},
                      .rig = PhotoRig{"a.png", quaternion(panorama_view_rotation(v))}});
  photos.push_back({.name = "b.png", .picture = {}, .width = 100, .height = 80, .focal_px = {}, .camera = {}});
  return photos;
}

ColmapImage image_of(const SfmPhoto& photo, uint32_t id, const Vec3d& shift, uint32_t camera = 1) {
  const Rigid pose =
      (photo.rig ? Rigid{rotation_matrix(photo.rig->rotation), {}} * kPose : kPose) * Rigid{Mat3d::identity(), shift};
  return {.id = id,
          .rotation = quaternion(pose.rotation),
          .translation = pose.translation,
          .camera_id = camera,
          .name = photo.name,
          .points = {}};
}

TEST(Rigs, ThePoseIsThatOfMostViewsAndAllViewsGetIt) {
  const std::vector<SfmPhoto> photos = panorama_photos();
  ColmapModel model;
  model.cameras = {{.id = 1, .model_id = 0, .width = 120, .height = 120, .params = {63, 60, 60}},
                   {.id = 2, .model_id = 2, .width = 100, .height = 80, .params = {90, 50, 40, 0.1}}};
  const double kOff = 1e-3;
  model.images = {image_of(photos[0], 1, {kOff, 0, 0}), image_of(photos[3], 2, {-kOff, 0, 0}),
                  image_of(photos[5], 3, {0, kOff, 0}), image_of(photos[8], 4, {3, -4, 5}),  // registered at a wrong place
                  image_of(photos[10], 5, {0.1, 0, 0}, 2)};
  const ColmapModel out = with_rig_poses(model, photos);
  ASSERT_EQ(out.images.size(), photos.size());
  EXPECT_TRUE(out.points.empty());
  const Vec3d centre = inverse(kPose).translation;
  for (size_t v = 0; v < size_t(kPanoramaViews); ++v) {
    const Rigid pose = out.images[v].cam_from_world();
    EXPECT_LT(length(inverse(pose).translation - centre), 2 * kOff) << v;
    EXPECT_LT(length(pose.rotation.c0 - (panorama_view_rotation(int(v)) * kPose.rotation).c0), 1e-9) << v;
    EXPECT_EQ(out.find_camera(out.images[v].camera_id)->params, (std::vector<double>{60, 60, 60})) << "the exact lens";
  }
  EXPECT_EQ(out.images[10].rotation, model.images[4].rotation) << "photos of no rig keep their pose";
  EXPECT_EQ(out.images[10].translation, model.images[4].translation);
  EXPECT_EQ(out.find_camera(out.images[10].camera_id)->params, model.cameras[1].params);
}

TEST(Rigs, PanoramasWithoutARegisteredViewStayWithoutPose) {
  std::vector<SfmPhoto> photos = panorama_photos();
  for (SfmPhoto& p : photos)
    if (p.name > "a/view_04.png" && p.rig) p.rig->panorama = "aa.png";
  ColmapModel model;
  model.cameras = {{.id = 1, .model_id = 0, .width = 120, .height = 120, .params = {60, 60, 60}}};
  model.images = {image_of(photos[2], 1, {})};
  EXPECT_EQ(with_rig_poses(model, photos).images.size(), 5u);
}

}  // namespace
}  // namespace vitrine
