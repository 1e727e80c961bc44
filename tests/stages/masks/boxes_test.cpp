// Marks of the user's: what is wrong with a file is shown at its line, and few marks become masks of all photos.
#include <gtest/gtest.h>

#include "core/foundation/base/hash.h"
#include "core/observe/stereo/box_fit.h"
#include "stages/masks/masks.h"
#include "tests/stages/masks/ball_capture.h"
#include "tests/stages/masks/tiny_masks.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using namespace test;

class Marked : public testing::Test, public BallCapture {
 protected:
  // Marks were drawn on photos twice as large.
  std::string head() const { return fmt::format("size: [{}, {}]\nmarks:\n", 2 * kWidth, 2 * kHeight); }
  std::string mark(int view, const std::string& kind, int margin = 0) const {
    int left = kWidth, right = 0, top = kHeight, bottom = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        if (truth[size_t(view)].at(x, y) == 0) continue;
        left = std::min(left, x), right = std::max(right, x + 1), top = std::min(top, y), bottom = std::max(bottom, y + 1);
      }
    return fmt::format("  - {{photo: v{}.jpg, class: {}, box: [{}, {}, {}, {}]}}\n", view, kind, 2 * left - margin,
                       2 * top - margin, 2 * right + margin, 2 * bottom + margin);
  }
  std::string disk(int view, const std::string& kind) const {  // a polygon
    const Vec3d centre = views[size_t(view)].cam_from_world * Vec3d{0, 0, 0};
    const double r = 2 * kFocal * kBall / std::sqrt(centre.z * centre.z - kBall * kBall);
    std::string corners;
    for (int i = 0; i < 24; ++i)
      corners += fmt::format("{}[{:.1f}, {:.1f}]", i ? ", " : "", kWidth + r * std::cos(i * std::numbers::pi / 12),
                             kHeight + r * std::sin(i * std::numbers::pi / 12));
    return fmt::format("  - photo: v{}.jpg\n    class: {}\n    polygon: [{}]\n", view, kind, corners);
  }
  // A polygon around the corners of a box, whole pixels of the large photo: Andrew's monotone chain.
  std::string corners(const Box& box, int view) const {
    std::vector<Vec2d> p;
    for (size_t i = 0; i < 8; ++i) {
      const Vec3d q = views[size_t(view)].cam_from_world * box.corner(i);
      p.push_back({std::round(2 * (kFocal * q.x / q.z + kWidth / 2.0)), std::round(2 * (kFocal * q.y / q.z + kHeight / 2.0))});
    }
    std::ranges::sort(p, [](const Vec2d& a, const Vec2d& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
    std::vector<Vec2d> around;
    for (int half = 0; half < 2; ++half, std::ranges::reverse(p)) {
      const size_t first = around.size();
      for (const Vec2d& c : p) {
        const auto turns_in = [&] {
          const Vec2d a = around.end()[-2], b = around.end()[-1];
          return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) <= 0;
        };
        while (around.size() >= first + 2 && turns_in()) around.pop_back();
        around.push_back(c);
      }
      around.pop_back();
    }
    std::string text;
    for (const Vec2d& c : around) text += fmt::format("{}[{}, {}]", text.empty() ? "" : ", ", c.x, c.y);
    return fmt::format("  - {{photo: v{}.jpg, class: transparent, polygon: [{}]}}\n", view, text);
  }
  // A polygon around the truth, whose rows are in one piece.
  std::string outline(int view) const {
    std::string left, right;
    const Image8& mask = truth[size_t(view)];
    for (int y = 0; y < kHeight; ++y) {
      int first = kWidth, last = -1;
      for (int x = 0; x < kWidth; ++x)
        if (mask.at(x, y) != 0) first = std::min(first, x), last = x;
      if (last < 0) continue;
      left += fmt::format("{}[{}, {}]", left.empty() ? "" : ", ", 2 * first, 2 * y + 1);
      right = fmt::format(", [{}, {}]", 2 * last + 2, 2 * y + 1) + right;
    }
    return fmt::format("  - photo: v{}.jpg\n    class: specular\n    polygon: [{}{}]\n", view, left, right);
  }
  std::unique_ptr<RecordingContext> run(const std::string& marks, const char* file = "marks.yaml",
                                        const MasksConfig& config = {}) const {
    write_file(folder.path() / file, marks);
    auto context =
        std::make_unique<RecordingContext>(std::map<std::string, fs::path>{{"sfm", sfm()}, {"masks", folder.path() / file}});
    run_masks(config, *context);
    return context;
  }
  std::vector<MarkedObject> objects_of(const std::string& marks) const { return read(marks).objects; }
  Marks read(const std::string& marks) const {
    write_file(folder.path() / "marks.yaml", marks);
    return read_marks(folder.path() / "marks.yaml", read_mask_capture(sfm()));
  }
};

TEST_F(Marked, GlassIsCarriedByItsHullAndMirrorsToo) {
  const auto context =
      run(head() + disk(0, "transparent") + disk(3, "transparent") + disk(6, "transparent") + disk(8, "transparent"));
  EXPECT_GT(worst_overlap(*context, "transparent"), 0.8);  // measured 0.87: four cones make an edgy ball
  EXPECT_EQ(worst_overlap(*context, "specular"), worst_overlap(*context, "transparent"));
  EXPECT_FALSE(fs::exists(context->output() / "masks/object"));
}

// Four cones make an edgy ball; of a case they make a leaning one, while its box is known from them to a fraction of a pixel.
TEST_F(Marked, ACaseIsCarriedAsTheBoxThatItIs) {
  const Box box{rotation_matrix(Quatd{std::cos(0.15), 0, 0, std::sin(0.15)}), {-0.2, -0.22, -0.2}, {0.22, 0.15, 0.18}};
  for (size_t v = 0; v < views.size(); ++v) {
    const std::vector<uint8_t> inside = silhouette_mask(box, views[v]);
    for (size_t i = 0; i < inside.size(); ++i) truth[v].data()[i] = inside[i] ? 255 : 0;
  }
  const auto context = run(head() + corners(box, 0) + corners(box, 3) + corners(box, 6) + corners(box, 8));
  EXPECT_GT(worst_overlap(*context, "transparent"), 0.94);
  const auto report = nlohmann::json::parse(read_file(context->output() / "masks/report.json"));
  EXPECT_NE(report.dump().find("\"box_agreement\""), std::string::npos);
}

// The ground is plain: stereo finds nothing, and colour has to tell.
TEST_F(Marked, ThingsWithAColourGetTheirOwnOutlineFromLooseBoxes) {
  for (size_t v = 0; v < views.size(); ++v) {
    ImageF photo(kWidth, kHeight, 3, 0.25f);
    for (size_t i = 0; i < photo.pixel_count(); ++i)
      for (size_t c = 0; c < 3; ++c)
        if (truth[v].data()[i]) photo.data()[3 * i + c] = c == 0 ? 0.6f : 0.05f;
    write_exr_rgb(linear_image_path(sfm(), views[v]), photo);
  }
  const auto boxes = [&](const std::string& kind) { return head() + mark(0, kind, 14) + mark(3, kind, 14) + mark(6, kind, 14); };
  const double loose = worst_overlap(*run(boxes("transparent")), "transparent");
  const double found = worst_overlap(*run(boxes("specular")), "specular");
  RecordProperty("loose", std::to_string(loose));
  RecordProperty("found", std::to_string(found));
  EXPECT_LT(loose, 0.75);
  EXPECT_GT(found, 0.85) << loose;
}

// Polished metal: below, the ball shows the ground in its colours, above a lamp.
TEST_F(Marked, TightMarksHoldTheMiddleOfAMirror) {
  for (size_t v = 0; v < views.size(); ++v) {
    ImageF photo(kWidth, kHeight, 3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        for (int c = 0; c < 3; ++c)
          photo.at(x, y, c) = truth[v].at(x, y) != 0 && y < kHeight / 2 - 6 ? (c == 0 ? 0.6f : 0.05f)
                              : (x / 4 + y / 4) % 2                         ? 0.2f
                                                                            : 0.3f;
    write_exr_rgb(linear_image_path(sfm(), views[v]), photo);
  }
  const auto context = run(head() + disk(0, "specular") + disk(3, "specular") + disk(6, "specular") + disk(8, "specular"));
  EXPECT_GT(worst_overlap(*context, "specular"), 0.8);
}

// A kettle: its spout has the colours of what it mirrors, and its lid is a lamp.
TEST_F(Marked, AKettleIsASolidOfRevolutionAndWhatSticksOutOfIt) {
  for (size_t v = 0; v < views.size(); ++v) {
    const View& view = views[v];
    const Vec3d eye = view.centre_in_world();
    ImageF photo(kWidth, kHeight, 3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const Vec3d d = normalized(view.ray(x + 0.5, y + 0.5));
        const bool body = truth[v].at(x, y) != 0, lid = body && (eye - dot(eye, d) * d).z > 0.2;
        // The spout: balls in a row towards +x.
        for (double along = 0.3; along < 0.46; along += 0.02) {
          const Vec3d to = Vec3d{along, 0, 0} - eye;
          if (length(to - dot(to, d) * d) < 0.06) truth[v].at(x, y) = 255;
        }
        for (int c = 0; c < 3; ++c)
          photo.at(x, y, c) = body && !lid ? (c == 0 ? 0.6f : 0.05f) : (x / 4 + y / 4) % 2 ? 0.2f : 0.3f;
      }
    write_exr_rgb(linear_image_path(sfm(), view), photo);
  }
  MasksConfig config;
  config.hull_voxels = 40;  // a voxel is a pixel
  const auto context = run(head() + outline(0) + outline(3) + outline(5) + outline(8), "marks.yaml", config);
  EXPECT_GT(worst_overlap(*context, "specular"), 0.88);  // of votes alone 0.78
  const auto report = nlohmann::json::parse(read_file(context->output() / "masks/report.json"));
  EXPECT_EQ(report.at("classes").at("specular").at("things").at(0).at("solids_of_revolution"), 1);
}

TEST_F(Marked, SameMarksSameBytes) {
  const std::string marks = head() + mark(0, "object", 6) + mark(4, "object", 6) + mark(7, "object", 6);
  EXPECT_EQ(digest_folder(run(marks)->output()), digest_folder(run(marks)->output()));
}

TEST_F(Marked, MistakesAreShownAtTheirLine) {
  const std::string good = head() + mark(0, "object");
  struct Case {
    std::string text;
    const char* message;
    int line = 4;  // below `good`; 0: the file as a whole
  };
  const Case cases[] = {
      {good, "marked in one photo only", 0},
      {good + "  - {photo: v77.jpg, class: object, box: [1, 1, 9, 9]}\n", "'v77.jpg' is not among the photos"},
      {good + "  - {photo: v1.jpg, class: glas, box: [1, 1, 9, 9]}\n", "'glas' is no class"},
      {good + "  - {photo: v1.jpg, class: object, box: [9, 1, 1, 9]}\n", "left must be smaller than right"},
      {good + "  - {photo: v1.jpg, class: object, box: [1, 1, 9]}\n", "expected [left, top, right, bottom]"},
      {good + "  - {photo: v1.jpg, class: object, box: [1, 1, 9, x]}\n", "expected a number"},
      {good + "  - {photo: v1.jpg, class: object, box: [1, 1, 9, 900]}\n", "lies outside"},
      {good + "  - {photo: v1.jpg, class: object, polygon: [[1, 1], [5, 5]]}\n", "three corners"},
      {good + "  - photo: v1.jpg\n    class: object\n    polygon: [[1, 1], [9, 9],\n              [9, 1], [1, 9]]\n",
       "the outline crosses itself: its side from (9, 1) to (1, 9) meets that from (1, 1) to (9, 9)", 7},
      {good + "  - photo: v1.jpg\n    class: object\n    polygon: [[1, 1], [9, 1],\n              [900, 9]]\n",
       "(900, 9) lies outside", 7},
      {good + "  - {photo: v1.jpg, class: object, polygon: [[1, 1], [5, 5], [3, 3]]}\n", "the outline encloses nothing"},
      {good + "  - {photo: v1.jpg, class: object}\n", "a box or a polygon"},
      {good + "  - {photo: v1.jpg, class: object, bx: [1, 1, 9, 9]}\n", "did you mean 'box'"},
      {good + mark(0, "object"), "marked twice"},
      {good + "  - {photo: v1.jpg, class: object, box: [1, 1, 9, 9], photo: v2.jpg}\n",
       "'photo' is given twice (first on line 4)"},
      {good + "  - {photo: v1.jpg, class: object, box: [1, 1, 9, 9], thing: [a]}\n", "'thing' is the name of the object"},
      {good + "  - {photo: v1.jpg, class: object, box: [1, 1, 9, 9], size: [0, 9]}\n", "positive width and height"},
      {good + "  - {photo: v1.jpg, class: object, box: [1, 1, 9, 9], size: [90, 90]}\n", "is 'size' right?"},
      {"marks:\n  - {photo: v1.jpg, class: object, box: [1, 1, 9, 9]}\n", "of what size", 2},
      {"size: [100, 300]\nmarks:\n  - {photo: v1.jpg, class: object, box: [1, 1, 9, 9]}\n", "is 'size' right?", 3},
      {"size: [100]\nmarks: []\n", "marks must be a list", 2},
      {"[1, 2]\n", "expected size, marks", 1},
  };
  for (const auto& [text, message, line] : cases) {
    const Error e = error_of([&] { run(text); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << text;
    // "marks.yaml:4:28: error: ...": message and line belong together.
    std::string found;
    std::istringstream shown(e.what());
    for (std::string row; std::getline(shown, row);)
      if (row.find(message) != std::string::npos) found = row;
    ASSERT_FALSE(found.empty()) << text << "\n" << e.what();
    EXPECT_NE(found.find(line == 0 ? "marks.yaml: error: " : fmt::format("marks.yaml:{}:", line)), std::string::npos) << found;
  }
}

TEST_F(Marked, PhotosThatSfmCouldNotPlaceAreLeftOut) {
  make_folders(sfm() / "sfm");
  write_file(sfm() / "sfm/lenses.json", R"({"cameras": [], "without_camera": ["left/lost.jpg", "gone.jpg", "left/v4.jpg"]})");
  const auto lost = [](const char* photo) {
    return fmt::format("  - {{photo: {}, class: object, box: [8, 6, 40, 30]}}\n", photo);
  };
  const std::string text = head() + mark(0, "object") + lost("lost.jpg") + mark(3, "object") + lost("gone") + lost("gone");
  const auto context = run(text);
  EXPECT_TRUE(context->warnings.contains("MASKS_WITHOUT_CAMERA"));
  const Marks marks = read(text);
  ASSERT_EQ(marks.objects.size(), 1u);
  EXPECT_EQ(marks.objects[0].marks.size(), 2u);
  EXPECT_EQ(marks.without_camera, (std::vector<std::string>{"lost.jpg", "gone"}));
  // One that has a camera may be called like one that has none.
  EXPECT_TRUE(read(head() + mark(0, "object") + mark(4, "object")).without_camera.empty());
  // Nothing is left to go by: said with the reason.
  const Error few = error_of([&] { read(head() + mark(0, "object") + lost("lost.jpg")); });
  EXPECT_NE(few.message().find("marked in one photo only (sfm could not place lost.jpg)"), std::string::npos) << few.message();
  EXPECT_EQ(error_of([&] { read(head() + lost("lost.jpg")); }).kind(), ErrorKind::Usage);
}

TEST_F(Marked, ThingsOfAClassAreToldApartByTheirWord) {
  const auto named = [](std::string mark, const std::string& object) {
    return mark.replace(mark.rfind('}'), 1, fmt::format(", thing: {}}}", object));
  };
  const auto objects = objects_of(head() + named(mark(0, "specular"), "kettle") + mark(0, "specular") + mark(3, "specular") +
                                  named(mark(4, "specular"), "kettle"));
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[0].name, "specular kettle");
  EXPECT_EQ(objects[1].name, "specular");
  const size_t views_of[2][2] = {{0, 4}, {0, 3}};
  for (size_t t = 0; t < 2; ++t) {
    ASSERT_EQ(objects[t].marks.size(), 2u);
    for (size_t m = 0; m < 2; ++m) EXPECT_EQ(objects[t].marks[m].view, views_of[t][m]);
  }
}

TEST_F(Marked, AMarkMayHaveASizeOfItsOwn) {
  const std::string at_full =
      fmt::format("  - {{photo: v0.jpg, class: object, box: [8, 6, 40, 30], size: [{}, {}]}}\n", kWidth, kHeight);
  const std::vector<MarkedObject> objects =
      objects_of(head() + at_full + "  - {photo: v3.jpg, class: object, box: [16, 12, 80, 60]}\n");
  ASSERT_EQ(objects.size(), 1u);
  for (const Mark& m : objects[0].marks) {
    EXPECT_EQ(m.outline.front().x, 8);
    EXPECT_EQ(m.outline.front().y, 6);
    const auto rightmost = std::max_element(m.outline.begin(), m.outline.end(), [](auto& a, auto& b) { return a.x < b.x; });
    EXPECT_EQ(rightmost->x, 40);
  }
}

TEST_F(Marked, TheReportCountsWhatWasFoundAndMeasuresTheThing) {
  write_file(folder.path() / "marks.yaml", head() + disk(0, "object") + disk(1, "object") + disk(3, "object") +
                                               disk(5, "object") + disk(8, "object") + mark(6, "object", 8));
  const MaskCapture capture = read_mask_capture(sfm());
  const auto masks = carry_marks(capture, read_marks(folder.path() / "marks.yaml", capture).objects, kHullVoxels, [](double) {});
  ASSERT_EQ(masks->objects.size(), 1u);
  EXPECT_EQ(masks->objects[0].marks, 6u);
  EXPECT_EQ(masks->objects[0].refined, size_t(kViews - 5));  // GrabCut is not asked where polygons say it
  EXPECT_NEAR(masks->objects[0].edge, 2 * kBall, 0.1);
}

TEST_F(Marked, GlassNeedsNoColours) {
  write_file(folder.path() / "marks.yaml", head() + disk(0, "transparent") + disk(3, "transparent") + disk(6, "transparent"));
  const MaskCapture capture = read_mask_capture(sfm());
  const std::vector<MarkedObject> objects = read_marks(folder.path() / "marks.yaml", capture).objects;
  fs::remove_all(sfm() / "linear");
  const auto masks = carry_marks(capture, objects, kHullVoxels, [](double) {});
  const std::vector<uint8_t>& inside = masks->inside[5][size_t(MaskClass::Transparent)];
  EXPECT_NE(std::count(inside.begin(), inside.end(), 1), 0);
}

TEST_F(Marked, BothExtensionsOfYamlAreMarks) {
  const std::string marks = head() + disk(0, "transparent") + disk(3, "transparent") + disk(6, "transparent");
  EXPECT_EQ(digest_folder(run(marks, "marks.yml")->output()), digest_folder(run(marks)->output()));
}

// A capture that is nowhere on the disk: what marks say of it.
MaskCapture unseen_capture(const std::vector<std::pair<std::string, Intrinsics>>& photos) {
  MaskCapture capture;
  for (const auto& [name, k] : photos) {
    View view;
    view.name = name;
    view.intrinsics = k;
    capture.set.views.push_back(view);
    capture.undistortions.push_back({.source = colmap_pinhole(1, k), .target = k, .identity = true});
  }
  return capture;
}

std::vector<MarkedObject> read_text(const std::string& marks, const MaskCapture& capture) {
  const TemporaryFolder folder;
  write_file(folder.path() / "marks.yaml", marks);
  return read_marks(folder.path() / "marks.yaml", capture).objects;
}

TEST(Marks, ExampleOfTheReadmeIsUnderstood) {
  const std::string readme = read_file(fs::path(VITRINE_SOURCE_DIR) / "stages/masks/README.md"), open = "```yaml\n";
  const size_t begin = readme.find(open);
  ASSERT_NE(begin, std::string::npos);
  const std::string example = readme.substr(begin + open.size(), readme.find("```", begin + 3) - begin - open.size());
  // One photo was taken upright.
  const std::vector<MarkedObject> objects =
      read_text(example, unseen_capture({{"IMG_0012.jpg", {2000, 1500, 1800, 1800, 1000, 750}},
                                         {"IMG_0031.jpg", {1500, 2000, 1800, 1800, 750, 1000}}}));
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0].name, "transparent case");
  ASSERT_EQ(objects[0].marks.size(), 2u);
  EXPECT_FALSE(objects[0].marks[0].box);
  EXPECT_TRUE(objects[0].marks[1].box);
  EXPECT_EQ(objects[0].marks[0].outline.front().x, 450);
  EXPECT_EQ(objects[0].marks[1].outline.front().x, 600);
}

TEST(Marks, APhotoIsFoundByItsFullNameFirstAndAnyOtherNameMustBeClear) {
  const Intrinsics k{80, 60, 70, 70, 40, 30};
  const MaskCapture capture = unseen_capture({{"a/b.jpg", k}, {"b", k}, {"b.jpg", k}, {"c/b.jpg", k}, {"c/d.jpg", k}});
  const auto marks = [](const std::string& photo, const std::string& other) {
    const auto mark = [](const std::string& p) {
      return fmt::format("  - {{photo: {}, class: object, box: [1, 1, 9, 9]}}\n", p);
    };
    return "size: [80, 60]\nmarks:\n" + mark(photo) + mark(other);
  };
  const auto first_view = [&](const std::string& photo) { return read_text(marks(photo, "c/b.jpg"), capture)[0].marks[0].view; };
  EXPECT_EQ(first_view("b.jpg"), 2u);  // not a/b.jpg
  EXPECT_EQ(first_view("b"), 1u);      // not the stem of b.jpg
  EXPECT_EQ(first_view("a/b"), 0u);
  EXPECT_EQ(first_view("d.jpg"), 4u);
  MaskCapture two = unseen_capture({{"a/b.jpg", k}, {"c/b.jpg", k}});
  const std::string message = error_of([&] { read_text(marks("b.jpg", "a/b.jpg"), two); }).what();
  EXPECT_NE(message.find(":3:13: error: 'b.jpg' may be a/b.jpg or c/b.jpg"), std::string::npos) << message;
}

TEST(Marks, WhereTheLensCannotBeUndoneAMarkIsRefused) {
  const Intrinsics k{80, 60, 70, 70, 40, 30};
  MaskCapture capture = unseen_capture({{"a.jpg", k}, {"b.jpg", k}});
  // Folds over 38 pixels from the middle.
  capture.undistortions[0] = {.source = {1, 2, 80, 60, {70, 40, 30, -0.5}}, .target = k, .identity = false};
  const std::string rest = ", class: object, box: [1, 1, 70, 50]}\n";
  const std::string marks = "size: [80, 60]\nmarks:\n  - {photo: a.jpg" + rest + "  - {photo: b.jpg" + rest;
  const std::string message = error_of([&] { read_text(marks, capture); }).what();
  EXPECT_NE(message.find(":3:5: error: the lens distorts (1, 1) too much"), std::string::npos) << message;
}

TEST_F(Marked, MarksThatDoNotMeetAreRefused) {
  const std::string elsewhere = "  - {photo: v5.jpg, class: object, box: [2, 2, 20, 14]}\n";
  EXPECT_EQ(error_of([&] { run(head() + mark(0, "object") + elsewhere); }).detail().code, "MARKS_DISAGREE");
}

}  // namespace
}  // namespace vitrine
