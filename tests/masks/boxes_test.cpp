// Marks of the user's: what is wrong with a file is shown at its line, and few marks become masks of all photos.
#include <gtest/gtest.h>

#include "core/base/hash.h"

#include "stages/masks/masks.h"
#include "tests/masks/tiny_masks.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using namespace test;

constexpr int kViews = 10, kWidth = 96, kHeight = 72;
constexpr double kBall = 0.3;

// A red ball of radius 0.3 on a grey chequered ground, seen from around.
class Marked : public testing::Test {
 protected:
  Marked() {
    ColmapModel model;
    model.cameras.push_back(colmap_pinhole(1, {kWidth, kHeight, 90, 90, kWidth / 2.0, kHeight / 2.0}));
    Gains gains;
    for (int i = 0; i < kViews; ++i) {
      View view;
      view.name = fmt::format("v{}.jpg", i);
      view.intrinsics = {kWidth, kHeight, 90, 90, kWidth / 2.0, kHeight / 2.0};
      const double angle = 2 * std::numbers::pi * i / kViews;
      const Vec3d eye{std::cos(angle), std::sin(angle), 0.4}, forward = normalized(-eye);
      const Vec3d right = normalized(cross(forward, Vec3d{0, 0, 1})), down = cross(forward, right);
      view.cam_from_world = inverse(Rigid{Mat3d{right, down, forward}, eye});
      views.push_back(view);
      truth.emplace_back(kWidth, kHeight, 1);
      ImageF photo(kWidth, kHeight, 3);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const Vec3d d = normalized(transposed_times(view.cam_from_world.rotation, view.intrinsics.ray(x + 0.5, y + 0.5)));
          const bool ball = length(eye - dot(eye, d) * d) < kBall;
          truth.back().at(x, y) = ball ? 255 : 0;
          for (int c = 0; c < 3; ++c) photo.at(x, y, c) = ball ? (c == 0 ? 0.6f : 0.05f) : (x / 4 + y / 4) % 2 ? 0.2f : 0.3f;
        }
      write_exr_rgb(linear_image_path(sfm(), view), photo);
      model.images.push_back(
          {uint32_t(i + 1), quaternion(view.cam_from_world.rotation), view.cam_from_world.translation, 1, view.name, {}});
      gains[view.name] = {1, 1, 1};
    }
    write_colmap_model(sfm() / "sparse/0", model, ColmapFormat::Binary);
    write_gains(sfm() / "sfm/gains.json", gains);
    write_scene_info(sfm() / "scene.json", {});
  }
  fs::path sfm() const { return folder.path() / "sfm"; }
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
    const double r = 2 * 90 * kBall / std::sqrt(centre.z * centre.z - kBall * kBall);
    std::string corners;
    for (int i = 0; i < 24; ++i)
      corners += fmt::format("{}[{:.1f}, {:.1f}]", i ? ", " : "", kWidth + r * std::cos(i * std::numbers::pi / 12),
                             kHeight + r * std::sin(i * std::numbers::pi / 12));
    return fmt::format("  - photo: v{}.jpg\n    class: {}\n    polygon: [{}]\n", view, kind, corners);
  }
  std::unique_ptr<RecordingContext> run(const std::string& marks) const {
    write_file(folder.path() / "marks.yaml", marks);
    auto context = std::make_unique<RecordingContext>(
        std::map<std::string, fs::path>{{"sfm", sfm()}, {"masks", folder.path() / "marks.yaml"}});
    run_masks({}, *context);
    return context;
  }
  double worst_overlap(const RecordingContext& context, const std::string& kind) const {
    double worst = 1;
    for (size_t v = 0; v < views.size(); ++v)
      worst = std::min(worst, overlap(read_grey8(context.output() / "masks" / kind / (views[v].stem() + ".png")), truth[v]));
    return worst;
  }

  TemporaryFolder folder;
  std::vector<View> views;
  std::vector<Image8> truth;
};

TEST_F(Marked, GlassIsCarriedByItsHullAndMirrorsToo) {
  const auto context =
      run(head() + disk(0, "transparent") + disk(3, "transparent") + disk(6, "transparent") + disk(8, "transparent"));
  EXPECT_GT(worst_overlap(*context, "transparent"), 0.8);  // measured 0.87: four cones make an edgy ball
  EXPECT_EQ(worst_overlap(*context, "specular"), worst_overlap(*context, "transparent"));
  EXPECT_FALSE(fs::exists(context->output() / "masks/object"));
}

TEST_F(Marked, ThingsWithAColourGetTheirOwnOutlineFromLooseBoxes) {
  const auto boxes = [&](const std::string& kind) { return head() + mark(0, kind, 14) + mark(3, kind, 14) + mark(6, kind, 14); };
  const double loose = worst_overlap(*run(boxes("transparent")), "transparent");
  const double found = worst_overlap(*run(boxes("specular")), "specular");
  RecordProperty("loose", std::to_string(loose));
  RecordProperty("found", std::to_string(found));
  EXPECT_LT(loose, 0.75);
  EXPECT_GT(found, 0.85) << loose;
}

TEST_F(Marked, SameMarksSameBytes) {
  const std::string marks = head() + mark(0, "object", 6) + mark(4, "object", 6) + mark(7, "object", 6);
  EXPECT_EQ(digest_folder(run(marks)->output()), digest_folder(run(marks)->output()));
}

TEST_F(Marked, MistakesAreShownAtTheirLine) {
  const std::string good = head() + mark(0, "object");
  const std::pair<std::string, const char*> cases[] = {
      {good, "marked in one photo only"},
      {good + "  - {photo: v77.jpg, class: object, box: [1, 1, 9, 9]}\n", "'v77.jpg' is not among the photos"},
      {good + "  - {photo: v1.jpg, class: glas, box: [1, 1, 9, 9]}\n", "'glas' is no class"},
      {good + "  - {photo: v1.jpg, class: object, box: [9, 1, 1, 9]}\n", "left must be smaller than right"},
      {good + "  - {photo: v1.jpg, class: object, box: [1, 1, 9]}\n", "expected [left, top, right, bottom]"},
      {good + "  - {photo: v1.jpg, class: object, box: [1, 1, 9, x]}\n", "expected a number"},
      {good + "  - {photo: v1.jpg, class: object, box: [1, 1, 9, 900]}\n", "lies outside"},
      {good + "  - {photo: v1.jpg, class: object, polygon: [[1, 1], [5, 5]]}\n", "three corners"},
      {good + "  - {photo: v1.jpg, class: object}\n", "a box or a polygon"},
      {good + "  - {photo: v1.jpg, class: object, bx: [1, 1, 9, 9]}\n", "did you mean 'box'"},
      {good + mark(0, "object"), "marked twice"},
      {"marks:\n  - {photo: v1.jpg, class: object, box: [1, 1, 9, 9]}\n", "of what size"},
      {"size: [100, 300]\nmarks:\n  - {photo: v1.jpg, class: object, box: [1, 1, 9, 9]}\n", "is 'size' right?"},
      {"size: [100]\nmarks: []\n", "marks must be a list"},
      {"[1, 2]\n", "expected size, marks"},
  };
  for (const auto& [text, message] : cases) {
    const Error e = error_of([&] { run(text); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << text;
    EXPECT_NE(std::string(e.what()).find(message), std::string::npos) << text << "\n" << e.what();
  }
}

TEST_F(Marked, MarksThatDoNotMeetAreRefused) {
  const std::string elsewhere = "  - {photo: v5.jpg, class: object, box: [2, 2, 20, 14]}\n";
  EXPECT_EQ(error_of([&] { run(head() + mark(0, "object") + elsewhere); }).detail().code, "MARKS_DISAGREE");
}

}  // namespace
}  // namespace vitrine
