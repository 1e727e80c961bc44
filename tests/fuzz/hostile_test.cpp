// What fuzzing and reading the parsers found: what would crash, take memory without end, or leave the project's folder.
#include <gtest/gtest.h>

#include "core/foundation/config/yaml.h"
#include "core/intake/masks/mask_files.h"
#include "core/intake/photos/photo_list.h"
#include "core/intake/poses/given_poses.h"
#include "core/learn/loss/feature_network.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/light/environment.h"
#include "tests/fuzz/entry.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

class Hostile : public testing::Test {
 protected:
  fs::path file(const std::string& name, const std::string& bytes) const {
    write_file(folder.path() / name, bytes);
    return folder.path() / name;
  }
  static std::vector<Photo> photos() {
    std::vector<Photo> two(2);
    for (size_t i = 0; i < 2; ++i) {
      two[i].name = two[i].source = fmt::format("{}.png", i), two[i].stem = fmt::format("{}", i);
      two[i].width = two[i].original_width = 40, two[i].height = two[i].original_height = 30;
    }
    return two;
  }
  TemporaryFolder folder{"vitrine-hostile"};
};

constexpr const char* kPose = R"("transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,2],[0,0,0,1]])";

TEST_F(Hostile, DeeplyNestedListsAreRefusedWithoutPrintingThem) {
  const std::string deep = std::string(1 << 20, '[') + std::string(1 << 20, ']');
  const Error e = error_of([&] { read_gains(file("gains.json", "{\"a.png\": " + deep + "}")); });
  EXPECT_EQ(e.kind(), ErrorKind::Input);
  EXPECT_NE(e.detail().why.find("expected a list of three numbers, found array"), std::string::npos) << e.what();
}

TEST_F(Hostile, AThousandMistakesOnOneLongLineStayReadable) {
  YamlFile yaml = parse_yaml("{" + std::string(100'000, ' ') + "a: 1}", "x.yaml");
  ConfigErrors errors;
  for (int i = 0; i < 1000; ++i) errors.add(yaml, {1, 100'002}, 100'000, std::string(50'000, 'm'));
  const Error e = error_of([&] { errors.throw_if_any(""); });
  EXPECT_LT(std::string(e.what()).size(), 400'000u);
  EXPECT_NE(std::string(e.what()).find("1000 errors, the first 100 are shown"), std::string::npos);
  EXPECT_NE(std::string(e.what()).find("a: 1}\n"), std::string::npos);
}

TEST_F(Hostile, ALensWithTwoParametersIsRefusedBeforeItIsScaled) {
  ColmapModel model;
  model.cameras.push_back({1, 17, 80, 60, {80, 60}});  // EQUIRECTANGULAR
  for (uint32_t i = 0; i < 2; ++i) model.images.push_back({i + 1, {}, {}, 1, fmt::format("{}.png", i), {}});
  make_folders(folder.path() / "model");
  write_colmap_model(folder.path() / "model", model, ColmapFormat::Binary);
  EXPECT_EQ(error_of([&] { read_given_poses(folder.path() / "model", photos(), 0); }).detail().code, "CAMERA_MODEL_PANORAMA");
}

// Names of photos are only compared with those of the capture: what is written afterwards is called like a photo.
TEST_F(Hostile, ColmapNamesStayInside) {
  for (const char* name : {"../0.png", "/etc/0.png", "a/../../0.png"}) {
    ColmapModel model;
    model.cameras.push_back(colmap_pinhole(1, {40, 30, 30, 30, 20, 15}));
    for (uint32_t i = 0; i < 2; ++i) model.images.push_back({i + 1, {}, {}, 1, i == 0 ? name : "1.png", {}});
    make_folders(folder.path() / "model");
    write_colmap_model(folder.path() / "model", model, ColmapFormat::Text);
    EXPECT_EQ(error_of([&] { read_colmap_model(folder.path() / "model"); }).detail().code, "COLMAP_MODEL_DAMAGED") << name;
    EXPECT_EQ(read_given_poses(folder.path() / "model", photos(), 0).images.at(0).name, "0.png") << name;
  }
}

TEST_F(Hostile, TransformsOpenNoFile) {
  // Reading the pictures that it names would never end.
  const fs::path path = file("transforms.json", fmt::format(R"({{"fl_x": 30, "frames": [{{"file_path": "/dev/zero/0.png", {0}}},
                                                              {{"file_path": "../1.png", {0}}}]}})",
                                                            kPose));
  EXPECT_EQ(read_given_poses(path, photos(), 0).images.size(), 2u);
}

TEST_F(Hostile, MaskPathsStayInside) {
  write_ldr(folder.path() / "outside/0.png", Image8(40, 30, 1));
  write_ldr(folder.path() / "project/m.png", Image8(40, 30, 1));
  fs::create_directory_symlink("../outside", folder.path() / "project/link");
  const auto mask = [&](const std::string& path) {
    const MaskFolder masks(
        file("project/transforms.json", fmt::format(R"({{"frames": [{{"file_path": "0.png", "mask_path": "{}"}}]}})", path)));
    return masks.find(MaskClass::Object, "0.png").has_value();
  };
  EXPECT_TRUE(mask("m.png"));
  for (const std::string& name :
       {std::string("../outside/0.png"), (folder.path() / "outside/0.png").string(), std::string("link/0.png")})
    EXPECT_EQ(error_of([&] { mask(name); }).detail().code, "BAD_JSON") << name;
  file("meshroom/scene.sfm", R"({"views": [{"viewId": "../outside/0", "path": "0.png"}]})");
  EXPECT_EQ(error_of([&] { MaskFolder{folder.path() / "meshroom"}; }).detail().code, "BAD_JSON");
}

TEST_F(Hostile, LinksInACircleEnd) {
  write_ldr(folder.path() / "masks/0.png", Image8(40, 30, 1));
  fs::create_directory_symlink(".", folder.path() / "masks/again");
  const auto found = MaskFolder{folder.path() / "masks"}.find(MaskClass::Object, "0.png");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->path, folder.path() / "masks/0.png");
}

TEST_F(Hostile, PhotoListsNameNoFileElsewhere) {
  std::vector<Photo> list = photos();
  for (const char* stem : {"../../x", "/x"}) {
    list[0].stem = stem;
    write_photo_list(folder.path(), list);
    EXPECT_EQ(error_of([&] { read_photo_list(folder.path()); }).detail().code, "BAD_JSON") << stem;
  }
}

// Headers that announce more than their file can hold are refused before anything is allocated.
TEST_F(Hostile, PicturesThatCannotBeSoLarge) {
  std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x40\0\0\0\x40\0\b\2\0\0\0\0\0\0\0", 33);  // 16384 x 16384
  EXPECT_NE(std::string(error_of([&] { read_unchanged(file("a.png", png)); }).what()).find("cannot hold"), std::string::npos);
  const std::string hdr = "#?RADIANCE\n\n-Y 16384 +X 16384\n" + std::string(65536, '\0');
  EXPECT_NE(std::string(error_of([&] { parse_radiance_hdr(hdr, "a.hdr"); }).what()).find("cannot hold"), std::string::npos);
  const fs::path exr = folder.path() / "a.exr";
  write_exr_rgb(exr, ImageF(20, 13, 3));
  const std::string bytes = read_file(exr);
  std::string large = bytes;
  for (const char* window : {"dataWindow", "displayWindow"}) {
    const size_t at = large.find(window) + std::string(window).size() + 1 + 6 + 4 + 8;
    large.replace(at, 8, std::string("\xff\x3f\0\0\xff\x3f\0\0", 8));
  }
  EXPECT_EQ(error_of([&] { read_exr(file("b.exr", large)); }).detail().code, "BAD_EXR");
  // Sizes of attributes: one that is no longer in the file, and a list of channels that ends before its size says.
  std::string attribute = bytes;
  attribute.replace(attribute.find("chlist") + 7, 4, std::string("\xff\xff\xff\x7f", 4));
  EXPECT_NE(std::string(error_of([&] { read_exr(file("c.exr", attribute)); }).what()).find("header is damaged"),
            std::string::npos);
  std::string channels = bytes;
  channels[channels.find("chlist") + 7 + 4] = '\0';
  EXPECT_NE(std::string(error_of([&] { read_exr(file("d.exr", channels)); }).what()).find("header is damaged"),
            std::string::npos);
}

TEST_F(Hostile, TensorsThatShareTheirBytesAreRefused) {
  std::string header = "{";
  for (int i = 0; i < 4; ++i)
    header += fmt::format(R"({}"features.{}.weight":{{"dtype":"F32","shape":[2],"data_offsets":[0,8]}})", i == 0 ? "" : ",", i);
  header += "}";
  const std::string length =
      std::string(1, char(header.size())) + std::string(1, char(header.size() >> 8)) + std::string(6, '\0');
  const fs::path path = file("w.safetensors", length + header + std::string(8, '\0'));
  EXPECT_NE(std::string(error_of([&] { read_safetensors(path, "features."); }).what()).find("overlap"), std::string::npos);
}

}  // namespace
}  // namespace vitrine
