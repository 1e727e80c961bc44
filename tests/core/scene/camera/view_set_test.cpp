#include "core/scene/camera/view_set.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/intake/photos/photo_list.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/image/ldr.h"
#include "tests/core/scene/camera/tiny_model.h"

namespace vitrine {
namespace {

ColmapModel pinhole_model(bool several_cameras) {
  ColmapModel m = test::tiny_model(3, 6, 20);
  m.cameras = {{1, 1, 640, 480, {500.25, 501, 320.5, 240}}, {2, 1, 800, 600, {700, 701, 400, 300.125}}};
  for (ColmapImage& image : m.images) image.camera_id = several_cameras && image.id % 2 ? 2 : 1;
  return m;
}

// What the sfm stage leaves behind, as far as load_view_set reads it.
void write_sfm_folder(const fs::path& folder, const ColmapModel& model) {
  write_colmap_model(folder / "sparse" / "0", model, ColmapFormat::Binary);
  Gains gains;
  for (const ColmapImage& image : model.images) gains[image.name] = {1, 1 + 0.01 * image.id, 0.5};
  write_gains(folder / "sfm" / "gains.json", gains);
  SceneInfo scene;
  scene.scene_from_colmap = {2.5, rotation_matrix(normalized(Quatd{1, 2, 3, 4})), {0.1, -0.2, 0.3}};
  scene.bounds = {{-1, -2, -3}, {4, 5, 6}};
  write_scene_info(folder / "scene.json", scene);
}

double largest_difference(const Rigid& a, const Rigid& b) {
  double worst = length(a.translation - b.translation);
  for (size_t c = 0; c < 3; ++c) worst = std::max(worst, length(a.rotation.column(c) - b.rotation.column(c)));
  return worst;
}

std::string why_refused(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_FALSE(e.detail().where.empty());
    return e.detail().why;
  }
  return "";
}

TEST(ViewSet, LoadsWhatSfmWrote) {
  TemporaryFolder folder;
  const ColmapModel model = pinhole_model(true);
  write_sfm_folder(folder.path(), model);
  const ViewSet set = load_view_set(folder.path());
  ASSERT_EQ(set.views.size(), model.images.size());
  EXPECT_TRUE(std::is_sorted(set.views.begin(), set.views.end(), [](const View& a, const View& b) { return a.name < b.name; }));
  for (const ColmapImage& image : model.images) {
    const auto view = std::find_if(set.views.begin(), set.views.end(), [&](const View& v) { return v.name == image.name; });
    ASSERT_NE(view, set.views.end());
    EXPECT_LT(largest_difference(view->cam_from_world, image.cam_from_world()), 1e-15);
    EXPECT_DOUBLE_EQ(view->gain.y, 1 + 0.01 * image.id);
    EXPECT_EQ(view->intrinsics.width, image.camera_id == 2 ? 800 : 640);
  }
  ASSERT_EQ(set.points.size(), model.points.size());
  for (size_t k = 0; k < set.points.size(); ++k) {
    EXPECT_EQ(set.points[k].views.size(), model.points[k].track.size());
    for (uint32_t v : set.points[k].views) {
      const std::string& name = set.views.at(v).name;
      EXPECT_TRUE(std::any_of(model.points[k].track.begin(), model.points[k].track.end(),
                              [&](const ColmapTrackElement& e) { return model.find_image(e.image_id)->name == name; }));
    }
  }
  EXPECT_DOUBLE_EQ(set.scene_from_colmap.scale, 2.5);
  EXPECT_EQ(linear_image_path(folder.path(), set.views[1]).extension(), ".exr");
}

TEST(ViewSet, RefusesAFolderThatLacksAPart) {
  for (const char* part : {"sparse/0/images.bin", "sfm/gains.json", "scene.json"}) {
    TemporaryFolder folder;
    write_sfm_folder(folder.path(), pinhole_model(false));
    fs::remove(folder.path() / part);
    EXPECT_NE(why_refused([&] { load_view_set(folder.path()); }), "") << part;
  }
  TemporaryFolder distorted;
  ColmapModel model = pinhole_model(false);
  model.cameras[0] = {1, 2, 640, 480, {500, 320, 240, -0.1}};
  write_sfm_folder(distorted.path(), model);
  EXPECT_NE(why_refused([&] { load_view_set(distorted.path()); }).find("distortion"), std::string::npos);
}

TEST(TransformsJson, DescribesTheCamerasOfSparse0) {
  for (bool several_cameras : {false, true}) {
    TemporaryFolder folder;
    write_sfm_folder(folder.path(), pinhole_model(several_cameras));
    const ViewSet set = load_view_set(folder.path());
    write_transforms_json(folder.path() / "transforms.json", set.views, "images");
    const std::vector<View> views = read_transforms_json(folder.path() / "transforms.json");
    ASSERT_EQ(views.size(), set.views.size());
    for (size_t i = 0; i < views.size(); ++i) {
      EXPECT_EQ(views[i].name, set.views[i].name);
      EXPECT_EQ(views[i].intrinsics, set.views[i].intrinsics);
      EXPECT_LT(largest_difference(views[i].cam_from_world, set.views[i].cam_from_world), 1e-6 /* worst seen 3e-15 */);
    }
  }
}

TEST(TransformsJson, UsesOpenGlAxes) {
  TemporaryFolder folder;
  // A camera at (0, 0, 5) that looks down -z with +y up, the OpenGL identity, sees the origin in its middle and +y above.
  write_file(folder.path() / "t.json", R"({"fl_x": 100, "w": 40, "h": 20,
    "frames": [{"file_path": "a.png", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]]}]})");
  const View view = read_transforms_json(folder.path() / "t.json").at(0);
  EXPECT_NEAR(length(view.cam_from_world * Vec3d{0, 0, 0} - Vec3d{0, 0, 5}), 0, 1e-12);
  EXPECT_NEAR(length(view.cam_from_world * Vec3d{0, 1, 0} - Vec3d{0, -1, 5}), 0, 1e-12);
  EXPECT_EQ(view.intrinsics, (Intrinsics{40, 20, 100, 100, 20, 10}));
}

TEST(TransformsJson, ReadsBlenderSetsWithoutExtensionsAndSizes) {
  TemporaryFolder folder;
  write_file(folder.path() / "transforms_train.json", R"({"camera_angle_x": 0.6911112070083618,
    "frames": [{"file_path": "./train/r_0", "rotation": 0.01, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]}]})");
  const fs::path path = folder.path() / "transforms_train.json";
  const View view = read_transforms_json(path, [](const std::string&) { return PictureSize{32, 24}; }).at(0);
  EXPECT_EQ(view.name, "r_0");
  EXPECT_EQ(view.intrinsics.width, 32);
  EXPECT_NEAR(view.intrinsics.fx, 16 / std::tan(0.5 * 0.6911112070083618), 1e-9);
  EXPECT_DOUBLE_EQ(view.intrinsics.fy, view.intrinsics.fx);
  EXPECT_DOUBLE_EQ(view.intrinsics.cy, 12);
  EXPECT_NE(why_refused([&] { read_transforms_json(path); }).find("w and h are missing"), std::string::npos);
}

TEST(TransformsJson, FrameIntrinsicsWinAndDistortionIsKeptInTheFile) {
  TemporaryFolder folder;
  write_file(folder.path() / "t.json",
             R"({"fl_x": 100, "fl_y": 101, "cx": 21, "cy": 11, "w": 40, "h": 20, "camera_model": "OPENCV", "frames": [
    {"file_path": "images/b.png", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]]},
    {"file_path": "images/sub/a.png", "fl_x": 50, "w": 80, "k1": -0.1, "p2": 0.01, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]]}]})");
  const TransformsFile m = read_transforms_file(folder.path() / "t.json");
  ASSERT_EQ(m.frames.size(), 2u);
  EXPECT_EQ(m.frames[1].name, "images/sub/a.png");
  const ColmapCamera first = m.frames[0].camera.camera({1, 1}), second = m.frames[1].camera.camera({1, 1});
  EXPECT_EQ(first.params, (std::vector<double>{100, 101, 21, 11}));
  EXPECT_EQ(second.params, (std::vector<double>{50, 101, 21, 11, -0.1, 0, 0, 0.01}));
  EXPECT_EQ(second.width, 80u);
  EXPECT_NE(why_refused([&] { read_transforms_json(folder.path() / "t.json"); }).find("distortion"), std::string::npos);
}

TEST(TransformsJson, UndoesTheMoveOfNerfstudio) {
  // nerfstudio stores p_file = applied_scale * (A p): here A swaps x and y and negates z.
  const Rigid original{rotation_matrix(normalized(Quatd{1, 0.2, -0.3, 0.4})), {0.3, -0.7, 2}};
  const Mat3d A{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
  TemporaryFolder folder;
  const Intrinsics k{40, 20, 100, 100, 20, 10};
  const Similarity file_from_original{0.25, A, {}};
  View moved{"a.png", k, transformed_world(original, file_from_original), {1, 1, 1}};
  write_transforms_json(folder.path() / "t.json", {moved}, "images");
  std::string text = read_file(folder.path() / "t.json");
  text.insert(text.find('{') + 1, R"("applied_scale": 0.25, "applied_transform": [[0,1,0,0],[1,0,0,0],[0,0,-1,0]],)");
  write_file(folder.path() / "t.json", text);
  EXPECT_LT(largest_difference(read_transforms_json(folder.path() / "t.json").at(0).cam_from_world, original), 1e-12);
}

TEST(TransformsJson, RefusesWhatItCannotHonour) {
  const auto refused = [](const std::string& top, const std::string& frame) {
    TemporaryFolder folder;
    const std::string path = R"("file_path": "a.png")";
    write_file(folder.path() / "t.json", "{" + top + R"("frames": [{)" + path + frame + "}]}");
    return why_refused([&] { read_transforms_json(folder.path() / "t.json"); });
  };
  const std::string k = R"("fl_x": 100, "w": 40, "h": 20, )";
  const std::string pose = R"(, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]])";
  EXPECT_EQ(refused(k, pose), "");
  EXPECT_NE(refused(k + R"("camera_model": "OPENCV_FISHEYE", )", pose).find("lens distortion"), std::string::npos);
  EXPECT_NE(refused(k + R"("camera_model": "FISHEYE624", )", pose).find("FISHEYE624"), std::string::npos);
  EXPECT_NE(refused(k + R"("is_fisheye": true, "p1": 0.1, )", pose).find("k1 to k4"), std::string::npos);
  EXPECT_NE(refused(k + R"("k3": 0.1, )", pose), "");
  EXPECT_NE(refused(R"("w": 40, "h": 20, )", pose).find("fl_x"), std::string::npos);
  EXPECT_NE(refused(k, "").find("transform_matrix"), std::string::npos);
  EXPECT_NE(refused(k, R"(, "transform_matrix": [[1,0],[0,1]])"), "");
  EXPECT_NE(refused(k, R"(, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,-1,5],[0,0,0,1]])").find("mirrors"), std::string::npos);
  EXPECT_NE(refused(k, R"(, "transform_matrix": [[1,0.5,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]])").find("rotation"),
            std::string::npos);
  EXPECT_NE(refused(k, R"(, "transform_matrix": "none")"), "");
  EXPECT_NE(refused("\"w\": \"wide\", ", pose), "");
  const std::string by_columns = R"(, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0.5,0,5,1]])";
  EXPECT_NE(refused(k, by_columns).find("transposed (stored by columns)"), std::string::npos);
}

TEST(TransformsJson, FisheyeLensesAreThoseOfOpenCv) {
  TemporaryFolder folder;
  const std::string frame =
      R"("frames": [{"file_path": "a.png", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]]}]})";
  const std::string k =
      R"({"fl_x": 100, "fl_y": 101, "w": 40, "h": 20, "cx": 21, "cy": 9, "k1": 0.1, "k2": -0.02, "k3": 0.003, "k4": 1e-4, )";
  for (const std::string named : {R"("camera_model": "OPENCV_FISHEYE", )", R"("is_fisheye": true, )"}) {
    write_file(folder.path() / "t.json", k + named + frame);
    const ColmapCamera camera = read_transforms_file(folder.path() / "t.json").frames.at(0).camera.camera({40, 20});
    EXPECT_EQ(camera.model_id, colmap_camera_type("OPENCV_FISHEYE")->id);
    EXPECT_EQ(camera.params, (std::vector<double>{100, 101, 21, 9, 0.1, -0.02, 0.003, 1e-4}));
  }
}

TEST(TransformsJson, TruncatedAndFlippedFilesAreErrors) {
  TemporaryFolder folder;
  const fs::path path = folder.path() / "t.json";
  write_transforms_json(
      path, {{"a.png", {40, 20, 100, 100, 20, 10}, {}, {1, 1, 1}}, {"b.png", {40, 20, 100, 100, 20, 10}, {}, {1, 1, 1}}},
      "images");
  const std::string whole = read_file(path);
  for (size_t i = 0; i + 2 < whole.size(); i += 7) {
    test::replace_file(path, whole.substr(0, i));
    EXPECT_NE(why_refused([&] { read_transforms_json(path); }), "") << i;
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ 0x15);
    test::replace_file(path, bytes);
    why_refused([&] { read_transforms_json(path); });
  }
}

TEST(TransformsJson, ReadsTheBlenderCapture) {
  const fs::path path = fs::path(VITRINE_SOURCE_DIR) / ".." / "shared" / "data" / "vitrine_blender" / "truth" / "transforms.json";
  if (!fs::exists(path)) GTEST_SKIP() << "the data set ../shared/data/vitrine_blender is not on this machine";
  const std::vector<View> views = read_transforms_json(path);
  EXPECT_EQ(views.size(), 42u);
  EXPECT_EQ(views[0].name, "img_0000.jpg");
  EXPECT_NEAR(views[0].centre_in_world().x, 1.9889923334121704, 1e-6);
}

TEST(SceneInfo, RoundTripsAndGainsMustBePositive) {
  TemporaryFolder folder;
  SceneInfo s;
  s.scene_from_colmap = {0.1 + 0.2, rotation_matrix(normalized(Quatd{1, 2, 3, 4})), {1e-9, -2.0 / 3, 3}};
  s.bounds = {{-1, -2, -3}, {4, 5, 6}};
  s.scale_known = true;
  write_scene_info(folder.path() / "scene.json", s);
  const SceneInfo back = read_scene_info(folder.path() / "scene.json");
  EXPECT_EQ(back.scene_from_colmap.rotation, s.scene_from_colmap.rotation);
  EXPECT_EQ(back.scene_from_colmap.translation, s.scene_from_colmap.translation);
  EXPECT_EQ(back.scene_from_colmap.scale, s.scene_from_colmap.scale);
  EXPECT_EQ(back.bounds.high, s.bounds.high);
  EXPECT_TRUE(back.scale_known);
  const Gains gains{{"a b.jpg", {1.5, 1, 1.0 / 3}}, {"\xc3\xa4.png", {1, 1, 1}}};
  write_gains(folder.path() / "gains.json", gains);
  EXPECT_EQ(read_gains(folder.path() / "gains.json"), gains);
  write_file(folder.path() / "gains.json", R"({"a.jpg": [1, 0, 1]})");
  EXPECT_NE(why_refused([&] { read_gains(folder.path() / "gains.json"); }).find("positive"), std::string::npos);
}

TEST(SceneInfo, HasThePlaceOnlyWhereItIsKnown) {
  TemporaryFolder folder;
  const fs::path path = folder.path() / "scene.json";
  SceneInfo s;
  s.scene_from_colmap.scale = 0.25;
  write_scene_info(path, s);
  EXPECT_EQ(read_file(path).find("enu_origin"), std::string::npos);
  EXPECT_FALSE(read_scene_info(path).metres_per_unit());
  s.scale_known = true;
  EXPECT_EQ(s.metres_per_unit(), 4) << "without a place the frame of the poses is in metres";
  s.geo = GeoOrigin{.latitude = -33.8567844, .longitude = 151.2152967, .altitude = 4.5, .metres_per_unit = 31.25};
  write_scene_info(path, s);
  const SceneInfo back = read_scene_info(path);
  ASSERT_TRUE(back.geo);
  EXPECT_EQ(back.geo->latitude, s.geo->latitude);
  EXPECT_EQ(back.geo->longitude, s.geo->longitude);
  EXPECT_EQ(back.geo->altitude, 4.5);
  EXPECT_EQ(back.metres_per_unit(), 31.25);
  std::string bad = read_file(path);
  bad.replace(bad.find("31.25"), 5, "-1.00");
  write_file(path, bad);
  EXPECT_NE(why_refused([&] { read_scene_info(path); }).find("enu_origin"), std::string::npos);
}

TEST(PhotoList, RoundTripsIncludingWhatIsUnknown) {
  TemporaryFolder folder;
  std::vector<Photo> photos = {{"a.jpg", "a", "a.jpg", 100, 50, 400, 200, 6, 612.5, "exif FocalLengthIn35mmFilm", 11.25,
                                "Maker Model", "2024:01:02 03:04:05", "Display P3", "icc"},
                               {"sub/\xc3\xa4 b_png.png",
                                "sub/\xc3\xa4 b_png",
                                "sub/\xc3\xa4 b.png",
                                10,
                                20,
                                10,
                                20,
                                1,
                                {},
                                "",
                                {},
                                "",
                                "",
                                "sRGB",
                                "assumed sRGB"}};
  photos[0].flash = true;
  photos[1].cut_out = true;
  photos[0].zoom = 35.5;
  write_photo_list(folder.path(), photos);
  EXPECT_EQ(read_photo_list(folder.path()), photos);
  write_file(folder.path() / "ingest" / "photos.json", R"({"photos": [{"name": "a.jpg"}]})");
  EXPECT_NE(why_refused([&] { read_photo_list(folder.path()); }), "");
}

}  // namespace
}  // namespace vitrine
