// What the program behind `vitrine mark` puts into a page. How the page draws: tests/pages.
#include "stages/mark/mark.h"

#include <gtest/gtest.h>

#include "core/foundation/base/json.h"
#include "core/intake/masks/photo_marks.h"
#include "core/intake/poses/photo_orientation.h"
#include "core/scene/camera/view_masks.h"
#include "core/scene/image/ldr.h"
#include "stages/page_text.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_capture.h"
#include "tests/support/tiny_photos.h"

namespace vitrine {
namespace {

using nlohmann::json;
using test::RecordingContext;

constexpr const char* kEmptyPage = "<html><!-- the data --></html>";

std::string bytes_of_base64(std::string_view text) {
  const std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  unsigned bits = 0, held = 0;
  for (const char c : text) {
    const size_t value = letters.find(c);
    if (value == std::string_view::npos) break;
    held = held << 6 | unsigned(value);
    if ((bits += 6) >= 8) out += char(held >> (bits -= 8) & 255);
  }
  return out;
}

class MarkStage : public testing::Test {
 protected:
  fs::path photos() const { return folder.path() / "photos"; }
  void add(const std::string& name, const Image8& image, int orientation = 1) const {
    const fs::path file = photos() / name;
    make_folders(file.parent_path());
    write_ldr(file, test::stored_as(image, orientation));
    if (orientation != 1) test::add_exif(file, test::exif_bytes({{0x112, 's', unsigned(orientation)}}, {}));
  }
  std::string page(RecordingContext& context, const MarkConfig& config = {}) const {
    write_mark(kEmptyPage, config, context);
    return read_file(context.output() / "mark.html");
  }
  std::string page(const MarkConfig& config = {}) const {
    RecordingContext context({{"photos", photos()}});
    return page(context, config);
  }
  static json part(const std::string& page, const std::string& id) {
    const std::string mark = "id=\"" + id + "\">";
    const size_t begin = page.find(mark) + mark.size();
    return json::parse(page.substr(begin, page.find("</script>", begin) - begin));
  }
  Image8 picture(const json& uri) const {
    const std::string text = uri, head = "data:image/jpeg;base64,";
    EXPECT_TRUE(text.starts_with(head));
    write_file(folder.path() / "picture.jpg", bytes_of_base64(text.substr(head.size())));
    return read_srgb8(folder.path() / "picture.jpg");
  }
  TemporaryFolder folder;
};

TEST_F(MarkStage, PhotosAreUprightAndSayTheSizeThatMarksCount) {
  const Image8 shown = test::blocks();  // 48 x 32
  add("a.jpg", shown);
  add("b.jpg", shown, 6);
  add("c.jpg", test::turned_clockwise(shown), 8);
  const std::string text = page();
  const json scene = part(text, "scene"), pictures = part(text, "photos"), small = part(text, "small");
  ASSERT_EQ(scene["photos"].size(), 3u);
  ASSERT_EQ(pictures.size(), 3u);
  ASSERT_EQ(small.size(), 3u);
  const int sizes[3][2] = {{48, 32}, {48, 32}, {32, 48}};
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(scene["photos"][i]["width"], sizes[i][0]) << i;
    EXPECT_EQ(scene["photos"][i]["height"], sizes[i][1]) << i;
    const Image8 here = picture(pictures[i]), truth = i == 2 ? test::turned_clockwise(shown) : shown;
    ASSERT_EQ(here.width(), sizes[i][0]);
    for (int y = 8; y < truth.height(); y += 16)
      for (int x = 8; x < truth.width(); x += 16)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(here.at(x, y, c), truth.at(x, y, c), 12) << i << " " << x << " " << y;
  }
  EXPECT_FALSE(scene["has_cameras"]);
  EXPECT_TRUE(scene["marks"].is_null());
  EXPECT_EQ(scene["classes"], json({"object", "transparent", "specular", "ignore"}));
}

TEST_F(MarkStage, LargePhotosAreReducedAndKeepTheirOwnSizeForMarks) {
  add("large.jpg", Image8(1300, 700, 3, 90));
  add("small.jpg", test::blocks());
  const std::string text = page({.photo_side = 640});
  const json scene = part(text, "scene"), pictures = part(text, "photos");
  EXPECT_EQ(scene["photos"][0]["width"], 1300);
  const Image8 large = picture(pictures[0]), small = picture(pictures[1]);
  EXPECT_EQ(large.width(), 640);
  EXPECT_EQ(large.height(), 345);
  EXPECT_EQ(small.width(), 48);
}

TEST_F(MarkStage, ManyPhotosAreSmaller) {
  const std::vector<std::pair<int, int>> sixty(60, {6000, 4000}), thousand(1000, {6000, 4000});
  EXPECT_EQ(side_of_page(sixty, 1600, 120), 1600);
  const int side = side_of_page(std::vector<std::pair<int, int>>(200, {6000, 4000}), 1600, 120);
  EXPECT_NEAR(side, 949, 16);  // 200 side^2 2 / 3 = 120e6
  EXPECT_EQ(side_of_page(thousand, 1600, 120), kLeastSide);
  EXPECT_EQ(side_of_page({{300, 200}}, 1600, 120), 1600);
}

TEST_F(MarkStage, NamesStayInTheirElement) {
  add("</script><b>\"'\u00fc.jpg", test::blocks());
  const std::string text = page({.command = "vitrine run '</script>'"});
  EXPECT_EQ(text.find("</script><b>"), std::string::npos);
  const json scene = part(text, "scene");
  EXPECT_EQ(scene["photos"][0]["name"], "</script><b>\"'\u00fc.jpg");
  EXPECT_EQ(scene["command"], "vitrine run '</script>'");
}

TEST_F(MarkStage, PhotosThatCannotBeReadAreLeftOutByName) {
  add("a.jpg", test::blocks());
  add("c.jpg", test::blocks());
  write_file(photos() / "b.jpg", "");
  write_file(photos() / "d.jpg", read_file(photos() / "a.jpg").substr(0, 300));
  RecordingContext context({{"photos", photos()}});
  const json scene = part(page(context), "scene");
  ASSERT_EQ(scene["photos"].size(), 2u);
  ASSERT_EQ(scene["left_out"].size(), 2u);
  EXPECT_EQ(scene["left_out"][0]["name"], "b.jpg");
  EXPECT_FALSE(scene["left_out"][1]["why"].get<std::string>().empty());
  const std::string& told = context.warnings["PHOTOS_LEFT_OUT"];
  EXPECT_NE(told.find("2 photos are left out, which no run can use either:\n         b.jpg: "), std::string::npos) << told;
  fs::remove(photos() / "a.jpg"), fs::remove(photos() / "c.jpg");
  RecordingContext none({{"photos", photos()}});
  const Error e = error_of([&] { page(none); });
  EXPECT_EQ(e.kind(), ErrorKind::Input);
  EXPECT_EQ(e.message(), "none of the photos can be read");
}

TEST_F(MarkStage, AFolderWithoutPhotosIsRefused) {
  make_folders(photos());
  const Error e = error_of([&] { page(); });
  EXPECT_EQ(e.kind(), ErrorKind::Input);
  EXPECT_EQ(e.detail().code, "NO_PHOTOS");
}

TEST_F(MarkStage, MarksOfAFileComeAlongAndMistakesOfItAreShownAtTheirLine) {
  add("a.jpg", test::blocks());
  const fs::path file = folder.path() / "my marks.yaml";
  write_file(file, "size: [48, 32]\nmarks:\n  - {photo: a.jpg, class: transparent, thing: '</script>', box: [1, 2, 30.5, 20]}\n");
  RecordingContext context({{"photos", photos()}, {"marks", file}});
  const json scene = part(page(context), "scene");
  EXPECT_EQ(scene["marks_name"], "my marks.yaml");
  EXPECT_EQ(scene["marks"]["size"], json({"48", "32"}));
  EXPECT_EQ(scene["marks"]["marks"][0]["thing"], "</script>");
  EXPECT_EQ(scene["marks"]["marks"][0]["box"][2], "30.5");
  write_file(file, "marks:\n  - {photo: a.jpg, class: [}\n");
  RecordingContext broken({{"photos", photos()}, {"marks", file}});
  const Error e = error_of([&] { page(broken); });
  EXPECT_EQ(e.kind(), ErrorKind::Usage);
  EXPECT_NE(std::string(e.what()).find("my marks.yaml:2:"), std::string::npos) << e.what();
}

TEST_F(MarkStage, OfARunCamerasAndMasksComeAlong) {
  const test::TinyCapture capture;
  const fs::path masks = folder.path() / "artifact";
  for (size_t v = 0; v < capture.views.size(); ++v) {
    add(capture.views[v].name, Image8(2 * test::TinyCapture::kWidth, 2 * test::TinyCapture::kHeight, 3, 90));
    Image8 mask(test::TinyCapture::kWidth, test::TinyCapture::kHeight, 1, 0);
    for (int x = 10; x < 20; ++x) mask.at(x, 3) = 255;
    const fs::path path = view_mask_path(masks, MaskClass::Transparent, capture.views[v]);
    make_folders(path.parent_path());
    write_ldr(path, mask);
  }
  add("without_camera.png", test::blocks());
  write_mask_origins(masks, {{MaskClass::Transparent, {"boxes", "marked", true}}});
  RecordingContext context({{"photos", photos()}, {"sfm", capture.sfm()}, {"masks", masks}});
  const json scene = part(page(context), "scene");
  EXPECT_TRUE(scene["has_cameras"]);
  EXPECT_EQ(scene["most_one_sided"], kMostOneSided);
  EXPECT_EQ(scene["mask_sources"]["transparent"], "boxes");
  ASSERT_EQ(scene["photos"].size(), 9u);
  const json &photo = scene["photos"][0], &other = scene["photos"][8];
  EXPECT_EQ(photo["width"], 2 * test::TinyCapture::kWidth);
  EXPECT_EQ(photo["masks"]["width"], test::TinyCapture::kWidth);
  EXPECT_EQ(photo["masks"]["runs"]["transparent"], json({3 * 64 + 10, 10, 64 * 48 - 3 * 64 - 20}));
  EXPECT_EQ(photo["masks"]["runs"].size(), 1u);
  const Vec3d eye = capture.views[0].centre_in_world();
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(photo["camera"]["eye"][c].get<double>(), eye[c], 1e-9);
  EXPECT_NEAR(photo["camera"]["across"].get<double>(), 64.0 / 70, 1e-9);
  EXPECT_FALSE(other.contains("camera"));
  // A run that ended behind sfm.
  RecordingContext early({{"photos", photos()}, {"sfm", capture.sfm()}});
  const json before = part(page(early), "scene");
  EXPECT_TRUE(before["photos"][0].contains("camera"));
  EXPECT_FALSE(before["photos"][0].contains("masks"));
}

// Masks belong to the undistorted photo; the page shows them on the one that was taken.
TEST_F(MarkStage, MasksAreBentAsTheLensBends) {
  const ColmapCamera lens{1, 2, 80, 60, {70, 40, 30, -0.15}};
  const Undistortion u = undistortion(lens);
  View view;
  view.name = "a.png";
  view.intrinsics = u.target;
  view.cam_from_world = test::looking_at({1, 0, 0.2}, {0, 0, 0});
  ColmapModel model;
  model.cameras.push_back(colmap_pinhole(1, u.target));
  model.images.push_back({1, quaternion(view.cam_from_world.rotation), view.cam_from_world.translation, 1, view.name, {}});
  const fs::path sfm = folder.path() / "sfm";
  write_colmap_model(sfm / "sparse/0", model, ColmapFormat::Binary);
  write_gains(sfm / "sfm/gains.json", {{"a.png", {1, 1, 1}}});
  write_scene_info(sfm / "scene.json", {});
  write_file(sfm / "sfm/lenses.json", R"({"cameras": [{"photographed":
      {"id": 1, "model": "SIMPLE_RADIAL", "width": 80, "height": 60, "params": [70, 40, 30, -0.15]}}],
      "without_camera": ["lost.png"], "camera_flash": true, "cut_out": true})");
  const PhotoLenses lenses = read_photo_lenses(sfm, load_view_set(sfm));
  EXPECT_EQ(lenses.without_camera, std::vector<std::string>{"lost.png"});
  EXPECT_TRUE(lenses.camera_flash);
  EXPECT_TRUE(lenses.cut_out);
  // A strip along the right border of the undistorted photo.
  const int w = u.target.width, h = u.target.height;
  Image8 mask(w, h, 1, 0);
  for (int y = 0; y < h; ++y)
    for (int x = w - 4; x < w; ++x) mask.at(x, y) = 255;
  const fs::path artifact = folder.path() / "artifact", path = view_mask_path(artifact, MaskClass::Specular, view);
  make_folders(path.parent_path());
  write_ldr(path, mask);
  write_mask_origins(artifact, {{MaskClass::Specular, {"files", "given", false}}});
  const RunResults results = read_run_results(sfm, artifact);
  const RunPhoto& photo = results.photos.at("a.png");
  ASSERT_EQ(photo.mask_width, 80);
  ASSERT_TRUE(photo.masks[size_t(MaskClass::Specular)]);
  std::vector<bool> inside;
  bool now = false;
  for (const int run : *photo.masks[size_t(MaskClass::Specular)]) inside.insert(inside.end(), size_t(run), now), now = !now;
  ASSERT_EQ(inside.size(), 80u * 60u);
  size_t found = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x) {
      const auto at = undistorted(Vec2d{x + 0.5, y + 0.5}, u);
      const bool belongs = at && at->x >= w - 4 && at->x < w && at->y >= 0 && at->y < h;
      EXPECT_EQ(inside[size_t(y * 80 + x)], belongs) << x << " " << y;
      found += belongs;
    }
  EXPECT_GT(found, 100u);
}

TEST_F(MarkStage, SameBytesForAnyNumberOfThreads) {
  for (const char* name : {"a.jpg", "b.jpg", "c.jpg"}) add(name, test::blocks());
  std::vector<std::string> pages;
  for (const int threads : {1, 3}) {
    set_thread_limit(threads);
    pages.push_back(page());
  }
  set_thread_limit(0);
  EXPECT_EQ(pages[0], pages[1]);
}

TEST_F(MarkStage, APageOfAnotherBuildIsRefused) {
  add("a.jpg", test::blocks());
  RecordingContext context({{"photos", photos()}});
  const Error e = error_of([&] { write_mark("<html></html>", {}, context); });
  EXPECT_EQ(e.kind(), ErrorKind::Dependency);
  EXPECT_EQ(e.detail().code, "NO_PAGE");
}

}  // namespace
}  // namespace vitrine
