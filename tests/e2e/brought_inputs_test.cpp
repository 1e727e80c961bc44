// What people bring: folders and files as neighbouring programs, phones and file systems leave them. Each has one right answer of
// `vitrine run`, and `vitrine inspect` gives the same answer before anything is computed.
#include <set>

#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "tests/core/intake/poses/program_files.h"
#include "tests/support/rgba_png.h"
#include "tests/support/tiny_photos.h"
#include "tests/support/vitrine_process.h"

namespace vitrine {
namespace {

constexpr int kWidth = 320, kHeight = 240;

Image8 in_8_bits(const ImageF& image) {
  Image8 out(image.width(), image.height(), image.channels());
  for (size_t i = 0; i < out.data().size(); ++i) out.data()[i] = uint8_t(std::lround(255 * image.data()[i]));
  return out;
}

// The check of a PNG chunk (ISO 3309), big-endian.
std::string crc32_of(const std::string& data) {
  uint32_t crc = ~0u;
  for (unsigned char c : data) {
    crc ^= c;
    for (int k = 0; k < 8; ++k) crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
  }
  crc = ~crc;
  std::string out;
  for (int shift : {24, 16, 8, 0}) out += static_cast<char>(crc >> shift & 0xff);
  return out;
}

// Twelve photos of the cabinet, a quarter of their pixels, with their true poses.
class BroughtInputs : public VitrineProcess {
 protected:
  BroughtInputs() {
    unsetenv("VITRINE_STAGE_DIR");
    unsetenv("VITRINE_CONFIG_DIR");
    unsetenv("VITRINE_COLMAP");
    make_folders(photos());
    const fs::path sample = fs::path(VITRINE_SOURCE_DIR) / "sample_data/cabinet";
    for (View view : read_transforms_json(sample / "truth/transforms.json")) {
      if (seen_++ % 3 != 0) continue;
      const ImageF small = resized(read_srgb(sample / "photos" / view.name), kWidth, kHeight);
      write_ldr(photos() / view.name, in_8_bits(small), 95);
      view.intrinsics = view.intrinsics.scaled_to(kWidth, kHeight);
      views.push_back(view);
    }
  }
  fs::path photos() const final { return folder.path() / "photos"; }
  fs::path here(const std::string& name) const { return folder.path() / name; }

  std::string true_poses() const {
    write_transforms_json(here("transforms.json"), views, "photos");
    return here("transforms.json").string();
  }
  // The true poses as a COLMAP model without points, of the first `count` photos.
  ColmapModel true_model(size_t count) const {
    ColmapModel model;
    model.cameras.push_back(colmap_pinhole(1, views[0].intrinsics));
    for (size_t i = 0; i < std::min(count, views.size()); ++i)
      model.images.push_back({uint32_t(i + 1),
                              quaternion(views[i].cam_from_world.rotation),
                              views[i].cam_from_world.translation,
                              1,
                              views[i].name,
                              {}});
    return model;
  }
  void write_mask(const fs::path& file, uint8_t inside) const {
    Image8 mask(kWidth, kHeight, 1, 0);
    for (int y = 80; y < 160; ++y)
      for (int x = 100; x < 220; ++x) mask.at(x, y, 0) = inside;
    make_folders(file.parent_path());
    write_ldr(file, mask);
  }

  // The codes of all that is said, and the exit code.
  struct Answer {
    int exit = -1;
    std::set<std::string> codes;
    std::string text;
  };
  Answer ran(std::vector<std::string> words, const std::string& to) const {
    words.insert(words.begin(), "run");
    words.insert(words.end(), {"-o", here("out").string(), "--preset", "preview", "--log-format", "json", "--to", to});
    const Outcome o = call(words);
    Answer a{.exit = o.exit, .codes = {}, .text = o.text};
    std::istringstream lines(o.text);
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with("{\"v\"")) continue;
      const auto record = nlohmann::json::parse(line);
      if (record["type"] == "warning" || record["type"] == "error") a.codes.insert(record["code"]);
    }
    return a;
  }
  Answer inspected(std::vector<std::string> words) const {
    words.insert(words.begin(), "inspect");
    words.push_back("--json");
    const Outcome o = call(words);
    Answer a{.exit = o.exit, .codes = {}, .text = o.text};
    const size_t at = o.text.find('{');
    const auto report = at == std::string::npos ? nlohmann::json() : nlohmann::json::parse(o.text.substr(at), nullptr, false);
    if (report.is_object())
      for (const auto& f : report["findings"]) a.codes.insert(f["code"]);
    return a;
  }
  // A run up to `to` ends with `exit` and says `in_run`; inspect says `in_inspect` of the same words.
  void expect(const std::vector<std::string>& words, const std::string& to, int exit, const std::string& in_run,
              const std::string& in_inspect) const {
    const Answer run = ran(words, to);
    EXPECT_EQ(run.exit, exit) << run.text;
    EXPECT_TRUE(run.codes.contains(in_run)) << in_run << " is not in\n" << run.text;
    const Answer look = inspected(words);
    EXPECT_TRUE(look.codes.contains(in_inspect)) << in_inspect << " is not in\n" << look.text;
  }
  void expect_poses(const std::string& poses, int exit, const std::string& code) const {
    expect({photos().string(), "--poses", poses}, "sfm", exit, code, code);
  }

  std::vector<View> views;

 private:
  size_t seen_ = 0;
};

TEST_F(BroughtInputs, RightPosesAndPhotosAreSaidToBeWithoutFault) {
  const Answer look = inspected({photos().string(), "--poses", true_poses()});
  EXPECT_EQ(look.exit, 0);
  // Photos of 320x240 have too few points to tell the exposure of each.
  EXPECT_EQ(look.codes, (std::set<std::string>{"small_photos", "few_photos", "SFM_GAIN_UNKNOWN"})) << look.text;
}

TEST_F(BroughtInputs, PosesInAxesOfOpenCVAreRefused) {
  // The columns of y and z as OpenCV has them, in a file that means OpenGL's.
  for (View& v : views) {
    Rigid world_from_cam = inverse(v.cam_from_world);
    world_from_cam.rotation.c1 = -world_from_cam.rotation.c1;
    world_from_cam.rotation.c2 = -world_from_cam.rotation.c2;
    v.cam_from_world = inverse(world_from_cam);
  }
  expect_poses(true_poses(), 3, "POSES_DISAGREE");
}

// Converted to the files of other programs, the true poses agree with the photos.
TEST_F(BroughtInputs, PosesOfOtherProgramsAreRead) {
  const ColmapModel model = true_model(views.size());
  write_file(here("cameras.xml"), test::metashape_xml(model, {{3, views[0].cam_from_world.rotation, {7, 8, 9}}, true, "", ""}));
  write_file(here("reconstruction.json"), test::opensfm_json(model));
  write_file(here("sfm_data.json"), test::openmvg_json(model));
  for (const char* file : {"cameras.xml", "reconstruction.json", "sfm_data.json"}) {
    const Answer a = ran({photos().string(), "--poses", here(file).string()}, "sfm");
    EXPECT_EQ(a.exit, 0) << a.text;
    EXPECT_NE(a.text.find(fmt::format("registered {}/{}", views.size(), views.size())), std::string::npos) << a.text;
    EXPECT_FALSE(a.codes.contains("POSES_INACCURATE")) << a.text;
  }
  write_file(here("cameras.sfm"), "{}");
  expect_poses(here("cameras.sfm").string(), 3, "POSES_MISSING");
}

TEST_F(BroughtInputs, TwoPosesOfOnePhotoAreRefused) {
  true_poses();
  auto file = nlohmann::json::parse(read_file(here("transforms.json")));
  file["frames"][1]["file_path"] = file["frames"][0]["file_path"];
  write_file(here("transforms.json"), file.dump());
  expect_poses(here("transforms.json").string(), 3, "POSES_TWICE");
}

TEST_F(BroughtInputs, TheLargestOfSeveralModelsIsTaken) {
  for (const auto& [name, count] : {std::pair{"model/sparse/0", size_t(4)}, std::pair{"model/sparse/1", views.size()}}) {
    make_folders(here(name));
    write_colmap_model(here(name), true_model(count), ColmapFormat::Text);
  }
  expect_poses(here("model").string(), 0, "POSES_SEVERAL");
}

TEST_F(BroughtInputs, ReferencesOfAModelThatLeadNowhereAreDropped) {
  ColmapModel model = true_model(views.size());
  for (ColmapImage& image : model.images) image.points.push_back({10, 10, 77});
  model.points.push_back({.id = 1, .position = {0, 0, 0}, .srgb = {}, .error_px = 1, .track = {{1, 0}, {999, 0}}});
  make_folders(here("model"));
  write_colmap_model(here("model"), model, ColmapFormat::Text);
  expect_poses(here("model").string(), 0, "POSES_DANGLING");
}

TEST_F(BroughtInputs, AFolderOfMasksThatIsNoClassIsRefused) {
  for (const View& v : views) write_mask(here("masks/glass") / (v.stem() + ".png"), 255);
  expect({photos().string(), "--masks", here("masks").string()}, "ingest", 3, "MASKS_UNKNOWN_CLASS", "MASKS_UNKNOWN_CLASS");
}

TEST_F(BroughtInputs, AClassOfBlackMasksIsAbsent) {
  for (const View& v : views) {
    write_mask(here("masks/object") / (v.stem() + ".png"), 255);
    write_mask(here("masks/specular") / (v.stem() + ".png"), 0);
  }
  const std::string masks = here("masks").string();
  const Answer look = inspected({photos().string(), "--masks", masks});
  EXPECT_TRUE(look.codes.contains("MASKS_EMPTY")) << look.text;
  const Answer run =
      ran({photos().string(), "--masks", masks, "--poses", true_poses(), "--set", "masks.transparent.source=none"}, "masks");
  EXPECT_EQ(run.exit, 0) << run.text;
  EXPECT_TRUE(run.codes.contains("MASKS_EMPTY")) << run.text;
}

TEST_F(BroughtInputs, MasksBesideThePhotosAreNoPhotos) {
  for (const View& v : views) write_mask(photos() / (v.stem() + "_mask.png"), 255);
  expect({photos().string()}, "ingest", 0, "MASKS_BESIDE_PHOTOS", "masks_beside_photos");
}

TEST_F(BroughtInputs, MapsAndCutOutsBesideThePhotosAreNoPhotos) {
  Image8 ramp(kWidth, kHeight, 1), few(kWidth, kHeight, 1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      ramp.at(x, y, 0) = uint8_t(255 * y / kHeight);
      few.at(x, y, 0) = uint8_t(3 * x / kWidth);
    }
  for (const View& v : views) {
    write_ldr(photos() / (v.stem() + "_depth.png"), ramp);
    write_ldr(photos() / (v.stem() + "_conf.png"), few);
    const Image8 photo = read_srgb8(photos() / v.name);
    Image8 cut(kWidth, kHeight, 4);
    for (int y = 61; y < 180; ++y)
      for (int x = 0; x < kWidth; ++x) {
        for (int c = 0; c < 3; ++c) cut.at(x, y, c) = photo.at(x, y, c);
        cut.at(x, y, 3) = 255;
      }
    test::write_rgba_png(photos() / (v.stem() + "_nobg.png"), cut);
  }
  const Answer run = ran({photos().string()}, "ingest"), look = inspected({photos().string()});
  EXPECT_EQ(run.exit, 0) << run.text;
  for (const char* code : {"DEPTH_BESIDE_PHOTOS", "CONFIDENCE_BESIDE_PHOTOS", "CUTOUTS_BESIDE_PHOTOS"}) {
    EXPECT_TRUE(run.codes.contains(code)) << code << " is not in\n" << run.text;
    EXPECT_TRUE(look.codes.contains(lowered(code))) << code << " is not in\n" << look.text;
  }
  const fs::path artifact = here("out/.cache/ingest") / current_key(here("out"), "ingest").value();
  EXPECT_EQ(nlohmann::json::parse(read_file(artifact / "ingest/photos.json"))["photos"].size(), views.size());
}

TEST_F(BroughtInputs, DepthMapsOfAnotherKindOrOfOtherPhotosAreRefused) {
  Image16 depth(kWidth / 2, kHeight / 2, 1);
  Image8 grey(kWidth, kHeight, 1);
  for (size_t i = 0; i < depth.data().size(); ++i) depth.data()[i] = uint16_t(900 + i % 700);
  for (size_t i = 0; i < grey.data().size(); ++i) grey.data()[i] = uint8_t(i % 251);
  for (const char* folder : {"depth", "grey", "other"}) make_folders(here(folder));
  for (const View& v : views) {
    write_png16(here("depth") / (v.stem() + ".png"), depth);
    write_png16(here("other") / ("x" + v.stem() + "y.png"), depth);
    write_ldr(here("grey") / (v.stem() + ".png"), grey);
  }
  expect({photos().string(), "--depth", here("grey").string()}, "ingest", 3, "NOT_A_DEPTH_MAP", "NOT_A_DEPTH_MAP");
  expect({photos().string(), "--depth", here("other").string()}, "ingest", 3, "DEPTH_MATCHES_NO_PHOTO", "DEPTH_MATCHES_NO_PHOTO");
  const std::vector<std::string> right{photos().string(), "--depth", here("depth").string()};
  EXPECT_EQ(ran(right, "ingest").exit, 0);
  const Answer look = inspected(right);
  EXPECT_TRUE(look.codes.contains("depth_maps")) << look.text;
  EXPECT_NE(look.text.find("0.9 to 1.6 m"), std::string::npos) << look.text;
}

TEST_F(BroughtInputs, LabelMapsWithAVoidValueAreNamed) {
  for (const View& v : views) {
    Image8 labels(kWidth, kHeight, 1);
    for (int y = 80; y < 160; ++y)
      for (int x = 100; x < 220; ++x) labels.at(x, y, 0) = x < 104 ? 255 : uint8_t(1 + x % 2);
    make_folders(here("masks/object"));
    write_ldr(here("masks/object") / (v.stem() + ".png"), labels);
  }
  EXPECT_TRUE(inspected({photos().string(), "--masks", here("masks").string()}).codes.contains("MASKS_VOID_LABEL"));
}

// The whole list of mistakes: tests/pipeline/given_inputs_test.cpp.
TEST_F(BroughtInputs, MistakesInMarksAndMeasuresAreRefusedBeforeAnythingIsComputed) {
  write_file(here("marks.yaml"), fmt::format("size: [{}, {}]\nmarks:\n  - {{photo: {}, class: glass, box: [9, 9, 99, 99]}}\n",
                                             kWidth, kHeight, views[0].name));
  const std::vector<std::string> marked{photos().string(), "--masks", here("marks.yaml").string()};
  const Answer marks = ran(marked, "masks"), look = inspected(marked);
  EXPECT_TRUE(marks.exit == 2 && marks.codes.contains("BAD_CONFIG")) << marks.text;
  EXPECT_EQ(look.exit, 2);
  EXPECT_NE(look.text.find("marks.yaml:3:"), std::string::npos) << look.text;
  // A card measured in photos of twice the size.
  const Answer card = ran({photos().string(), "--grey-card", views[0].name + ":410,220,60,40"}, "export");
  EXPECT_TRUE(card.exit == 2 && card.codes.contains("GREY_CARD")) << card.text;
  EXPECT_FALSE(fs::exists(here("out")));
}

TEST_F(BroughtInputs, ReducedCopiesInADatasetAreNoPhotos) {
  const fs::path set = here("set");
  make_folders(set);
  fs::rename(photos(), set / "images");
  make_folders(set / "images_2");
  for (const View& v : views)
    write_ldr(set / "images_2" / v.name, in_8_bits(resized(read_srgb(set / "images" / v.name), kWidth / 2, kHeight / 2)), 95);
  expect({set.string()}, "ingest", 0, "REDUCED_COPIES", "reduced_copies");
}

TEST_F(BroughtInputs, LinkedFoldersAreFollowedAndBrokenLinksNamed) {
  make_folders(here("elsewhere"));
  fs::rename(photos() / views[0].name, here("elsewhere") / views[0].name);
  fs::create_directory_symlink(here("elsewhere"), photos() / "day2");
  fs::create_symlink(here("gone.jpg"), photos() / "z.jpg");
  expect({photos().string()}, "ingest", 0, "LINKS_BROKEN", "links_broken");
  const fs::path artifact = here("out/.cache/ingest") / current_key(here("out"), "ingest").value();
  const auto list = nlohmann::json::parse(read_file(artifact / "ingest/photos.json"));
  EXPECT_EQ(list["photos"].size(), views.size());
}

TEST_F(BroughtInputs, ResultsAmongThePhotosAreRefusedByWhateverLink) {
  fs::create_directory_symlink(photos(), here("link"));
  for (const char* command : {"run", "inspect"}) {
    const Outcome o = call({command, here("link").string(), "-o", (photos() / "out").string()});
    EXPECT_EQ(o.exit, 2) << o.text;
    EXPECT_TRUE(o.said("the output folder lies inside the folder of photos")) << o.text;
  }
}

// Network and FUSE file systems: SQLite needs shared mappings for COLMAP's database.
TEST_F(BroughtInputs, AFileSystemWithoutSharedMappingsGetsItsDatabaseElsewhere) {
  const std::vector<std::string> words{photos().string(), "--poses", true_poses()};
  make_folders(here("tmp"));
  setenv("VITRINE_TEST_NO_MMAP", here("").c_str(), 1);
  setenv("LD_PRELOAD", VITRINE_NO_MMAP, 1);
  setenv("TMPDIR", here("tmp").c_str(), 1);
  const Answer nowhere = ran(words, "sfm");
  unsetenv("TMPDIR");
  const Answer elsewhere = ran(words, "sfm");
  unsetenv("LD_PRELOAD");
  unsetenv("VITRINE_TEST_NO_MMAP");
  EXPECT_EQ(nowhere.exit, 6) << nowhere.text;
  EXPECT_TRUE(nowhere.codes.contains("NO_MMAP")) << nowhere.text;
  EXPECT_EQ(elsewhere.exit, 0) << elsewhere.text;
  EXPECT_TRUE(elsewhere.codes.contains("SCRATCH_ELSEWHERE")) << elsewhere.text;
}

TEST_F(BroughtInputs, APhotoOfAnotherKindThanItsNameIsLeftOutByTheTrueCause) {
  std::string heic(
      "\0\0\0\x18"
      "ftypheic\0\0\0\0mif1heic",
      24);
  write_file(photos() / views[0].name, heic + std::string(5000, 'x'));
  expect({photos().string()}, "ingest", 0, "PHOTOS_LEFT_OUT", "unreadable_photos");
  EXPECT_TRUE(call({"inspect", photos().string()}).said("HEIC"));
}

TEST_F(BroughtInputs, AlphaIsNamedAndServesAsMaskWhenAsked) {
  for (const View& v : views) {
    const Image8 rgb = read_srgb8(photos() / v.name);
    fs::remove(photos() / v.name);
    Image8 cut(kWidth, kHeight, 4, 0);
    for (int y = 60; y < 180; ++y)
      for (int x = 80; x < 240; ++x) {
        for (int c = 0; c < 3; ++c) cut.at(x, y, c) = rgb.at(x, y, c);
        cut.at(x, y, 3) = 255;
      }
    write_file(photos() / (v.stem() + ".tif"), test::tagged_tiff(cut, ""));
  }
  expect({photos().string()}, "ingest", 0, "PHOTO_ALPHA_NOT_USED", "alpha_not_used");
  const Answer asked = ran({photos().string(), "--masks", photos().string(), "--poses", true_poses(), "--set",
                            "masks.transparent.source=none", "--set", "masks.specular.source=none"},
                           "masks");
  EXPECT_EQ(asked.exit, 0) << asked.text;
  EXPECT_NE(asked.text.find("object 25.0 %"), std::string::npos) << asked.text;  // a quarter of the pixels is left
}

TEST_F(BroughtInputs, MasksThatThePosesNameAreNamedAndUsedWhenGiven) {
  for (const View& v : views) write_mask(here("masks") / (v.stem() + ".png"), 255);
  auto file = nlohmann::json::parse(read_file(true_poses()));
  for (size_t i = 0; i < views.size(); ++i) file["frames"][i]["mask_path"] = "masks/" + views[i].stem() + ".png";
  write_file(here("transforms.json"), file.dump());
  const std::string json = here("transforms.json").string();
  expect_poses(json, 0, "POSES_NAME_MASKS");
  const std::vector<std::string> with_masks{
      photos().string(),           "--poses", json, "--masks", json, "--set", "masks.transparent.source=none", "--set",
      "masks.specular.source=none"};
  const Answer asked = ran(with_masks, "masks");
  EXPECT_EQ(asked.exit, 0) << asked.text;
  EXPECT_FALSE(asked.codes.contains("POSES_NAME_MASKS")) << asked.text;
  EXPECT_NE(asked.text.find("object 12.5 %"), std::string::npos) << asked.text;  // 120 x 80 of 320 x 240 pixels
  // The content of the masks counts for the cache, not only that of the list.
  for (const View& v : views) write_ldr(here("masks") / (v.stem() + ".png"), Image8(kWidth, kHeight, 1, uint8_t{255}));
  EXPECT_EQ(ran(with_masks, "masks").text.find("object 12.5 %"), std::string::npos);
}

TEST_F(BroughtInputs, PhotosOfSeveralColourSpacesAreNamed) {
  // cICP: primaries of Display P3 (12), curve of sRGB (13), RGB, full range.
  const std::string cicp("\0\0\0\4cICP\x0c\x0d\0\1", 12);
  const std::string png = png_bytes(read_srgb8(photos() / views[0].name));
  const size_t behind_header = 8 + 25;
  fs::remove(photos() / views[0].name);
  write_file(photos() / (views[0].stem() + ".png"),
             png.substr(0, behind_header) + cicp + crc32_of(cicp.substr(4)) + png.substr(behind_header));
  expect({photos().string()}, "ingest", 0, "PHOTO_PROFILES_DIFFER", "mixed_profiles");
}

}  // namespace
}  // namespace vitrine
