// Photos whose zoom EXIF tells have cameras of their own.
#include "stages/sfm/zoom_groups.h"

#include <gtest/gtest.h>

namespace vitrine {
namespace {

std::vector<SfmPhoto> parted(const std::vector<std::optional<double>>& zooms, std::optional<double> focal_px) {
  std::vector<SfmPhoto> list;
  std::vector<Photo> photos;
  for (const auto& zoom : zooms) {
    list.push_back({.name = "a.jpg", .picture = {}, .width = 160, .height = 120, .focal_px = focal_px, .camera = "Maker Model"});
    photos.emplace_back().zoom = zoom;
  }
  part_by_zoom(list, photos);
  return list;
}

TEST(ZoomGroups, HaveCamerasOfTheirOwn) {
  const std::vector<SfmPhoto> list = parted({48, 24, 24.2, 48.5, std::nullopt}, std::nullopt);
  EXPECT_EQ(list[0].camera, list[3].camera);
  EXPECT_EQ(list[1].camera, list[2].camera) << "focus changes it a little";
  EXPECT_NE(list[0].camera, list[1].camera);
  EXPECT_EQ(list[4].camera, "Maker Model");
  for (const SfmPhoto& p : list) EXPECT_FALSE(p.focal_px);
}

TEST(ZoomGroups, OnePriorOfAllIsOfTheWidest) {
  const std::vector<SfmPhoto> list = parted({5.0, 10.0}, 380);
  EXPECT_DOUBLE_EQ(list[0].focal_px.value(), 380);
  EXPECT_DOUBLE_EQ(list[1].focal_px.value(), 760);
  EXPECT_NE(list[0].camera, list[1].camera);
}

TEST(ZoomGroups, OneZoomIsOneCamera) {
  for (const SfmPhoto& p : parted({24, 24, 24.5}, 380)) {
    EXPECT_EQ(p.camera, "Maker Model");
    EXPECT_EQ(p.focal_px, 380);
  }
}

}  // namespace
}  // namespace vitrine
