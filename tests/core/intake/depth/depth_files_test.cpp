// Depth maps under the names and in the units of other programs.
#include "core/intake/depth/depth_files.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "tests/support/error_of.h"
#include "tests/support/tiff_file.h"

namespace vitrine {
namespace {

class DepthFiles : public ::testing::Test {
 protected:
  fs::path at(const std::string& name) const { return folder.path() / name; }
  // Millimetres: 1000 plus the column; the pixel (0, 0) is 0, (1, 0) the largest value.
  fs::path png(const std::string& name, int offset = 0) const {
    Image16 image(8, 6, 1);
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 8; ++x) image.at(x, y) = uint16_t(1000 + x + offset);
    image.at(0, 0) = 0, image.at(1, 0) = 65535;
    make_folders(at(name).parent_path());
    write_png16(at(name), image);
    return at(name);
  }
  fs::path exr(const std::string& name, const std::vector<std::string>& channels, const std::vector<float>& values) const {
    ImageF image(int(values.size() / channels.size()), 1, int(channels.size()));
    std::copy(values.begin(), values.end(), image.data().begin());
    make_folders(at(name).parent_path());
    write_exr(at(name), {.pixels = image, .channels = channels, .attributes = {}}, ExrPrecision::Float);
    return at(name);
  }
  std::string refusal(const fs::path& file) const {
    const Error e = error_of([&] { read_depth(file); });
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_EQ(e.detail().code, "NOT_A_DEPTH_MAP") << e.what();
    EXPECT_EQ(e.detail().where, file.string());
    return e.detail().why;
  }
  TemporaryFolder folder;
};

TEST_F(DepthFiles, IntegersAreMillimetresOrOfTheStatedUnit) {
  const ImageF depth = read_depth(png("a.png"));
  EXPECT_EQ(depth.at(0, 0), 0);
  EXPECT_EQ(depth.at(1, 0), 0);  // the largest value: saturated
  EXPECT_NEAR(depth.at(5, 2), 1.005, 1e-6);
  EXPECT_NEAR(read_depth(at("a.png"), 0.0002).at(5, 2), 0.201, 1e-6);
}

TEST_F(DepthFiles, FloatsAreMetresAndWhatIsNoDepthIsUnknown) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const ImageF depth = read_depth(exr("a.exr", {"Z"}, {1.5f, nan, inf, -inf, 0, -2, 1e10f, 65504, 3}));
  EXPECT_EQ(std::vector<float>(depth.data().begin(), depth.data().end()), (std::vector<float>{1.5f, 0, 0, 0, 0, 0, 0, 0, 3}));
  EXPECT_EQ(read_depth(exr("b.exr", {"ViewLayer.Depth.Z"}, {1, 2})).at(1, 0), 2);
  EXPECT_EQ(read_depth(exr("c.exr", {"R", "G", "B"}, {1, 1, 1, 2, 2, 2})).at(1, 0), 2);
  const test::TiffDesc tiff{
      .name = "float", .bits = 32, .samples = 1, .format = SAMPLEFORMAT_IEEEFP, .photometric = PHOTOMETRIC_MINISBLACK};
  test::write_tiff(at("d.tif"), tiff, 16, 9);
  EXPECT_NEAR(read_depth(at("d.tif")).at(3, 4), test::tiff_sample(3, 4, 0) / 255., 1e-6);
}

TEST_F(DepthFiles, WhatIsNoDepthMapIsRefused) {
  EXPECT_NE(refusal(exr("rgb.exr", {"R", "G", "B"}, {1, 2, 3, 4, 5, 6})).find("channels differ"), std::string::npos);
  EXPECT_NE(refusal(exr("xyz.exr", {"X", "Y", "Z"}, {0, 0, 1, 0, 1, 0})).find("no channel is called Z"), std::string::npos);
  EXPECT_NE(refusal(exr("same.exr", {"Z"}, {2, 2, 0, 2})).find("one depth"), std::string::npos);
  EXPECT_NE(refusal(exr("back.exr", {"Z"}, {-2, -3, 0, -4})).find("negative"), std::string::npos);
  Image8 grey(8, 6, 1), colours(8, 6, 3);
  for (size_t i = 0; i < grey.data().size(); ++i) grey.data()[i] = uint8_t(5 * i);
  write_ldr(at("grey.png"), grey);
  EXPECT_NE(refusal(at("grey.png")).find("8 bits"), std::string::npos);
  write_ldr(at("colours.png"), colours);
  EXPECT_NE(refusal(at("colours.png")).find("8 bits"), std::string::npos);
  write_ldr(at("photo.jpg"), grey);
  EXPECT_NE(refusal(at("photo.jpg")).find("neither"), std::string::npos);
  Image16 painted(8, 6, 3);
  for (size_t i = 0; i < painted.data().size(); ++i) painted.data()[i] = uint16_t(900 * i);
  write_png16(at("painted.png"), painted);
  EXPECT_NE(refusal(at("painted.png")).find("channels differ"), std::string::npos);
}

struct NameCase {
  const char *photo, *file;
};

TEST_F(DepthFiles, AreFoundUnderTheNamesOfOtherPrograms) {
  const NameCase cases[] = {{"b.jpg", "b.png"},
                            {"b.jpg", "depth/b.png"},
                            {"images/b.jpg", "depths/b.png"},
                            {"left/b.jpg", "depth/left/b.png"},
                            {"b.jpg", "b_depth.png"},
                            {"b.jpg", "depth_b.png"},
                            {"b.jpg", "b.jpg.png"},
                            {"Image0007.jpg", "Depth0007.png"},
                            {"frame_7.color.jpg", "frame_7.depth.png"},
                            {"IMG_12.JPG", "img_12.PNG"}};
  for (const NameCase& c : cases) {
    const TemporaryFolder maps;
    make_folders((maps.path() / c.file).parent_path());
    fs::copy_file(png("source.png"), maps.path() / c.file);
    fs::copy_file(at("source.png"), maps.path() / "other_99.png");
    const DepthFolder found(maps.path());
    EXPECT_EQ(found.file_count(), 2u);
    EXPECT_EQ(found.match(std::vector<std::string>{c.photo})[0], maps.path() / c.file) << c.photo << " " << c.file;
  }
}

TEST_F(DepthFiles, ThePreciseFileIsTakenAndTwoOfAKindAreRefused) {
  png("depth/b.png");
  const fs::path precise = exr("depth/b.exr", {"Z"}, {1, 2});
  EXPECT_EQ(DepthFolder(at("depth")).match(std::vector<std::string>{"b.jpg"})[0], precise);
  exr("depth/day/b.exr", {"Z"}, {1, 2});
  exr("depth/night/b.exr", {"Z"}, {1, 2});
  fs::remove(precise), fs::remove(at("depth/b.png"));
  EXPECT_EQ(DepthFolder(at("depth")).match(std::vector<std::string>{"night/b.jpg"})[0], at("depth/night/b.exr"));
  const Error e = error_of([&] { (void)DepthFolder(at("depth")).match(std::vector<std::string>{"b.jpg"}); });
  EXPECT_EQ(e.detail().code, "DEPTH_AMBIGUOUS");
}

TEST_F(DepthFiles, FoldersWithoutMapsAndOfOtherPhotosAreRefused) {
  make_folders(at("empty"));
  write_file(at("empty/a.npy"), "array");
  const Error arrays = error_of([&] { DepthFolder{at("empty")}; });
  EXPECT_EQ(arrays.detail().code, "DEPTH_MISSING");
  EXPECT_NE(arrays.detail().why.find("arrays"), std::string::npos);
  EXPECT_EQ(error_of([&] { DepthFolder{at("none")}; }).detail().code, "DEPTH_MISSING");
  png("maps/x.png");
  EXPECT_EQ(error_of([&] { (void)DepthFolder(at("maps")).match(std::vector<std::string>{"b.jpg"}); }).detail().code,
            "DEPTH_MATCHES_NO_PHOTO");
  EXPECT_EQ(check_depth_names(at("maps"), {"x.jpg", "y.jpg"}), (std::vector<std::string>{"1 of 2 photos have no depth map"}));
  write_ldr(at("maps/x.png"), Image8(4, 4, 1));
  EXPECT_EQ(error_of([&] { check_depth_names(at("maps"), {"x.jpg"}); }).detail().code, "NOT_A_DEPTH_MAP");
}

TEST_F(DepthFiles, ATransformsJsonNamesThem) {
  png("raw/17.png"), png("raw/18.png");
  write_file(at("transforms.json"),
             R"({"depth_unit_scale_factor": 0.01, "frames": [
  {"file_path": "images/a.jpg", "depth_file_path": "raw/17.png", "transform_matrix": []},
  {"file_path": "images/b.jpg", "depth_file_path": "/home/me/set/raw/18.png", "transform_matrix": []},
  {"file_path": "images/c.jpg", "transform_matrix": []}]})");
  for (const fs::path& given : {at("transforms.json"), folder.path()}) {
    const DepthFolder found(given);
    EXPECT_EQ(found.unit(), 0.01);
    const auto files = found.match(std::vector<std::string>{"b.jpg", "c.jpg", "a.jpg"});
    EXPECT_EQ(files[0], at("raw/18.png"));
    EXPECT_EQ(files[1], std::nullopt);
    EXPECT_EQ(files[2], at("raw/17.png"));
  }
  EXPECT_EQ(files_of_depth_list(at("transforms.json")), (std::vector<fs::path>{at("raw/17.png"), at("raw/18.png")}));
  EXPECT_TRUE(files_of_depth_list(folder.path()).empty());
  write_file(at("transforms.json"), R"({"frames": [{"file_path": "a.jpg", "depth_path": "gone.png"}]})");
  EXPECT_NE(error_of([&] { DepthFolder{at("transforms.json")}; }).detail().why.find("gone.png"), std::string::npos);
  write_file(at("transforms.json"), R"({"integer_depth_scale": -1, "frames": []})");
  EXPECT_NE(error_of([&] { DepthFolder{at("transforms.json")}; }).detail().why.find("positive"), std::string::npos);
}

TEST_F(DepthFiles, ShapesAreThoseOfThePhotosWithinAPercent) {
  EXPECT_TRUE(same_depth_shape(640, 480, 1296, 968));
  EXPECT_FALSE(same_depth_shape(480, 640, 1296, 968));
  EXPECT_FALSE(same_depth_shape(640, 480, 1600, 900));
  const Error turned = error_of([&] { throw_wrong_depth_size("a.png", ImageF(480, 640, 1), 1296, 968); });
  EXPECT_EQ(turned.detail().code, "DEPTH_SIZE");
  EXPECT_NE(turned.detail().why.find("EXIF"), std::string::npos);
}

}  // namespace
}  // namespace vitrine
