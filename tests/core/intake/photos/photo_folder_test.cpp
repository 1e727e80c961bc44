// Folders as people have them: links, junk of their systems, masks and depth maps beside the photos, whole data sets with reduced
// copies. Photos are found, what belongs to them is told apart, and every file that is left out is counted and named.
#include <unistd.h>

#include <cmath>

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/rng.h"
#include "core/intake/photos/photo_files.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "tests/support/error_of.h"
#include "tests/support/tiny_photos.h"

namespace vitrine {
namespace {

// Coloured patches that differ from photo to photo.
Image8 photo(uint64_t seed, int w = 160, int h = 120) {
  Rng rng(seed);
  ImageF patches(10, 8, 3);
  for (float& v : patches.data()) v = float(rng.below(256));
  const ImageF smooth = resized(patches, w, h);
  Image8 image(w, h, 3);
  for (size_t i = 0; i < image.data().size(); ++i) image.data()[i] = uint8_t(smooth.data()[i]);
  return image;
}

Image8 shrunk(const Image8& image, int factor) {
  ImageF values(image.width(), image.height(), 3);
  for (size_t i = 0; i < values.data().size(); ++i) values.data()[i] = float(image.data()[i]);
  const ImageF small = resized(values, image.width() / factor, image.height() / factor);
  Image8 out(small.width(), small.height(), 3);
  for (size_t i = 0; i < out.data().size(); ++i) out.data()[i] = uint8_t(small.data()[i] + 0.5f);
  return out;
}

Image8 disk(int w = 160, int h = 120) {
  Image8 mask(w, h, 1);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) mask.at(x, y) = std::hypot(x - w / 2, y - h / 2) < h / 3.0 ? 255 : 0;
  return mask;
}

class PhotoFolders : public testing::Test {
 protected:
  fs::path at(const fs::path& name) const { return folder.path() / "photos" / name; }
  void put(const fs::path& name, const Image8& image) const {
    make_folders(at(name).parent_path());
    write_ldr(at(name), image);
  }
  void put_photos(const fs::path& below = {}, int n = 3, uint64_t seed = 10) const {
    for (int i = 0; i < n; ++i) put(below / fmt::format("img_{}.jpg", i), photo(seed + uint64_t(i)));
  }
  PhotoFolder found() const { return find_photos(folder.path() / "photos"); }
  static std::vector<std::string> sources(const PhotoFolder& f) {
    std::vector<std::string> names;
    for (const PhotoFile& p : f.photos) names.push_back(p.source);
    return names;
  }
  static std::string note(const PhotoFolder& f, const std::string& code) {
    for (const FolderNote& n : notes_of(f))
      if (n.code == code) return n.sentence();
    return {};
  }
  static bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

  TemporaryFolder folder;
};

using Names = std::vector<std::string>;
const Names kThree{"img_0.jpg", "img_1.jpg", "img_2.jpg"};

TEST_F(PhotoFolders, LinkedFoldersAndFilesAreFollowed) {
  put_photos();
  const fs::path other = folder.path() / "other disk";
  make_folders(other / "deep");
  write_ldr(other / "b.jpg", photo(30));
  write_ldr(other / "deep/c.jpg", photo(31));
  fs::create_directory_symlink(other, at("day2"));
  write_ldr(folder.path() / "d.jpg", photo(32));
  fs::create_symlink("../d.jpg", at("linked.jpg"));
  EXPECT_EQ(sources(found()), (Names{"day2/b.jpg", "day2/deep/c.jpg", "img_0.jpg", "img_1.jpg", "img_2.jpg", "linked.jpg"}));
  EXPECT_TRUE(notes_of(found()).empty());
}

TEST_F(PhotoFolders, CirclesRepeatsAndDanglingLinksAreLeftOutAndNamed) {
  put_photos();
  put_photos("day1", 1, 40);
  fs::create_directory_symlink(at("."), at("self"));
  fs::create_directory_symlink(folder.path(), at("day1/up"));
  fs::create_directory_symlink(at("day1"), at("again"));
  fs::create_symlink(at("img_0.jpg"), at("copy.jpg"));
  fs::create_symlink("nowhere.jpg", at("gone.jpg"));
  const PhotoFolder f = found();
  EXPECT_EQ(sources(f), (Names{"day1/img_0.jpg", "img_0.jpg", "img_1.jpg", "img_2.jpg"}));
  EXPECT_EQ(f.listed.circles, (Names{"day1/up", "self"}));
  EXPECT_EQ(f.listed.repeated, (Names{"again", "copy.jpg"}));
  EXPECT_EQ(f.listed.dangling, Names{"gone.jpg"});
  EXPECT_TRUE(says(note(f, "LINKS_IN_A_CIRCLE"), "2 links")) << note(f, "LINKS_IN_A_CIRCLE");
  EXPECT_TRUE(says(note(f, "LINKS_TO_THE_SAME"), "again, copy.jpg"));
  EXPECT_TRUE(says(note(f, "LINKS_BROKEN"), "1 link leads to nothing (gone.jpg)"));
}

TEST_F(PhotoFolders, TwoLinksToOneFolderCountOnce) {
  put_photos();
  const fs::path other = folder.path() / "other";
  make_folders(other);
  write_ldr(other / "b.jpg", photo(30));
  for (const char* link : {"one", "two"}) fs::create_directory_symlink(other, at(link));
  const PhotoFolder f = found();
  EXPECT_EQ(sources(f), (Names{"img_0.jpg", "img_1.jpg", "img_2.jpg", "one/b.jpg"}));
  EXPECT_EQ(f.listed.repeated, Names{"two"});
}

TEST_F(PhotoFolders, JunkOfSystemsAndNetworkDrivesIsLeftOut) {
  put_photos();
  for (const char* name : {"@eaDir/img_0.jpg/SYNOPHOTO_THUMB_XL.jpg", "#recycle/old.jpg", "__MACOSX/img_0.jpg",
                           "$RECYCLE.BIN/a.jpg", "day/@eaDir/x.jpg", ".thumbnails/img_0.jpg", "._img_0.jpg", "lost+found/a.jpg",
                           "@__thumb/img_0.jpg", "SYNOFILE_THUMB_M.jpg", "System Volume Information/a.jpg"})
    put(name, photo(90));
  for (const char* name : {"Thumbs.db", "desktop.ini", ".DS_Store"}) write_file(at(name), "x");
  const PhotoFolder f = found();
  EXPECT_EQ(sources(f), kThree);
  EXPECT_EQ(f.listed.junk, 11u);
  EXPECT_EQ(f.listed.hidden, 3u);
}

TEST_F(PhotoFolders, AClosedFolderIsNamed) {
  put_photos();
  put_photos("closed", 1, 40);
  fs::permissions(at("closed"), fs::perms::none);
  // Root opens every folder: look as somebody else.
  for (const fs::path& open : {folder.path(), folder.path() / "photos"})
    fs::permissions(open, fs::perms::all, fs::perm_options::replace);
  const bool root = geteuid() == 0;
  ASSERT_TRUE(!root || seteuid(65534) == 0);
  const PhotoFolder f = found();
  ASSERT_TRUE(!root || seteuid(0) == 0);
  fs::permissions(at("closed"), fs::perms::owner_all);
  EXPECT_EQ(sources(f), kThree);
  EXPECT_TRUE(says(note(f, "FOLDERS_CLOSED"), "1 folder cannot be opened (closed)")) << note(f, "FOLDERS_CLOSED");
}

TEST_F(PhotoFolders, MasksBesideThePhotosAreNoPhotosWhateverTheyAreCalled) {
  using Naming = std::function<std::string(const std::string&)>;
  const std::pair<const char*, Naming> namings[] = {
      {"ODM", [](const std::string& b) { return b + "_mask.png"; }},
      {"capitals", [](const std::string& b) { return b + "_MASK.PNG"; }},
      {"COLMAP", [](const std::string& b) { return b + ".jpg.png"; }},
      {"OpenMVS", [](const std::string& b) { return b + ".mask.png"; }},
      {"with extension", [](const std::string& b) { return b + ".jpg_mask.png"; }},
      {"before", [](const std::string& b) { return "mask_" + b + ".png"; }},
      {"instant-ngp", [](const std::string& b) { return "dynamic_mask_" + b + ".png"; }},
      {"segmentation", [](const std::string& b) { return b + "_seg.png"; }},
      {"numbered", [](const std::string& b) { return b + "_mask_0.png"; }},
      {"joined", [](const std::string& b) { return b + "mask.png"; }},
      {"JPEG", [](const std::string& b) { return b + "-mask.jpg"; }},
      {"same name", [](const std::string& b) { return b + ".png"; }},
      {"folder", [](const std::string& b) { return "masks/" + b + ".png"; }},
      {"folder, COLMAP", [](const std::string& b) { return "mask/" + b + ".jpg.png"; }},
      {"folder of a class", [](const std::string& b) { return "masks/object/" + b + ".png"; }},
      {"class alone", [](const std::string& b) { return "Transparent/" + b + ".png"; }},
  };
  for (const auto& [what, name_of] : namings) {
    fs::remove_all(folder.path() / "photos");
    put_photos();
    for (const std::string base : {"img_0", "img_1", "img_2"}) {
      const fs::path to = at(name_of(base)), png = folder.path() / "m.png";
      make_folders(to.parent_path());
      const bool jpeg = to.extension() == ".jpg";
      write_ldr(jpeg ? to : png, disk());
      if (!jpeg) fs::rename(png, to);
    }
    const PhotoFolder f = found();
    EXPECT_EQ(sources(f), kThree) << what;
    ASSERT_EQ(f.beside.size(), 3u) << what;
    for (const BesidePhoto& b : f.beside) EXPECT_TRUE(says(b.source, fs::path(b.of).stem().string())) << what << " " << b.source;
    EXPECT_TRUE(says(note(f, "MASKS_BESIDE_PHOTOS"), "3 files are masks of other files")) << what;
    EXPECT_TRUE(says(note(f, "MASKS_BESIDE_PHOTOS"), "--masks " + (folder.path() / "photos").string())) << what;
  }
}

TEST_F(PhotoFolders, MasksBesideTheFolderOfPhotosBelongByTheirPlace) {
  put_photos("images/left", 2, 10);
  put_photos("images/right", 2, 20);
  for (const char* side : {"left", "right"})
    for (int i = 0; i < 2; ++i) {
      put(fmt::format("masks/{}/img_{}.png", side, i), disk());
      put(fmt::format("masks_2/{}/img_{}.png", side, i), disk(80, 60));
    }
  const PhotoFolder f = found();
  EXPECT_EQ(sources(f),
            (Names{"images/left/img_0.jpg", "images/left/img_1.jpg", "images/right/img_0.jpg", "images/right/img_1.jpg"}));
  size_t masks = 0;
  for (const BesidePhoto& b : f.beside) {
    if (b.role != PictureRole::Mask) continue;
    ++masks;
    EXPECT_EQ(fs::path(b.of).parent_path().filename(), fs::path(b.source).parent_path().filename());
  }
  EXPECT_EQ(masks, 4u) << "the reduced ones are copies";
}

TEST_F(PhotoFolders, PhotosThatAreCalledLikeMasksStayPhotos) {
  put("carnival_mask.jpg", photo(1));
  put("mask_of_agamemnon.jpg", photo(2));
  put("img.jpg", photo(3));
  put("img_mask.jpg", photo(4));
  put("depth/img.jpg", photo(5));
  Image8 black(160, 120, 3);
  put("img.png", black);  // the lens cap
  const PhotoFolder f = found();
  EXPECT_EQ(f.photos.size(), 6u);
  EXPECT_TRUE(f.beside.empty());
  EXPECT_TRUE(says(note(f, "PHOTOS_CALLED_LIKE_MASKS"), "img_mask.jpg")) << note(f, "PHOTOS_CALLED_LIKE_MASKS");
}

TEST_F(PhotoFolders, OneMaskOfAllPhotosIsNoPhoto) {
  put_photos();
  put("mask.png", disk());
  const PhotoFolder f = found();
  EXPECT_EQ(sources(f), kThree);
  EXPECT_TRUE(says(note(f, "MASKS_BESIDE_PHOTOS"), "mask.png of all photos")) << note(f, "MASKS_BESIDE_PHOTOS");
}

TEST_F(PhotoFolders, RenderedPhotosWithPlainGroundsHaveMasksToo) {
  for (int i = 0; i < 3; ++i) {
    Image8 render(640, 480, 3, 255);  // a small coloured thing on white: few bytes a pixel
    const Image8 thing = photo(uint64_t(i), 120, 90);
    for (int y = 0; y < 90; ++y)
      for (int x = 0; x < 120; ++x)
        for (int c = 0; c < 3; ++c) render.at(300 + x, 200 + y, c) = thing.at(x, y, c);
    put(fmt::format("r_{}.png", i), render);
    put(fmt::format("r_{}_mask.png", i), disk(640, 480));
  }
  const PhotoFolder f = found();
  EXPECT_EQ(f.photos.size(), 3u);
  EXPECT_EQ(f.beside.size(), 3u);
}

TEST_F(PhotoFolders, AFolderOfMasksAloneIsTakenAsItIs) {
  for (const char* name : {"a.png", "b.png", "transparent/a.png", "transparent/b.png", "a_mask.png"}) put(name, disk());
  EXPECT_EQ(found().photos.size(), 5u);
}

TEST_F(PhotoFolders, DepthMapsAndNormalsAreNoPhotos) {
  put_photos();
  Image16 depth(160, 120, 1);
  Image8 normals(160, 120, 3, 0);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      depth.at(x, y) = uint16_t(2000 + 300 * x + 7 * y);
      const float nx = float(x - 80) / 120, ny = float(y - 60) / 120, nz = std::sqrt(1 - nx * nx - ny * ny);
      const float n[3] = {nx, ny, nz};
      for (int c = 0; c < 3; ++c) normals.at(x, y, c) = uint8_t((n[c] * 0.5f + 0.5f) * 255);
    }
  for (int i = 0; i < 3; ++i) {
    write_png16(at(fmt::format("img_{}_depth.png", i)), depth);
    make_folders(at("normals"));
    write_ldr(at(fmt::format("normals/img_{}.png", i)), normals);
    make_folders(at("depths"));
    write_exr(at(fmt::format("depths/img_{}.exr", i)), {.pixels = ImageF(160, 120, 1, 2.f), .channels = {"Z"}, .attributes = {}});
  }
  const PhotoFolder f = found();
  EXPECT_EQ(sources(f), kThree);
  EXPECT_TRUE(says(note(f, "DEPTH_BESIDE_PHOTOS"), "6 files are depth maps")) << note(f, "DEPTH_BESIDE_PHOTOS");
  EXPECT_TRUE(says(note(f, "NORMALS_BESIDE_PHOTOS"), "3 files are maps of normals"));
}

TEST_F(PhotoFolders, ColourAndDepthOfOneFrameAreToldApartByTheirWords) {
  for (int i = 0; i < 3; ++i) {
    put(fmt::format("frame-{:06}.color.jpg", i), photo(uint64_t(i)));
    write_png16(at(fmt::format("frame-{:06}.depth.png", i)), Image16(160, 120, 1, 900));
    put(fmt::format("mask_{}.png", i), disk());
    put(fmt::format("rgb_{}.png", i), photo(uint64_t(10 + i)));
  }
  const PhotoFolder f = found();
  EXPECT_EQ(f.photos.size(), 6u);
  EXPECT_EQ(f.beside.size(), 6u);
}

TEST_F(PhotoFolders, ReducedCopiesOfADataSetAreLeftOut) {
  for (int i = 0; i < 4; ++i) {
    const Image8 full = photo(uint64_t(i), 640, 480);
    const std::string name = fmt::format("img_{}", i);
    put("images/" + name + ".jpg", full);
    put("images_2/" + name + ".jpg", shrunk(full, 2));
    put("images_4/" + name + ".png", shrunk(full, 4));
    put("thumbs/" + name + ".jpg", shrunk(full, 5));
  }
  write_file(at("transforms.json"), "{}");
  const PhotoFolder f = found();
  EXPECT_EQ(sources(f), (Names{"images/img_0.jpg", "images/img_1.jpg", "images/img_2.jpg", "images/img_3.jpg"}));
  EXPECT_TRUE(says(note(f, "REDUCED_COPIES"), "12 files are reduced copies of other files")) << note(f, "REDUCED_COPIES");
  for (const BesidePhoto& b : f.beside) EXPECT_TRUE(b.of.starts_with("images/")) << b.of;
}

TEST_F(PhotoFolders, TheSameNamesInSeveralFoldersAreNoCopies) {
  put_photos("front", 3, 10);  // a rig, or the rounds of a walk
  put_photos("back", 3, 20);
  for (int i = 0; i < 3; ++i) put(fmt::format("tele/img_{}.jpg", i), photo(uint64_t(30 + i), 80, 60));
  const PhotoFolder f = found();
  EXPECT_EQ(f.photos.size(), 9u);
  EXPECT_TRUE(notes_of(f).empty());
}

TEST_F(PhotoFolders, OfTwoVersionsTheUndistortedOneIsNamedAndOneIsUsed) {
  for (int i = 0; i < 3; ++i) {
    const Image8 full = photo(uint64_t(i), 320, 240);
    put(fmt::format("input/img_{}.jpg", i), full);
    ImageF values(320, 240, 3);
    for (size_t k = 0; k < values.data().size(); ++k) values.data()[k] = float(full.data()[k]);
    const ImageF other = resized(values, 316, 238);
    Image8 undistorted(316, 238, 3);
    for (size_t k = 0; k < undistorted.data().size(); ++k) undistorted.data()[k] = uint8_t(other.data()[k]);
    put(fmt::format("images/img_{}.jpg", i), undistorted);
  }
  const PhotoFolder f = found();
  EXPECT_EQ(sources(f), (Names{"images/img_0.jpg", "images/img_1.jpg", "images/img_2.jpg"}));
  const std::string text = note(f, "PHOTOS_IN_TWO_VERSIONS");
  EXPECT_TRUE(says(text, "images and input hold 3 photos in two versions")) << text;
  EXPECT_TRUE(says(text, at("input").string())) << text;
}

TEST_F(PhotoFolders, EmptyOnesSayWhatWasFound) {
  make_folders(at("."));
  fs::create_symlink("nowhere.jpg", at("gone.jpg"));
  const Error e = error_of([&] { found(); });
  EXPECT_EQ(e.detail().code, "NO_PHOTOS");
  EXPECT_TRUE(says(e.detail().why, "1 link leads to nothing")) << e.detail().why;
}

TEST(Inside, LooksThroughLinks) {
  const TemporaryFolder folder;
  make_folders(folder.path() / "a/b");
  fs::create_directory_symlink(folder.path() / "a", folder.path() / "link");
  EXPECT_TRUE(lies_in(folder.path() / "a/b/new/folder", folder.path() / "link"));
  EXPECT_TRUE(lies_in(folder.path() / "link/b", folder.path() / "a/"));
  EXPECT_TRUE(lies_in(folder.path() / "link/", folder.path() / "a"));
  EXPECT_TRUE(lies_in(folder.path() / "a/../a/x", folder.path() / "a"));
  EXPECT_FALSE(lies_in(folder.path() / "a", folder.path() / "a/b"));
  EXPECT_FALSE(lies_in(folder.path() / "ab", folder.path() / "a"));
}

}  // namespace
}  // namespace vitrine
