#include "core/scene/camera/transforms_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

class CameraPath : public testing::Test {
 protected:
  fs::path file(const std::string& text) const {
    write_file(folder.path() / "path.json", text);
    return folder.path() / "path.json";
  }
  // A camera at (x, 0, 0).
  static std::string frame(const std::string& name, int x) {
    return "{\"file_path\": \"" + name + "\", \"transform_matrix\": [[1,0,0," + std::to_string(x) +
           "],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}";
  }
  static std::vector<double> places(const std::vector<View>& views) {
    std::vector<double> out;
    for (const View& v : views) out.push_back(v.centre_in_world().x);
    return out;
  }
  TemporaryFolder folder;
};

TEST_F(CameraPath, KeepsTheOrderOfItsFile) {
  const auto views =
      read_camera_path({.file = file(R"({"fl_x": 30, "w": 40, "h": 30, "frames": [)" + frame("1.png", 1) + "," +
                                     frame("2.png", 2) + "," + frame("10.png", 3) + "," + frame("1.png", 4) + "]}"),
                        .size = {},
                        .usual_size = {}});
  EXPECT_EQ(places(views), (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(views[3].name, "frame_0003.png");
}

TEST_F(CameraPath, OfManyFramesSortsAsItRuns) {
  std::string text = R"({"fl_x": 30, "w": 40, "h": 30, "frames": [)";
  for (int i = 0; i < 10001; ++i) text += (i == 0 ? "" : ",") + frame("x", i);
  const auto views = read_camera_path({.file = file(text + "]}"), .size = {}, .usual_size = {}});
  EXPECT_EQ(views.front().name, "frame_00000.png");
  EXPECT_TRUE(std::is_sorted(views.begin(), views.end(), [](const View& a, const View& b) { return a.name < b.name; }));
}

TEST_F(CameraPath, WithoutSizeTakesTheUsualOneForAnglesAndAsksForPixels) {
  const auto usual = [] { return PictureSize{64, 48}; };
  const fs::path by_angle = file(R"({"camera_angle_x": 1.0, "frames": [)" + frame("a", 0) + "]}");
  const Intrinsics k = read_camera_path({.file = by_angle, .size = {}, .usual_size = usual})[0].intrinsics;
  EXPECT_EQ(k.width, 64);
  EXPECT_NEAR(k.fx, 32 / std::tan(0.5), 1e-12);
  EXPECT_EQ(read_camera_path({.file = by_angle, .size = PictureSize{20, 10}, .usual_size = usual})[0].intrinsics.width, 20);
  const fs::path by_pixels = file(R"({"fl_x": 30, "frames": [)" + frame("a", 0) + "]}");
  const Error e = error_of([&] { read_camera_path({.file = by_pixels, .size = {}, .usual_size = usual}); });
  EXPECT_NE(e.detail().why.find("w and h are missing"), std::string::npos);
  EXPECT_EQ(read_camera_path({.file = by_pixels, .size = PictureSize{20, 10}, .usual_size = usual})[0].intrinsics.fx, 30);
}

TEST_F(CameraPath, OfNerfstudiosViewerIsRead) {
  const std::string cameras =
      R"([{"camera_to_world": [1,0,0,3, 0,1,0,0, 0,0,1,0, 0,0,0,1], "fov": 90, "aspect": 2},
          {"camera_to_world": [[1,0,0,1],[0,1,0,0],[0,0,1,0],[0,0,0,1]], "fov": 60}])";
  const auto views = read_camera_path(
      {.file =
           file(R"({"camera_type": "perspective", "render_height": 100, "render_width": 200, "camera_path": )" + cameras + "}"),
       .size = {},
       .usual_size = {}});
  EXPECT_EQ(places(views), (std::vector<double>{3, 1}));
  EXPECT_NEAR(views[0].intrinsics.fy, 50, 1e-9);  // fov is that of the height
  EXPECT_NEAR(views[0].intrinsics.fx, 50, 1e-9);
  EXPECT_EQ(views[0].intrinsics.width, 200);
  const Error e = error_of([&] {
    read_camera_path(
        {.file = file(R"({"camera_type": "equirectangular", "camera_path": )" + cameras + "}"), .size = {}, .usual_size = {}});
  });
  EXPECT_NE(e.detail().why.find("equirectangular"), std::string::npos) << e.what();
}

}  // namespace
}  // namespace vitrine
