// Masks of the user's: every naming and polarity ends in the same bytes, and what cannot be right is refused with a reason.
#include <gtest/gtest.h>

#include "core/foundation/config/json_file.h"
#include "stages/masks/masks.h"
#include "tests/stages/masks/tiny_masks.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_photos.h"

namespace vitrine {
namespace {

using namespace test;

class Files : public testing::Test {
 protected:
  Files() {
    const TinySfm tiny;
    write_tiny_sfm(sfm(), tiny);
  }
  fs::path sfm() const { return folder.path() / "sfm"; }
  fs::path given() const { return folder.path() / "given"; }
  void put(const fs::path& relative, const Image8& mask) const {
    make_folders((given() / relative).parent_path());
    write_ldr(given() / relative, mask);
  }
  // One disk per photo, in the way `name_of` calls the file of "left/b".
  template <class F>
  void put_all(F&& name_of, bool inverted = false) const {
    for (const char* stem : {"a", "left/b", "left/c"})
      put(name_of(fs::path(stem)), inverted ? negative(disk_mask(80, 60, 15)) : disk_mask(80, 60, 15));
  }
  std::unique_ptr<RecordingContext> run(const MasksConfig& config = {}) const {
    auto context = std::make_unique<RecordingContext>(std::map<std::string, fs::path>{{"sfm", sfm()}, {"masks", given()}});
    run_masks(config, *context);
    return context;
  }
  Error failure(const MasksConfig& config = {}) const {
    return error_of([&] { run(config); });
  }
  TemporaryFolder folder;
};

fs::path suffixed(const fs::path& p, const std::string& suffix) { return p.parent_path() / (p.filename().string() + suffix); }

TEST(MaskClasses, AreFoundByTheirNamesOnly) {
  for (MaskClass kind : kMaskClasses) EXPECT_EQ(mask_class(name(kind)), kind);
  for (const char* other : {"", "Object", "glass", "transparent "}) EXPECT_EQ(mask_class(other), std::nullopt) << other;
}

TEST_F(Files, EveryNamingGivesTheSameMask) {
  put_all([](const fs::path& p) { return "specular" / suffixed(p, ".jpg.png"); });
  const Image8 expected = read_grey8(run()->output() / "masks/specular/left/b.png");
  EXPECT_EQ(expected, disk_mask(80, 60, 15));
  using Naming = std::function<fs::path(const fs::path&)>;
  const Naming namings[] = {
      [](const fs::path& p) { return "specular" / suffixed(p, ".png"); },
      [](const fs::path& p) { return "specular" / suffixed(p, "_mask.png"); },
      [](const fs::path& p) { return "specular" / suffixed(p, ".jpg_mask.png"); },
      [](const fs::path& p) { return "specular" / suffixed(p, ".mask.png"); },
      [](const fs::path& p) { return "specular" / suffixed(p, ".tif"); },
      [](const fs::path& p) { return "SPECULAR" / suffixed(p, ".PNG"); },
      [](const fs::path& p) { return "specular" / p.parent_path() / ("dynamic_mask_" + p.filename().string() + ".png"); },
      [](const fs::path& p) { return "specular" / suffixed(p.filename(), ".png"); },  // folders left out
  };
  for (size_t i = 0; i < std::size(namings); ++i) {
    fs::remove_all(given());
    for (const char* stem : {"a", "left/b", "left/c"}) {
      const fs::path to = given() / namings[i](stem), png = folder.path() / "m.png";
      make_folders(to.parent_path());
      const bool png_bytes = to.extension() != ".tif";
      write_ldr(png_bytes ? png : to, disk_mask(80, 60, 15));
      if (png_bytes) fs::rename(png, to);
    }
    EXPECT_EQ(read_grey8(run()->output() / "masks/specular/left/b.png"), expected) << "naming " << i;
  }
}

TEST_F(Files, TransformsAndMeshroomNameTheirMasks) {
  for (const char* stem : {"a", "b", "c"}) put(std::string("pics/") + stem + "_x7.png", disk_mask(80, 60, 15));
  write_file(
      given() / "transforms.json",
      R"({"frames":[{"file_path":"images/a.jpg","mask_path":"pics/a_x7.png"},{"file_path":"left/b.jpg","mask_path":"pics/b_x7.png"},
                           {"file_path":"left/c.jpg","mask_path":"pics/c_x7.png"}]})");
  EXPECT_EQ(read_grey8(run()->output() / "masks/object/left/b.png"), disk_mask(80, 60, 15));
  fs::remove_all(given());
  for (int id : {11, 12, 13}) put("specular/" + std::to_string(id) + ".png", disk_mask(80, 60, 15));
  write_file(given() / "specular/cameras.sfm", R"({"views":[{"viewId":"11","path":"/x/a.jpg"},{"viewId":"12","path":"/x/b.jpg"},
                                                           {"viewId":13,"path":"/x/c.jpg"}]})");
  EXPECT_EQ(read_grey8(run()->output() / "masks/specular/left/c.png"), disk_mask(80, 60, 15));
}

TEST_F(Files, FlatFilesAreTheObjectAndInstantNgpsMarkWhatMoves) {
  put_all([](const fs::path& p) { return suffixed(p, ".png"); });
  put("dynamic_mask_a.png", disk_mask(80, 60, 8));
  const auto context = run();
  EXPECT_EQ(read_grey8(context->output() / "masks/object/a.png"), disk_mask(80, 60, 15));
  EXPECT_EQ(read_grey8(context->output() / "masks/ignore/a.png"), disk_mask(80, 60, 8));
  EXPECT_TRUE(context->warnings.contains("MASKS_INCOMPLETE")) << "two photos have no mask of what moves";
  EXPECT_EQ(coverage(read_grey8(context->output() / "masks/ignore/left/b.png")), 0);
  EXPECT_EQ(coverage(read_grey8(context->output() / "masks/confidence/left/b.png")), 0);
  // COLMAP: black outside the object and where something moves.
  const Image8 colmap = read_grey8(context->output() / "masks/colmap/a.jpg.png");
  EXPECT_EQ(colmap.at(2, 2), 0);
  EXPECT_EQ(colmap.at(40, 30), 0);
  EXPECT_EQ(colmap.at(40, 30 - 11), 255);
}

TEST_F(Files, LabelsAlphaAndPaintedMasksAreUnderstood) {
  Image8 labels = disk_mask(80, 60, 15);
  for (uint8_t& v : labels.data()) v = v ? 3 : 0;
  put("specular/a.mask.png", labels);
  Image8 painted(80, 60, 3);
  for (size_t i = 0; i < painted.pixel_count(); ++i) painted.data()[3 * i] = disk_mask(80, 60, 15).data()[i];
  put("specular/left/b.png", painted);
  const auto context = run();
  EXPECT_EQ(read_grey8(context->output() / "masks/specular/a.png"), disk_mask(80, 60, 15));
  EXPECT_EQ(read_grey8(context->output() / "masks/specular/left/b.png"), disk_mask(80, 60, 15));
}

// PASCAL VOC and its descendants write 255 around objects whose outline is uncertain.
TEST_F(Files, WhiteBesideLabelsIsVoid) {
  const Image8 disk = disk_mask(80, 60, 15), large = disk_mask(80, 60, 18);
  Image8 labels = disk;
  for (size_t i = 0; i < labels.data().size(); ++i) labels.data()[i] = disk.data()[i] ? 1 + i % 2 : large.data()[i] ? 255 : 0;
  put_all([](const fs::path& p) { return suffixed(p, ".png"); });
  put("specular/a.png", labels);
  const auto context = run();
  EXPECT_EQ(read_grey8(context->output() / "masks/specular/a.png"), disk);
  EXPECT_NE(context->warnings["MASKS_VOID_LABEL"].find("1 of the masks of the class 'specular'"), std::string::npos);
}

// The folder of photos given as that of masks: an alpha channel is the mask, a photo without one is none.
TEST_F(Files, PhotosAreMasksWhereTheirAlphaVaries) {
  const Image8 disk = disk_mask(80, 60, 15);
  const auto photo = [&](bool cut_out) {
    Image16 image(80, 60, 4, 65535);
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 80; ++x) {
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<uint16_t>((x * 800 * (c + 1) + y * 500) % 65536);
        if (cut_out) image.at(x, y, 3) = static_cast<uint16_t>(disk.at(x, y) * 257);
      }
    return tagged_tiff(image, "");
  };
  Image8 colours(80, 60, 3);
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x)
      for (int c = 0; c < 3; ++c) colours.at(x, y, c) = static_cast<uint8_t>(x * 3 * (c + 1) + y);
  const auto jpeg = [&](const char* name) {
    make_folders((given() / name).parent_path());
    write_ldr(given() / name, colours);
  };
  jpeg("a.jpg");
  make_folders(given() / "left");
  write_file(given() / "left/b.tif", photo(true));
  write_file(given() / "left/c.tif", photo(true));
  const auto context = run();
  EXPECT_EQ(read_grey8(context->output() / "masks/object/left/b.png"), disk);
  const auto report = nlohmann::json::parse(read_file(context->output() / "masks" / "report.json"));
  EXPECT_NE(report.dump().find("\"photos_without_mask\":1"), std::string::npos) << report.dump(1);
  // Photos alone are no masks.
  fs::remove_all(given());
  for (const char* name : {"a.jpg", "left/b.jpg", "left/c.jpg"}) jpeg(name);
  EXPECT_EQ(failure().detail().code, "MASKS_ARE_PHOTOS");
}

TEST_F(Files, MasksFollowThePhotosThroughTheLens) {
  TinySfm tiny;
  tiny.photographed.params[3] = 0.2;
  fs::remove_all(sfm());
  write_tiny_sfm(sfm(), tiny);
  const Undistortion u = undistortion(tiny.photographed);
  ASSERT_FALSE(u.identity);
  ASSERT_NE(u.target.width, 80);
  // Twice the photo's size, a disk towards the corner where the lens bends most.
  put("specular/a.png", disk_mask(160, 120, 16, 120, 90));
  put("specular/left/b.png", disk_mask(u.target.width, u.target.height, 8, 50, 40));  // drawn on the undistorted photo
  const auto context = run();
  const Image8 bent = read_grey8(context->output() / "masks/specular/a.png");
  ASSERT_EQ(bent.width(), u.target.width);
  double x = 0, y = 0, sum = 0;
  for (int j = 0; j < bent.height(); ++j)
    for (int i = 0; i < bent.width(); ++i) x += (i + 0.5) * bent.at(i, j), y += (j + 0.5) * bent.at(i, j), sum += bent.at(i, j);
  const auto centre = undistorted(Vec2d{60, 45}, u);
  ASSERT_TRUE(centre);
  EXPECT_GT(std::hypot(centre->x - 60, centre->y - 45), 1.5) << "the lens moves this pixel";
  EXPECT_NEAR(x / sum, centre->x, 0.4);
  EXPECT_NEAR(y / sum, centre->y, 0.4);
  EXPECT_EQ(read_grey8(context->output() / "masks/specular/left/b.png"), disk_mask(u.target.width, u.target.height, 8, 50, 40));
}

TEST_F(Files, SoftValuesAreKept) {
  Image8 soft(80, 60, 1, 0);
  for (int x = 20; x < 60; ++x) soft.at(x, 30) = uint8_t(x);
  put("transparent/a.png", soft);
  const auto context = run();
  const ImageF written = read_unchanged(context->output() / "masks/transparent/a.png");
  EXPECT_NEAR(written.at(40, 30), 40 / 255.f, 1e-6);
  EXPECT_EQ(written.at(40, 31), 0);
}

TEST_F(Files, WithoutMasksTheArtifactIsEmptyAndValid) {
  RecordingContext context({{"sfm", sfm()}});
  MasksConfig config;
  for (MaskClassConfig* c : {&config.object, &config.transparent, &config.specular, &config.ignore})
    c->source = MaskSourceKind::None;
  run_masks(config, context);
  read_json_file(context.output() / "masks/report.json", "report", [](const nlohmann::json& j) {
    EXPECT_EQ(j.at("photos"), 3);
    EXPECT_EQ(j.at("classes").at("specular").at("source"), "none");
    EXPECT_EQ(j.at("classes").at("specular").at("written"), false);
  });
  for (const char* none : {"object", "transparent", "specular", "ignore", "confidence", "colmap", "contact_sheet.png"})
    EXPECT_FALSE(fs::exists(context.output() / "masks" / none)) << none;
}

TEST_F(Files, RefusesWhatCannotBeRight) {
  put("specular/other.png", disk_mask(80, 60, 15));
  Error e = failure();
  EXPECT_EQ(e.detail().code, "MASKS_MATCH_NO_PHOTO");
  EXPECT_NE(e.detail().why.find("a.jpg"), std::string::npos);
  EXPECT_FALSE(e.detail().hint.empty());

  put("specular/a.png", disk_mask(80, 40, 15));
  e = failure();
  EXPECT_EQ(e.detail().code, "MASK_WRONG_SIZE");
  put("specular/a.png", disk_mask(60, 80, 15));
  e = failure();
  EXPECT_EQ(e.detail().code, "MASK_WRONG_SIZE");
  EXPECT_NE(e.detail().hint.find("EXIF"), std::string::npos);

  put("specular/a.png", negative(disk_mask(80, 60, 15)));
  e = failure();
  EXPECT_EQ(e.detail().code, "MASKS_INVERTED");
  MasksConfig told;
  told.specular.polarity = MaskPolarity::Black;
  EXPECT_EQ(read_grey8(run(told)->output() / "masks/specular/a.png"), disk_mask(80, 60, 15));

  put("specular/a.png", Image8(80, 60, 1));
  EXPECT_EQ(failure().detail().code, "MASKS_ALL_BLACK");
  write_file(given() / "specular/a.png", "not a picture");
  EXPECT_EQ(failure().detail().code, "MASK_UNREADABLE");
  Image8 photo(80, 60, 3);
  for (size_t i = 0; i < photo.data().size(); ++i) photo.data()[i] = uint8_t(i * 37);
  put("specular/a.png", photo);
  EXPECT_EQ(failure().detail().code, "MASK_NOT_GREY");
  put("specular/a.png", disk_mask(80, 60, 15));
  put("specular/a.tif", disk_mask(80, 60, 15));
  EXPECT_EQ(failure().detail().code, "MASKS_AMBIGUOUS");
  fs::remove_all(given());
  EXPECT_EQ(failure().detail().code, "MASKS_MISSING");
  make_folders(given());
  EXPECT_EQ(failure().detail().code, "MASKS_MISSING");
}

TEST_F(Files, ASourceWithoutFilesIsAUsageError) {
  RecordingContext context({{"sfm", sfm()}});
  MasksConfig config;
  config.object.source = MaskSourceKind::Files;
  const Error e = error_of([&] { run_masks(config, context); });
  EXPECT_EQ(e.kind(), ErrorKind::Usage);
  EXPECT_NE(e.detail().hint.find("--masks"), std::string::npos);
}

}  // namespace
}  // namespace vitrine
