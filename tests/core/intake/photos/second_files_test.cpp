// Further files of the same views in a folder of photos: maps of scanners and renderers, cut-outs of background removers. And
// files given where a folder belongs.
#include <cmath>

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/rng.h"
#include "core/intake/photos/photo_files.h"
#include "core/intake/photos/picture_roles.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "tests/support/error_of.h"
#include "tests/support/rgba_png.h"
#include "tests/support/tiny_photos.h"

namespace vitrine {
namespace {

constexpr int kWide = 160, kHigh = 120;

// Coloured patches with noise that differ from photo to photo.
Image8 picture(uint64_t seed) {
  Rng rng(seed);
  ImageF patches(10, 8, 3);
  for (float& v : patches.data()) v = float(rng.below(240));
  const ImageF smooth = resized(patches, kWide, kHigh);
  Image8 image(kWide, kHigh, 3);
  for (size_t i = 0; i < image.data().size(); ++i) image.data()[i] = uint8_t(smooth.data()[i] + float(rng.below(12)));
  return image;
}
Image8 depth_map() {
  Image8 map(kWide, kHigh, 1);
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x) map.at(x, y) = uint8_t(20 + x + y / 2);
  return map;
}
Image8 confidence_map() {
  Image8 map(kWide, kHigh, 1);
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x) map.at(x, y) = uint8_t(127 * ((x / 20 + y / 30) % 3));
  return map;
}
Image8 normal_map() {
  Image8 map(kWide, kHigh, 3);
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x) {
      const float nx = float(x - 80) / 120, ny = float(y - 60) / 120, n[3] = {nx, ny, std::sqrt(1 - nx * nx - ny * ny)};
      for (int c = 0; c < 3; ++c) map.at(x, y, c) = uint8_t((n[c] * 0.5f + 0.5f) * 255);
    }
  return map;
}
// The photo inside a disk, transparent black outside.
Image8 cut_out(const Image8& of) {
  Image8 image(kWide, kHigh, 4, 0);
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x)
      if (std::hypot(x - kWide / 2, y - kHigh / 2) < 40) {
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = of.at(x, y, c);
        image.at(x, y, 3) = 255;
      }
  return image;
}

class SecondFiles : public testing::Test {
 protected:
  fs::path photos() const { return folder.path() / "photos"; }
  void put(const fs::path& name, const Image8& image) const {
    make_folders((photos() / name).parent_path());
    image.channels() == 4 ? test::write_rgba_png(photos() / name, image) : write_ldr(photos() / name, image);
  }
  size_t beside(PictureRole role) const {
    size_t n = 0;
    for (const BesidePhoto& file : find_photos(photos()).beside) n += file.role == role;
    return n;
  }

  TemporaryFolder folder;
};

TEST_F(SecondFiles, MapsOfScannersAreNoPhotos) {
  for (int i = 0; i < 4; ++i) {
    put(fmt::format("frame_{:05}.jpg", i), picture(uint64_t(i)));
    put(fmt::format("depth_{:05}.png", i), depth_map());
    put(fmt::format("conf_{:05}.png", i), confidence_map());
  }
  EXPECT_EQ(find_photos(photos()).photos.size(), 4u);
  EXPECT_EQ(beside(PictureRole::Confidence), 4u);
  EXPECT_EQ(beside(PictureRole::Depth), 4u);
  std::string notes;
  for (const FolderNote& note : notes_of(find_photos(photos()))) notes += note.sentence();
  EXPECT_NE(notes.find("4 files are confidence maps of other files"), std::string::npos) << notes;
}

TEST_F(SecondFiles, OutputsOfRenderersNeedNoSeparator) {
  for (int i = 1; i < 5; ++i) {
    put(fmt::format("Image{:04}.jpg", i), picture(uint64_t(i)));
    put(fmt::format("Depth{:04}.png", i), depth_map());
    put(fmt::format("Normal{:04}.png", i), normal_map());
  }
  EXPECT_EQ(find_photos(photos()).photos.size(), 4u);
  EXPECT_EQ(beside(PictureRole::Depth), 4u);
  EXPECT_EQ(beside(PictureRole::Normals), 4u);
}

TEST_F(SecondFiles, PhotosThatAreCalledLikeMapsStayPhotos) {
  for (int i = 0; i < 4; ++i) {
    put(fmt::format("frame_{}.jpg", i), picture(uint64_t(i)));
    put(fmt::format("conf_{}.png", i), picture(uint64_t(20 + i)));
    put(fmt::format("Normal{}.png", i), picture(uint64_t(30 + i)));
    put(fmt::format("labels/frame_{}.png", i), picture(uint64_t(40 + i)));
  }
  EXPECT_EQ(find_photos(photos()).photos.size(), 16u);
}

TEST_F(SecondFiles, CutOutsAreMasksAndNoPhotos) {
  for (int i = 0; i < 4; ++i) {
    const Image8 full = picture(uint64_t(i));
    put(fmt::format("b_{}.jpg", i), full);
    put(fmt::format("b_{}-removebg-preview.png", i), cut_out(full));
  }
  EXPECT_EQ(find_photos(photos()).photos.size(), 4u);
  EXPECT_EQ(beside(PictureRole::Cutout), 4u);
  std::string notes;
  for (const FolderNote& note : notes_of(find_photos(photos()))) notes += note.sentence();
  EXPECT_NE(notes.find("--masks " + photos().string() + " uses their alpha channels"), std::string::npos) << notes;
}

TEST_F(SecondFiles, CutOutsAreFoundByTheirPixelsWhateverTheyAreCalled) {
  for (int i = 0; i < 4; ++i) {
    const Image8 full = picture(uint64_t(i));
    put(fmt::format("b_{}.jpg", i), full);
    put(fmt::format("b_{} final.png", i), cut_out(full));
    put(fmt::format("elsewhere/b_{}.png", i), cut_out(full));
    put(fmt::format("c_{}.png", i), cut_out(picture(uint64_t(50 + i))));  // photos with alpha of their own
  }
  EXPECT_EQ(find_photos(photos()).photos.size(), 8u);
  EXPECT_EQ(beside(PictureRole::Cutout), 8u);
}

TEST(StemKeys, LeaveOutWhatNamesARole) {
  EXPECT_EQ(key_of_stem("conf_00007").role, PictureRole::Confidence);
  EXPECT_EQ(key_of_stem("conf_00007").rest, "7");
  EXPECT_EQ(key_of_stem("Image0007").role, std::nullopt);
  EXPECT_EQ(key_of_stem("Image0007").rest, "7");
  EXPECT_EQ(key_of_stem("cam0_depth_0007").rest, "cam 0 7");
  EXPECT_EQ(key_of_stem("cam0_depth_0007").number, "7");
  EXPECT_EQ(key_of_stem("frame_007Depth").role, PictureRole::Depth);
}

TEST_F(SecondFiles, FilesInPlaceOfTheFolderAreNamed) {
  using namespace std::string_literals;
  write_file(folder.path() / "photos.zip", "PK\x03\x04\x14"s);
  write_file(folder.path() / "photos.tgz", "\x1f\x8b\x08"s);
  write_file(folder.path() / "scan.pdf", "%PDF-1.7\n"s);
  write_file(folder.path() / "notes.txt", "12 photos"s);
  write_ldr(folder.path() / "one.jpg", picture(1));
  const std::pair<const char*, const char*> whys[] = {{"photos.zip", "it is an archive, not a folder"},
                                                      {"photos.tgz", "it is an archive, not a folder"},
                                                      {"scan.pdf", "it is a PDF document, not a folder"},
                                                      {"notes.txt", "it is not a folder"},
                                                      {"one.jpg", "it is one photo, not a folder"}};
  for (const auto& [name, why] : whys) {
    const Error e = error_of([&] { find_photos(folder.path() / name); });
    EXPECT_EQ(e.detail().code, "PHOTOS_UNREADABLE") << name;
    EXPECT_TRUE(e.detail().why.starts_with(why)) << name << ": " << e.detail().why;
  }
}

}  // namespace
}  // namespace vitrine
