// Folders of masks are classes, or folders that the photos have, too; every other name is a mistake with a suggestion. Masks may
// lie beside the photos. A class without a pixel is absent.
#include <gtest/gtest.h>

#include "core/intake/masks/mask_classes.h"
#include "core/intake/masks/photo_masks.h"
#include "stages/masks/masks.h"
#include "tests/stages/masks/tiny_masks.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/rgba_png.h"

namespace vitrine {
namespace {

using namespace test;

// The photos are a.jpg, left/b.jpg, left/c.jpg.
class ClassFolders : public testing::Test {
 protected:
  ClassFolders() { write_tiny_sfm(sfm(), TinySfm()); }
  fs::path sfm() const { return folder.path() / "sfm"; }
  fs::path given() const { return folder.path() / "given"; }
  void put(const fs::path& relative, const Image8& mask) const {
    make_folders((given() / relative).parent_path());
    write_ldr(given() / relative, mask);
  }
  void put_disks(const fs::path& below, double radius = 15) const {
    for (const char* stem : {"a", "left/b", "left/c"}) put(below / (std::string(stem) + ".png"), disk_mask(80, 60, radius));
  }
  std::unique_ptr<RecordingContext> run(const MasksConfig& config = {}) const {
    auto context = std::make_unique<RecordingContext>(std::map<std::string, fs::path>{{"sfm", sfm()}, {"masks", given()}});
    run_masks(config, *context);
    return context;
  }
  Error failure() const {
    return error_of([&] { run(); });
  }
  void again() const { fs::remove_all(given()); }
  TemporaryFolder folder;
};

TEST(MaskClassWords, MeanTheNearestClass) {
  const std::pair<const char*, MaskClass> words[] = {{"glass", MaskClass::Transparent},
                                                     {"Glasses", MaskClass::Transparent},
                                                     {"windows", MaskClass::Transparent},
                                                     {"transparant", MaskClass::Transparent},
                                                     {"glass_masks", MaskClass::Transparent},
                                                     {"Mirrors", MaskClass::Specular},
                                                     {"specualr", MaskClass::Specular},
                                                     {"shiny-metal", MaskClass::Specular},
                                                     {"objects", MaskClass::Object},
                                                     {"Foreground", MaskClass::Object},
                                                     {"fg", MaskClass::Object},
                                                     {"background", MaskClass::Ignore},
                                                     {"ignored", MaskClass::Ignore},
                                                     {"people", MaskClass::Ignore}};
  for (const auto& [word, kind] : words) EXPECT_EQ(probable_mask_class(word), kind) << word;
  for (const char* word : {"left", "2024-05-06", "cam0", "front", ""}) EXPECT_EQ(probable_mask_class(word), std::nullopt) << word;
}

TEST_F(ClassFolders, OfUnknownNamesAreRefusedBesideOthersAndAlone) {
  for (const bool beside : {true, false})
    for (const char* word : {"glass", "Windows", "transmissive", "specualr", "objects", "sam2 output", "kettle"}) {
      again();
      if (beside) put_disks("object");
      put_disks(word);
      const Error e = failure();
      EXPECT_EQ(e.kind(), ErrorKind::Input) << word;
      EXPECT_EQ(e.detail().code, "MASKS_UNKNOWN_CLASS") << word;
      EXPECT_NE(e.message().find(word), std::string::npos) << e.what();
      EXPECT_NE(e.detail().why.find("3 files"), std::string::npos) << e.what();
      const auto meant = probable_mask_class(word);
      EXPECT_EQ(e.detail().hint.find("did you mean") != std::string::npos, meant.has_value()) << e.what();
      if (!meant) continue;
      EXPECT_NE(e.detail().hint.find(std::string(name(*meant))), std::string::npos) << e.what();
    }
}

TEST_F(ClassFolders, MayDifferInLetterCaseAndLieBelowOneThatSaysNothing) {
  for (const char* word : {"Specular", "SPECULAR", "specular ", "masks/specular", "masks/png/Specular"}) {
    again();
    put_disks(word);
    EXPECT_EQ(read_grey8(run()->output() / "masks/specular/left/b.png"), disk_mask(80, 60, 15)) << word;
  }
  again();
  put_disks("masks");
  EXPECT_EQ(read_grey8(run()->output() / "masks/object/left/b.png"), disk_mask(80, 60, 15));
}

TEST_F(ClassFolders, OfThePhotosAreNoClasses) {
  put_disks("");  // a.png, left/b.png, left/c.png
  EXPECT_EQ(read_grey8(run()->output() / "masks/object/left/b.png"), disk_mask(80, 60, 15));
  again();
  for (const char* name : {"left/specular/b.png", "left/specular/c.png"}) put(name, disk_mask(80, 60, 15));
  EXPECT_EQ(read_grey8(run()->output() / "masks/specular/left/b.png"), disk_mask(80, 60, 15))
      << "a class inside a folder of photos";
  // Photos may lie in folders that are called like a class or like a word for one.
  MaskClassFolders classes("masks", MaskClass::Object, {"glass/a.jpg", "mirror/object/b.jpg"});
  EXPECT_EQ(classes.place("glass/a.png")->kind, MaskClass::Object);
  EXPECT_EQ(classes.place("glass/a.png")->name, "glass/a.png");
  EXPECT_EQ(classes.place("specular/mirror/object/b.png")->kind, MaskClass::Specular);
  EXPECT_EQ(classes.place("specular/mirror/object/b.png")->name, "mirror/object/b.png");
  EXPECT_EQ(classes.place("mirror/object/b.png")->kind, MaskClass::Object);
  EXPECT_EQ(classes.place("mirror/object/b.png")->name, "mirror/object/b.png");
  EXPECT_NO_THROW(classes.throw_if_unknown());
}

TEST_F(ClassFolders, MayBeLinksAlsoToOneAnother) {
  put_disks("transparent");
  fs::create_directory_symlink("transparent", given() / "specular");
  const auto context = run();
  for (const char* kind : {"transparent", "specular"})
    EXPECT_EQ(read_grey8(context->output() / "masks" / kind / "left/b.png"), disk_mask(80, 60, 15)) << kind;
}

TEST_F(ClassFolders, HoldJunkThatIsNoMask) {
  put_disks("specular");
  for (const char* name : {"specular/._a.png", "specular/@eaDir/a.png", "specular/left/.thumbnails/b.png"}) {
    make_folders((given() / name).parent_path());
    write_file(given() / name, "no picture");
  }
  EXPECT_EQ(read_grey8(run()->output() / "masks/specular/left/b.png"), disk_mask(80, 60, 15));
}

TEST_F(ClassFolders, WithoutAPixelAreAbsentWhereOthersHaveSome) {
  put_disks("object");
  put_disks("transparent", 0);
  const auto context = run();
  EXPECT_EQ(read_grey8(context->output() / "masks/object/a.png"), disk_mask(80, 60, 15));
  EXPECT_FALSE(fs::exists(context->output() / "masks/transparent"));
  ASSERT_TRUE(context->warnings.contains("MASKS_EMPTY"));
  EXPECT_NE(context->warnings["MASKS_EMPTY"].find("'transparent' are black (3)"), std::string::npos)
      << context->warnings["MASKS_EMPTY"];
  again();
  put_disks("object", 0);
  put_disks("transparent", 0);
  EXPECT_EQ(failure().detail().code, "MASKS_ALL_BLACK");
}

TEST_F(ClassFolders, WithEveryPixelAreNamed) {
  for (const char* stem : {"a", "left/b", "left/c"})
    put(fs::path("object") / (std::string(stem) + ".png"), Image8(80, 60, 1, 255));
  const auto context = run();
  ASSERT_TRUE(context->warnings.contains("MASKS_ALL_WHITE"));
  EXPECT_NE(context->warnings["MASKS_ALL_WHITE"].find("masks.object.polarity=black"), std::string::npos);
  fs::rename(given() / "object", given() / "ignore");
  EXPECT_EQ(failure().detail().code, "MASKS_ALL_WHITE");
}

TEST_F(ClassFolders, MasksBesideThePhotosAreFoundAndThePhotosAreNone) {
  const auto colourful = [](uint8_t shade) {
    Image8 photo(80, 60, 3);
    for (size_t i = 0; i < photo.data().size(); ++i) photo.data()[i] = uint8_t(i * 37 + shade);
    return photo;
  };
  const auto photos = [&](const std::string& below) {
    for (const char* name : {"a.jpg", "left/b.jpg", "left/c.jpg"}) put(below + name, colourful(uint8_t(name[0])));
  };
  photos("");
  for (const char* name : {"a_mask.png", "left/b_mask.png"}) put(name, disk_mask(80, 60, 15));
  const auto context = run();
  EXPECT_EQ(read_grey8(context->output() / "masks/object/left/b.png"), disk_mask(80, 60, 15));
  EXPECT_TRUE(context->warnings.contains("MASKS_INCOMPLETE")) << "left/c.jpg has none, and is none itself";

  again();
  photos("images/");
  for (const char* name : {"masks/a.png", "masks/left/b.png", "masks/left/c.png"}) put(name, disk_mask(80, 60, 15));
  for (const char* name : {"masks/transparent/a.png", "masks/transparent/left/b.png"}) put(name, disk_mask(80, 60, 8));
  const auto whole = run();
  EXPECT_EQ(read_grey8(whole->output() / "masks/object/left/b.png"), disk_mask(80, 60, 15));
  EXPECT_EQ(read_grey8(whole->output() / "masks/transparent/left/b.png"), disk_mask(80, 60, 8));
}

TEST_F(ClassFolders, CutOutsBesideThePhotosGiveTheirAlpha) {
  Image8 photo(80, 60, 3), cut(80, 60, 4, 0);
  const Image8 disk = disk_mask(80, 60, 15);
  for (size_t i = 0; i < photo.data().size(); ++i) photo.data()[i] = uint8_t(i / 60);
  for (size_t i = 0; i < disk.data().size(); ++i)
    if (disk.data()[i]) {
      for (size_t c = 0; c < 3; ++c) cut.data()[4 * i + c] = photo.data()[3 * i + c];
      cut.data()[4 * i + 3] = 255;
    }
  for (const char* stem : {"a", "left/b", "left/c"}) {
    put(std::string(stem) + ".jpg", photo);
    write_rgba_png(given() / (std::string(stem) + "-removebg-preview.png"), cut);
  }
  EXPECT_EQ(read_grey8(run()->output() / "masks/object/left/b.png"), disk);
}

TEST_F(ClassFolders, PicturesOfMasksLaidOverPhotosAreNoMasks) {
  put_disks("object");
  Image8 overlay(80, 60, 3);
  for (size_t i = 0; i < overlay.data().size(); ++i) overlay.data()[i] = uint8_t(i * 37);
  put("object/preview of masks.jpg", overlay);
  put("left/b.jpg", overlay);
  EXPECT_EQ(read_grey8(run()->output() / "masks/object/left/b.png"), disk_mask(80, 60, 15));
  EXPECT_EQ(read_grey8(run()->output() / "masks/object/a.png"), disk_mask(80, 60, 15)) << "nothing lies beside this one";
}

TEST_F(ClassFolders, PhotosThatAreCalledLikeMasksHaveMasks) {
  put("carnival_mask.png", disk_mask(80, 60, 15));
  const MaskFolder masks(given(), MaskClass::Object, {"carnival_mask.jpg", "carnival.jpg"});
  EXPECT_TRUE(masks.find(MaskClass::Object, "carnival_mask.jpg"));
  EXPECT_FALSE(masks.find(MaskClass::Object, "carnival.jpg"));
}

TEST_F(ClassFolders, AreCheckedByTheirNamesAlone) {
  const std::vector<std::string> photos{"a.jpg", "left/b.jpg", "left/c.jpg"};
  write_file(given() / "object/a.png", "not looked at");
  EXPECT_EQ(check_mask_names(given(), MaskClass::Object, photos),
            std::vector<std::string>{"2 of 3 photos have no mask of the class 'object'"});
  write_file(given() / "specular/x.png", "");
  EXPECT_EQ(error_of([&] { check_mask_names(given(), MaskClass::Object, photos); }).detail().code, "MASKS_MATCH_NO_PHOTO");
  const MaskClass used[] = {MaskClass::Object};
  EXPECT_EQ(check_mask_names(given(), MaskClass::Object, photos, used).size(), 1u);
  write_file(given() / "glass/a.png", "");
  EXPECT_EQ(error_of([&] { check_mask_names(given(), MaskClass::Object, photos, used); }).detail().code, "MASKS_UNKNOWN_CLASS");
  again();
  make_folders(given());
  EXPECT_EQ(error_of([&] { check_mask_names(given(), MaskClass::Object, photos); }).detail().code, "MASKS_MISSING");
}

}  // namespace
}  // namespace vitrine
