// Lens models whose further parameters are zero are read as the simplest model with the same pixels; FULL_OPENCV projects.
#include "core/scene/camera/colmap_lens.h"

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"

namespace vitrine {
namespace {

ColmapCamera camera(std::string_view model, std::vector<double> params) {
  return {3, colmap_camera_type(model)->id, 640, 480, std::move(params)};
}

std::string_view simplest(std::string_view model, std::vector<double> params) {
  const ColmapCamera c = simplest_camera(camera(model, std::move(params)));
  EXPECT_EQ(c.params.size(), colmap_camera_type(c.model_id)->parameter_count) << model;
  return colmap_camera_type(c.model_id)->name;
}

TEST(SimplestCamera, DropsParametersThatAreZero) {
  EXPECT_EQ(simplest("FULL_OPENCV", {600, 590, 330, 225, 0, 0, 0, 0, 0, 0, 0, 0}), "PINHOLE");
  EXPECT_EQ(simplest("FULL_OPENCV", {600, 590, 330, 225, -0.1, 0, 0, 1e-12, 0, 0, -1e-14, 0}), "OPENCV");
  EXPECT_EQ(simplest("FULL_OPENCV", {600, 590, 330, 225, -0.1, 0, 0, 0, 0, 0, 0, 1e-4}), "FULL_OPENCV");
  EXPECT_EQ(simplest("OPENCV", {600, 590, 330, 225, 0, 0, 0, 0}), "PINHOLE");
  EXPECT_EQ(simplest("RADIAL", {600, 330, 225, 0, 0}), "SIMPLE_PINHOLE");
  EXPECT_EQ(simplest("RADIAL", {600, 330, 225, 0.1, 0}), "SIMPLE_RADIAL");
  EXPECT_EQ(simplest("RADIAL", {600, 330, 225, 0, 0.1}), "RADIAL");
  EXPECT_EQ(simplest("FOV", {600, 590, 330, 225, 0}), "PINHOLE");
  EXPECT_EQ(simplest("SIMPLE_DIVISION", {600, 330, 225, 0}), "SIMPLE_PINHOLE");
  EXPECT_EQ(simplest("DIVISION", {600, 590, 330, 225, 0}), "PINHOLE");
  EXPECT_EQ(simplest("EUCM", {600, 590, 330, 225, 0, 1.3}), "PINHOLE");
  EXPECT_EQ(simplest("EUCM", {600, 590, 330, 225, 0.5, 1.3}), "EUCM");
}

TEST(SimplestCamera, KeepsFisheyeLensesWithoutDistortion) {
  EXPECT_EQ(simplest("OPENCV_FISHEYE", {600, 590, 330, 225, 0, 0, 0, 0}), "OPENCV_FISHEYE");
  EXPECT_EQ(simplest("SIMPLE_RADIAL_FISHEYE", {600, 330, 225, 0}), "SIMPLE_RADIAL_FISHEYE");
  EXPECT_EQ(simplest("THIN_PRISM_FISHEYE", {600, 590, 330, 225, 0, 0, 0, 0, 0, 0, 0, 0}), "THIN_PRISM_FISHEYE");
}

TEST(SimplestCamera, MovesNoPixel) {
  const ColmapCamera full = camera("FULL_OPENCV", {600, 590, 330, 225, -0.08, 0.02, 0.004, -0.007, 0, 0, 0, 0});
  const ColmapCamera less = simplest_camera(full);
  EXPECT_EQ(less.id, full.id);
  EXPECT_EQ(colmap_camera_type(less.model_id)->name, "OPENCV");
  for (const Vec2d d : {Vec2d{0.5, -0.3}, Vec2d{-0.4, 0.35}, Vec2d{0, 0}}) {
    EXPECT_NEAR(project(full, d).x, project(less, d).x, 1e-10);
    EXPECT_NEAR(project(full, d).y, project(less, d).y, 1e-10);
  }
}

// The formula of OpenCV's documentation (Camera Calibration and 3D Reconstruction), evaluated by hand for u = 0.5, v = -0.25.
TEST(FullOpenCv, IsOpenCvsRationalModelAndIsInverted) {
  const ColmapCamera full = camera("FULL_OPENCV", {600, 590, 330, 225, -0.2, 0.05, 0.003, -0.002, 0.03, 0.1, -0.02, 0.01});
  const double u = 0.5, v = -0.25, r2 = 0.3125;
  const double radial =
      (1 - 0.2 * r2 + 0.05 * r2 * r2 + 0.03 * r2 * r2 * r2) / (1 + 0.1 * r2 - 0.02 * r2 * r2 + 0.01 * r2 * r2 * r2);
  const Vec2d seen = project(full, {u, v});
  EXPECT_NEAR(seen.x, 600 * (u * radial + 2 * 0.003 * u * v - 0.002 * (r2 + 2 * u * u)) + 330, 1e-9);
  EXPECT_NEAR(seen.y, 590 * (v * radial - 2 * 0.002 * u * v + 0.003 * (r2 + 2 * v * v)) + 225, 1e-9);
  for (const Vec2d d : {Vec2d{0.5, -0.25}, Vec2d{-0.5, 0.4}, Vec2d{0.01, 0.3}}) {
    const auto back = unproject(full, project(full, d));
    ASSERT_TRUE(back);
    EXPECT_NEAR(back->x, d.x, 1e-10);
    EXPECT_NEAR(back->y, d.y, 1e-10);
  }
  EXPECT_TRUE(is_distorted(full));
  // Its pole lies inside the picture: no direction belongs to pixels beyond it.
  EXPECT_FALSE(unproject(camera("FULL_OPENCV", {600, 590, 330, 225, 0, 0, 0, 0, 0, -9, 0, 0}), {330, 1e6}));
}

TEST(FisheyeModels, AreThoseWithTheWordAndFov) {
  EXPECT_TRUE(is_fisheye(5) && is_fisheye(7) && is_fisheye(8) && is_fisheye(10));
  EXPECT_FALSE(is_fisheye(1) || is_fisheye(4) || is_fisheye(6) || is_fisheye(-1));
}

}  // namespace
}  // namespace vitrine
