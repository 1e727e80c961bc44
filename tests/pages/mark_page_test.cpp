// mark.html in headless Chromium, from file://: what a person draws with real input events is what the file says, and what the
// masks stage takes.
#include <gtest/gtest.h>

#include "core/intake/masks/photo_marks.h"
#include "core/scene/camera/mask_class.h"
#include "core/scene/image/image.h"
#include "core/scene/image/ldr.h"
#include "stages/mark/mark.h"
#include "stages/page_text.h"
#include "tests/pages/in_chromium.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_photos.h"

namespace vitrine {
namespace {

using nlohmann::json;

struct ReadMark {
  std::string photo, kind, thing;
  std::vector<Vec2d> corners;
  bool box = false;
};

// What the program understands of a file, or of the text in the page.
std::vector<ReadMark> marks_of(const std::string& text) {
  YamlReader in(parse_yaml(text, "marks.yaml"));
  std::vector<ReadMark> marks;
  for (const YamlNode& node : in.root().find("marks")->items) {
    const auto word = [&](const char* key) { return node.find(key) != nullptr ? node.find(key)->text : std::string(); };
    ReadMark mark{.photo = word("photo"), .kind = word("class"), .thing = word("thing"), .corners = {}};
    if (const auto region = marked_region(in, node)) mark.corners = region->corners, mark.box = region->box;
    marks.push_back(std::move(mark));
  }
  return marks;
}

void expect_corners(const ReadMark& mark, const std::vector<Vec2d>& corners, double within) {
  ASSERT_EQ(mark.corners.size(), corners.size()) << mark.photo;
  for (size_t i = 0; i < corners.size(); ++i) {
    EXPECT_NEAR(mark.corners[i].x, corners[i].x, within) << mark.photo << " " << i;
    EXPECT_NEAR(mark.corners[i].y, corners[i].y, within) << mark.photo << " " << i;
  }
}

Image8 rectangle(int width, int height, int left, int top, int right, int bottom) {
  Image8 image(width, height, 3, 0);
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) std::fill_n(image.pixel(x, y), 3, uint8_t(255));
  return image;
}

std::string page_of_build() { return read_file(empty_page_path("mark")); }

using MarkPage = InChromium;

TEST_F(MarkPage, SavesWhatAPersonDraws) {
  const TemporaryFolder folder;
  const fs::path photos = folder.path() / "photos", out = pictures("mark");
  make_folders(photos);
  write_ldr(photos / "a.png", rectangle(2400, 1600, 600, 400, 1800, 1000));
  write_ldr(photos / "b.jpg", test::stored_as(rectangle(800, 1200, 200, 300, 600, 900), 6));
  test::add_exif(photos / "b.jpg", test::exif_bytes({{0x112, 's', 6}}, {}));
  write_ldr(photos / "c.png", Image8(1200, 800, 3, 30));
  write_file(folder.path() / "by hand.yaml", R"(# by hand
size: [1200, 800]   # of a, reduced
marks:
- {photo: a.png, class: transparent, thing: "the # case",
   box: [300, 200, 900, 500]}
- photo: 'b.jpg'
  class: transparent
  thing: 'the # case'
  size: [800, 1200]
  polygon:
    - [200, 300]   # left top
    - [600, 300]
    - [600, 900]
- photo: c
  class: specular
  polygon: [[1, 2],
            [30.5, 2.2], [30, 40]]
- photo: gone.jpg
  class: specular
  box: [1, 2, 3, 4]
  size: [10, 10]
)");
  write_file(folder.path() / "none.yaml", "size: [1, 2]\nmarks:\n  - &a {photo: a.png}\n");
  test::RecordingContext context({{"photos", photos}});
  write_mark(page_of_build(), {}, context);
  const json r =
      answer(run_script({"mark_page.mjs", (context.output() / "mark.html").string(), (folder.path() / "by hand.yaml").string(),
                         (folder.path() / "none.yaml").string(), out.string()}));
  ASSERT_FALSE(r.empty());
  EXPECT_TRUE(r["messages"].empty()) << r["messages"];
  std::set<std::string> classes, all;
  for (const std::string word : r["classes"]) classes.insert(word);
  for (MaskClass kind : kMaskClasses) all.insert(std::string(name(kind)));
  EXPECT_EQ(classes, all);

  // Half a pixel of the screen, in pixels of the photo.
  const double half = 0.5 / r["zoom"].get<double>();
  const std::vector<Vec2d> in_a{{600, 400}, {1800, 400}, {1800, 1000}, {600, 1000}};
  const std::vector<ReadMark> drawn = marks_of(r["drawn"]);
  ASSERT_EQ(drawn.size(), 1u);
  EXPECT_EQ(drawn[0].kind, "transparent");
  EXPECT_FALSE(drawn[0].box);
  expect_corners(drawn[0], in_a, half);
  EXPECT_TRUE(marks_of(r["undone"]).empty());
  EXPECT_EQ(r["redone"], r["drawn"]);
  const std::vector<ReadMark> boxed = marks_of(r["box"]);
  ASSERT_EQ(boxed.size(), 2u);
  EXPECT_TRUE(boxed[1].box);
  expect_corners(boxed[1], {{200, 300}, {600, 300}, {600, 900}, {200, 900}}, 1);  // larger on the screen than half
  const double zoomed = r["zoomed"][1];
  EXPECT_GT(zoomed, 5 * r["zoom"].get<double>());
  for (const double off : r["stayed"]) EXPECT_LT(std::abs(off), 7);  // wheels have whole pixels, six times as large
  const Vec2d moved = marks_of(r["zoomed"][0])[0].corners[0];
  EXPECT_NEAR(moved.x, drawn[0].corners[0].x + 60 / zoomed, 0.2);
  EXPECT_NEAR(moved.y, drawn[0].corners[0].y + 30 / zoomed, 0.2);
  EXPECT_NEAR(r["nudged"][0].get<double>(), 1 / r["nudged"][1].get<double>(), 0.11);
  EXPECT_EQ(r["inserted"], json({4, 5}));
  EXPECT_EQ(r["deleted"], json({2, 1, 2}));

  const double touched[3][2] = {{200, 200}, {700, 220}, {400, 600}};
  ASSERT_EQ(r["touched"].size(), 3u);
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 2; ++k) EXPECT_NEAR(r["touched"][i][k].get<double>(), touched[i][k], 1);  // fingers have whole pixels
  EXPECT_NEAR(r["pinched"][1].get<double>() / r["pinched"][0].get<double>(), 3, 0.05);
  EXPECT_EQ(r["pinched"][2], 3);  // two fingers drew nothing
  EXPECT_EQ(r["crossed"][0], json({"The outline in a.png crosses itself."}));
  EXPECT_EQ(r["crossed"][1].get<std::string>().find("A run would refuse this: "), 0u) << r["crossed"];
  EXPECT_EQ(r["crossed"][2], false);

  EXPECT_EQ(r["restored"][0], r["restored"][1]);
  EXPECT_NE(r["restored"][2].get<std::string>().find("did not save is back"), std::string::npos) << r["restored"][2];
  EXPECT_EQ(r["restored"][3], json({nullptr, 0}));
  EXPECT_EQ(r["kept"][0].size(), 2u);
  EXPECT_EQ(r["kept"][0], r["kept"][1]);
  EXPECT_EQ(r["dialogs"], json({1, 0}));

  EXPECT_NE(r["refused"].get<std::string>().find("none.yaml is no file of marks: line 3: "), std::string::npos) << r["refused"];
  const std::vector<ReadMark> given = marks_of(read_file(folder.path() / "by hand.yaml")), opened = marks_of(r["opened"][0]);
  ASSERT_EQ(opened.size(), given.size());
  for (size_t i = 0; i < given.size(); ++i) {
    EXPECT_EQ(opened[i].kind, given[i].kind);
    EXPECT_EQ(opened[i].thing, given[i].thing);
    EXPECT_EQ(opened[i].box, given[i].box);
    std::vector<Vec2d> corners = given[i].corners;
    if (i == 0)
      for (Vec2d& p : corners) p = 2.0 * p;  // drawn on a smaller copy
    expect_corners(opened[i], corners, 1e-9);
  }
  EXPECT_EQ(opened[2].photo, "c.png");
  EXPECT_EQ(opened[3].photo, "gone.jpg");
  EXPECT_NE(r["opened"][1].get<std::string>().find("photos that are not here (gone.jpg) stay in the file"), std::string::npos);
  EXPECT_EQ(r["shown"], json({"b.jpg", "c.png", "b.jpg"}));
  EXPECT_EQ(read_file(out / "marks.yaml"), r["opened"][0].get<std::string>());
  EXPECT_EQ(r["again"], r["opened"][0]);
}

// Outlines that somebody read off three photos of the sample, drawn by the mouse; the masks that the stage carries to all photos
// against the true ones. Every fourth photo is enough for both, and saves a minute of matching.
TEST_F(MarkPage, MarksOfThreePhotosGiveTheMasksOfAll) {
  const TemporaryFolder folder;
  const fs::path sample = fs::path(VITRINE_SOURCE_DIR) / "sample_data/cabinet", out = pictures("mark_sample");
  const fs::path photos = folder.path() / "photos";
  make_folders(photos);
  for (int i = 0; i < 36; i += 4) {
    const std::string name = fmt::format("img_{:04}.jpg", i);
    fs::copy_file(sample / "photos" / name, photos / name);
  }
  test::RecordingContext context({{"photos", photos}});
  write_mark(page_of_build(), {}, context);
  EXPECT_LT(fs::file_size(context.output() / "mark.html"), 1u << 20);
  write_file(folder.path() / "outlines.json", R"([
  {"class": "transparent", "photos": {
    "img_0012.jpg": [[248.5, 59], [313, 27.5], [463, 33.5], [449, 215], [418, 286], [265.5, 259]],
    "img_0016.jpg": [[255.5, 74], [396, 45.5], [562, 80], [517.5, 300], [400, 392], [265, 296]],
    "img_0020.jpg": [[329, 319], [139, 358], [84, 107], [89, 53], [274, 38], [328, 82]]}},
  {"class": "specular", "photos": {
    "img_0012.jpg": [[100, 339], [106, 357], [124, 377], [142, 382], [160, 386], [176, 394], [207, 403], [238, 399], [264, 380],
      [277, 357], [279.5, 336], [274, 318], [259, 300], [241, 290], [220, 286], [194, 290], [178.5, 305], [168, 326], [158, 348],
      [140, 357], [122, 349], [111, 337.5], [105, 335]],
    "img_0016.jpg": [[228, 202], [230, 215], [243, 230], [264, 237], [285, 235.5], [305, 222.5], [316, 207], [317, 194],
      [308, 178.5], [295, 168], [279.5, 161.5], [259, 162], [243, 173], [231, 189]],
    "img_0020.jpg": [[416, 243], [412.5, 264], [422, 285], [440, 301], [461, 309.5], [484, 309.5], [505, 301], [520, 287],
      [530.5, 279.5], [549, 270], [561.5, 256], [573.5, 240.5], [572, 233], [563, 233], [551, 243], [536, 252], [523, 248.5],
      [516.5, 238], [502, 228], [492, 220], [473.5, 216], [450, 222.5], [429.5, 230]]}}])");
  const json r = answer(run_script(
      {"mark_sample.mjs", (context.output() / "mark.html").string(), (folder.path() / "outlines.json").string(), out.string()}));
  ASSERT_FALSE(r.empty());
  EXPECT_TRUE(r["messages"].empty()) << r["messages"];
  EXPECT_EQ(r["states"], json({"well", "well"}));
  EXPECT_EQ(r["clicks"], 93);  // buttons and photos too

  const fs::path run = folder.path() / "run";
  const Said masks =
      run_in(folder.path(), {std::string(VITRINE_BIN_DIR) + "/vitrine", "run", photos.string(), "-o", run.string(), "--poses",
                             (sample / "truth/transforms.json").string(), "--masks", (out / "marks.yaml").string(), "--preset",
                             "preview", "--to", "masks", "--no-progress"});
  ASSERT_EQ(masks.code, 0) << masks.out;
  for (const auto& [kind, least] : {std::pair{"transparent", 0.91}, std::pair{"specular", 0.94}}) {  // measured 0.930, 0.960
    size_t common = 0, either = 0;
    for (const auto& e : fs::directory_iterator(run / "masks" / kind)) {
      const Image8 ours = read_grey8(e.path()), truth = read_grey8(sample / "truth/mask" / kind / e.path().filename());
      ASSERT_EQ(truth.data().size(), ours.data().size());
      for (size_t i = 0; i < truth.data().size(); ++i) {
        const bool a = truth.data()[i] >= 128, b = ours.data()[i] >= 128;
        common += a && b, either += a || b;
      }
    }
    const double iou = double(common) / double(either);
    RecordProperty(kind, std::to_string(iou));
    EXPECT_GT(iou, least) << kind;
  }

  // The page of that run.
  const fs::path of_run = folder.path() / "of_run.html";
  const Said marked =
      run_in(folder.path(), {std::string(VITRINE_BIN_DIR) + "/vitrine", "mark", run.string(), "-o", of_run.string(), "-q"});
  ASSERT_EQ(marked.code, 0) << marked.out;
  const json seen = answer(run_script({"mark_run.mjs", of_run.string(), out.string()}));
  ASSERT_FALSE(seen.empty());
  EXPECT_TRUE(seen["messages"].empty()) << seen["messages"];
  EXPECT_EQ(seen["states"], json({"well", "well"}));
  EXPECT_EQ(seen["sources"], "What the run took in every photo: metal or mirror from marks; glass from marks.");
  EXPECT_GT(seen["masks"][0], 1);
  EXPECT_EQ(seen["masks"][0], seen["masks"][1]);
  EXPECT_NE(seen["first"].get<std::string>().find("Marked in one photo. It needs a second one"), std::string::npos)
      << seen["first"];
  EXPECT_NE(seen["second"].get<std::string>().find("2 photos that look from the same side"), std::string::npos) << seen["second"];
  EXPECT_EQ(seen["looser"], "enough");
}

}  // namespace
}  // namespace vitrine
