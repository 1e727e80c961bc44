// The file of edits: what is read, and where each mistake is shown.
#include "stages/edit/edit.h"

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

std::vector<View> two_views() {
  std::vector<View> views(2);
  views[0].name = "left/a.jpg", views[1].name = "b.jpg";
  for (View& v : views) v.intrinsics = {400, 300, 300, 300, 200, 150};
  return views;
}

std::vector<Edit> read(const std::string& text) {
  const TemporaryFolder folder;
  write_file(folder.path() / "edits.yaml", text);
  return read_edits(folder.path() / "edits.yaml", two_views());
}

TEST(EditList, EveryKeyIsRead) {
  const auto edits = read(R"(edits:
  - name: gold
    select:
      class: specular
      box: [-1, -2, -3, 1, 2, 3]
      marks:
        - {photo: left/a, box: [10, 20, 30, 40]}
        - {photo: b.jpg, polygon: [[0, 0], [800, 0], [0, 600]], size: [800, 600]}
      component: 2
      except: {class: transparent}
    set: {tint: 0.5, f0: [1, 0.8, 0.3], roughness: 0.2, k_s: 0.1, tau: 0}
  - select: all
    set: {tint: [2, 1, 0]}
  - select: {component: 1}
    delete: true
  - select: {object: copper kettle}
    set: {tint: 2}
)");
  ASSERT_EQ(edits.size(), 4u);
  EXPECT_EQ(edits[3].select.object, "copper kettle");
  EXPECT_FALSE(edits[3].select.geometric());
  const Selector& s = edits[0].select;
  EXPECT_EQ(edits[0].name, "gold");
  EXPECT_TRUE(edits[0].where.ends_with("edits.yaml:2:5")) << edits[0].where;
  EXPECT_EQ(s.kind, MaskClass::Specular);
  EXPECT_EQ(s.box->low, (Vec3d{-1, -2, -3}));
  EXPECT_EQ(s.box->high, (Vec3d{1, 2, 3}));
  ASSERT_EQ(s.marks.size(), 2u);
  EXPECT_EQ(s.marks[0].view, 0u);
  EXPECT_EQ(s.marks[0].polygon[2].x, 30);
  EXPECT_EQ(s.marks[0].polygon[2].y, 40);
  EXPECT_EQ(s.marks[1].polygon[1].x, 400) << "scaled to the photo";
  EXPECT_EQ(s.component, 2u);
  EXPECT_EQ(s.except.at(0).kind, MaskClass::Transparent);
  EXPECT_EQ(edits[0].set.tint, (Vec3f{0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(edits[0].set.f0, (Vec3f{1, 0.8f, 0.3f}));
  EXPECT_EQ(edits[0].set.roughness, 0.2f);
  EXPECT_EQ(edits[0].set.specular_weight, 0.1f);
  EXPECT_EQ(edits[0].set.transmission, 0.f);
  EXPECT_EQ(edits[1].name, "edit 2");
  EXPECT_EQ(edits[1].set.tint, (Vec3f{2, 1, 0}));
  EXPECT_FALSE(edits[1].remove);
  EXPECT_TRUE(edits[2].remove);
}

TEST(EditList, OfTheSampleIsRead) {
  std::vector<View> views;
  for (const char* name : {"img_0002.jpg", "img_0017.jpg", "img_0020.jpg", "img_0035.jpg"})
    views.push_back({.name = name, .intrinsics = {640, 480, 500, 500, 320, 240}, .cam_from_world = {}});
  const auto edits = read_edits(fs::path(VITRINE_SOURCE_DIR) / "sample_data/cabinet/edits.yaml", views);
  ASSERT_EQ(edits.size(), 2u);
  EXPECT_EQ(edits[0].select.marks.size(), 4u);
  EXPECT_TRUE(edits[1].remove);
}

TEST(EditList, EveryMistakeIsShownAtItsLine) {
  const std::string set = "\n    set: {tint: 1}";
  const struct {
    std::string text, where, says;
  } cases[] = {
      {"", ":1:1", "edits must be a list"},
      {"edits: []", ":1:8", "edits must be a list"},
      {"edit: []", ":1:1", "did you mean 'edits'"},
      {"edits:\n  - select: {box: [0, 0, 0, 1, 1, 1]}\n    sett: {tint: 1}", ":3:5", "did you mean 'set'"},
      {"edits:\n  - name: [gold]\n    select: all" + set, ":2:11", "a word or a sentence"},
      {"edits:\n  - set: {tint: 1}", ":2:5", "an edit needs 'select'"},
      {"edits:\n  - select: all", ":2:5", "either 'set' or 'delete: true'"},
      {"edits:\n  - select: all\n    delete: true" + set, ":2:5", "either 'set' or 'delete: true'"},
      {"edits:\n  - select: all\n    delete: no", ":3:13", "can only be 'delete: true'"},
      {"edits:\n  - select: everything" + set, ":2:13", "'all', or a map"},
      {"edits:\n  - select: {}" + set, ":2:13", "selects nothing"},
      {"edits:\n  - select: {klass: specular}" + set, ":2:14", "did you mean 'class'"},
      {"edits:\n  - select: {class: mirror}" + set, ":2:21", "'mirror' is no class"},
      {"edits:\n  - select: {box: [0, 0, 0, 1, 1]}" + set, ":2:19", "[x0, y0, z0, x1, y1, z1]"},
      {"edits:\n  - select: {box: [0, 0, 2, 1, 1, 1]}" + set, ":2:19", "z0 than z1"},
      {"edits:\n  - select: {box: [0, 0, .inf, 1, 1, 1]}" + set, ":2:26", "expected a number"},
      {"edits:\n  - select: {component: 0}" + set, ":2:25", "numbered from 1"},
      {"edits:\n  - select: {component: 1.5}" + set, ":2:25", "numbered from 1"},
      {"edits:\n  - select: {except: {except: {class: object}}}" + set, ":2:23", "unknown key 'except'"},
      {"edits:\n  - select: {marks: []}" + set, ":2:21", "list of marks"},
      {"edits:\n  - select: {marks: [{box: [0, 0, 1, 1]}]}" + set, ":2:22", "names its photo"},
      {"edits:\n  - select: {marks: [{photo: c.jpg, box: [0, 0, 1, 1]}]}" + set, ":2:30", "did you mean 'b.jpg'"},
      {"edits:\n  - select: {marks: [{photo: b.jpg}]}" + set, ":2:22", "a box or a polygon"},
      {"edits:\n  - select: {marks: [{photo: b.jpg, box: [0, 0, 500, 1]}]}" + set, ":2:22", "outside a photo of 400x300"},
      {"edits:\n  - select: {marks: [{photo: b.jpg, box: [9, 0, 5, 1]}]}" + set, ":2:42", "left must be smaller"},
      {"edits:\n  - select: {marks: [{photo: b.jpg, polygon: [[0, 0], [1, 1]]}]}" + set, ":2:46", "three corners"},
      {"edits:\n  - select: {marks: [{photo: b.jpg, size: [300, 400], box: [0, 0, 5, 1]}]}" + set, ":2:43", "400x300"},
      {"edits:\n  - select: all\n    set: {}", ":3:10", "nothing is set"},
      {"edits:\n  - select: all\n    set: {rougness: 0.2}", ":3:11", "did you mean 'roughness'"},
      {"edits:\n  - select: all\n    set: {roughness: 1.2}", ":3:22", "between 0 and 1, got 1.2"},
      {"edits:\n  - select: all\n    set: {k_s: -0.1}", ":3:16", "between 0 and 1, got -0.1"},
      {"edits:\n  - select: all\n    set: {tau: much}", ":3:16", "expected a number"},
      {"edits:\n  - select: all\n    set: {tint: [1, 2]}", ":3:17", "[red, green, blue]"},
      {"edits:\n  - select: all\n    set: {f0: [1, 2, 0]}", ":3:15", "between 0 and 1, got 2"},
      {"edits:\n  - select: all\n    set: {tint: [1, 20, 0]}", ":3:17", "between 0 and 10, got 20"},
      {"edits:\n  - select: all\n    set: {brushed: [1, 0]}", ":3:20", "a direction [x, y, z]"},
      {"edits:\n  - select: all\n    set: {turned: [0, 0, 0]}", ":3:19", "no direction"},
      {"edits:\n  - select: all\n    set: {anisotropy: 0.5}", ":3:23", "direction of the marks"},
      {"edits:\n  - select: all\n    set: {brushed: [1, 0, 0], turned: [0, 0, 1]}", ":3:39", "either 'brushed' or 'turned'"},
      {"edits:\n  - select: all\n    set: {scatter: 0}", ":3:20", "a length above 0"},
      {"edits:\n  - select: all\n    set: {scatter: deep}", ":3:20", "a length above 0"},
      {"edits:\n  - select: all\n    set: {scatter_color: [1, 1, 1]}", ":3:26", "'scatter', which is missing"},
      {"edits:\n  - select: all\n    set: {scatter: 4mm, scatter_color: [1, 0, 1]}", ":3:40", "must be above 0"},
  };
  for (const auto& c : cases) {
    const Error e = error_of([&] { read(c.text); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << c.text;
    const std::string text = e.what();
    EXPECT_NE(text.find("edits.yaml" + c.where + ":"), std::string::npos) << c.text << "\n" << text;
    EXPECT_NE(text.find(c.says), std::string::npos) << c.text << "\n" << text;
  }
}

}  // namespace
}  // namespace vitrine
