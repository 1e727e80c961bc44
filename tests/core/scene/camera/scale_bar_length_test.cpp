// A bar of known ends under synthetic cameras: its length in scene units, and marks that cannot be right.
#include "core/scene/camera/scale_bar_length.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/foundation/base/rng.h"
#include "core/scene/camera/projection.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

constexpr Vec3d kEnds[2] = {{-0.05, 0.02, 0.01}, {0.06, 0.05, 0.0}};
const double kDistance = length(kEnds[1] - kEnds[0]);
constexpr double kDegree = std::numbers::pi / 180;

// On a ring of radius 1, at that azimuth; looks at the middle.
View camera_at(double degrees) {
  const double a = degrees * kDegree;
  const Vec3d eye{std::cos(a), std::sin(a), 0.5}, forward = normalized(-eye);
  const Vec3d right = normalized(cross(forward, Vec3d{0, 0, 1}));
  View v{.name = "sub/" + std::to_string(int(degrees)) + ".png", .intrinsics = {1000, 700, 2300, 2310, 495, 352}};
  v.cam_from_world = inverse(Rigid{Mat3d{right, cross(forward, right), forward}, eye});
  return v;
}

std::vector<View> cameras(const std::vector<double>& degrees) {
  std::vector<View> views;
  for (const double d : degrees) views.push_back(camera_at(d));
  return views;
}

// As somebody would mark it who errs by `noise_px`.
ScaleBar marked(const std::vector<View>& views, double noise_px = 0, uint64_t seed = 1) {
  Rng rng(seed);
  ScaleBar bar{.marks = {}, .length_m = 0.08};
  for (const View& v : views) {
    const auto a = projection(kEnds[0], v), b = projection(kEnds[1], v);
    const auto noise = [&] { return noise_px * rng.normal(); };
    bar.marks.push_back({v.name, a->x + noise(), a->y + noise(), b->x + noise(), b->y + noise()});
  }
  return bar;
}

std::string why(const ScaleBar& bar, const std::vector<View>& views, const Passes& passes = {}) {
  const Error e = error_of([&] { scale_bar_length(bar, views, passes); });
  EXPECT_EQ(e.kind(), ErrorKind::Usage);
  EXPECT_EQ(e.detail().code, "SCALE_BAR");
  EXPECT_FALSE(e.detail().hint.empty());
  return e.detail().why;
}

TEST(ScaleBarLength, IsExactForExactMarks) {
  for (const std::vector<double>& ring : {std::vector<double>{0, 20}, {0, 8, 350}, {0, 90, 200, 310}}) {
    const std::vector<View> views = cameras(ring);
    const ScaleBarLength found = scale_bar_length(marked(views), views, {});
    EXPECT_NEAR(found.scene_units, kDistance, 1e-12);
    EXPECT_NEAR(found.metres_per_unit, 0.08 / kDistance, 1e-9);
    EXPECT_LT(found.error_px, 1e-9);
  }
  const std::vector<View> views = cameras({0, 20});
  EXPECT_NEAR(scale_bar_length(marked(views), views, {}).angle_rad, 18 * kDegree, 2 * kDegree);
}

TEST(ScaleBarLength, FindsPhotosByTheirStems) {
  const std::vector<View> views = cameras({0, 20});
  ScaleBar bar = marked(views);
  for (ScaleBarMark& m : bar.marks) m.photo = m.photo.substr(0, m.photo.size() - 4);
  EXPECT_NEAR(scale_bar_length(bar, views, {}).scene_units, kDistance, 1e-12);
  bar.marks[1].photo = views[0].name;  // the first one's, by its name and by its stem
  EXPECT_EQ(why(bar, views), "'sub/0.png' is marked twice");
}

TEST(ScaleBarLength, ErrsLittleWhereMarksAreOffByAPixel) {
  const std::vector<View> views = cameras({0, 25, 330});
  double worst = 0, mean_error_px = 0;
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    const ScaleBarLength found = scale_bar_length(marked(views, 1, seed), views, {});
    worst = std::max(worst, std::abs(found.scene_units / kDistance - 1));
    mean_error_px += found.error_px / 50;
  }
  EXPECT_LT(worst, 0.02);
  EXPECT_GT(worst, 1e-4) << "the noise arrived";
  EXPECT_NEAR(mean_error_px, 1, 0.3);  // 12 numbers, 6 unknowns: sqrt(2) sqrt(1/2)
}

TEST(ScaleBarLength, RefusesMarksThatCannotBeRight) {
  const std::vector<View> views = cameras({0, 25, 330});
  ScaleBar swapped = marked(views);
  std::swap(swapped.marks[2].x1, swapped.marks[2].x2);
  std::swap(swapped.marks[2].y1, swapped.marks[2].y2);
  EXPECT_TRUE(why(swapped, views).starts_with("the marks do not meet: in 'sub/"));
  ScaleBar slipped = marked(views);
  slipped.marks[1].y2 += 60;
  EXPECT_TRUE(why(slipped, views).starts_with("the marks do not meet: in 'sub/25.png'")) << why(slipped, views);
  ScaleBar outside = marked(views);
  outside.marks[0].x1 = 1001;
  EXPECT_EQ(why(outside, views), "an end does not lie in 'sub/0.png', a photo of 1000x700 pixels");
  ScaleBar unknown = marked(views);
  unknown.marks[0].photo = "sub/1.png";
  EXPECT_EQ(why(unknown, views), "no photo with a known camera is called 'sub/1.png'");
}

TEST(ScaleBarLength, RefusesCamerasThatAreTooNearToEachOther) {
  const std::vector<View> near = cameras({0, 2});
  EXPECT_TRUE(why(marked(near), near).starts_with("its ends are seen from almost one direction: 1.")) << why(marked(near), near);
  std::vector<View> same = cameras({0, 0});
  same[1].name = "b.png";
  EXPECT_TRUE(why(marked(same), same).starts_with("its ends are seen from almost one direction: 0.0"));
  const std::vector<View> more = cameras({0, 2, 40});
  EXPECT_NO_THROW(scale_bar_length(marked(more), more, {}));
}

TEST(ScaleBarLength, LinesThatMeetBehindACameraAreRefused) {
  const std::vector<View> views = cameras({0, 30});
  ScaleBar bar = marked(views);  // diverging: each camera sees the ends on the far side
  for (double* x : {&bar.marks[0].x1, &bar.marks[0].x2}) *x = 5;
  for (double* x : {&bar.marks[1].x1, &bar.marks[1].x2}) *x = 995;
  std::vector<View> wide = views;
  for (View& v : wide) v.intrinsics.fx = v.intrinsics.fy = 300;
  for (size_t i = 0; i < 2; ++i) bar.marks[i].y1 = 352, bar.marks[i].y2 = 360;
  EXPECT_TRUE(why(bar, wide).starts_with("the lines of sight meet behind the camera")) << why(bar, wide);
}

TEST(ScaleBarLength, AllMarksMustBeOfOnePass) {
  const std::vector<View> views = cameras({0, 25, 330});
  const Passes together{{"sub/0.png", "sub/25.png", "sub/330.png"}, {"other.png"}};
  EXPECT_NO_THROW(scale_bar_length(marked(views), views, together));
  const Passes second{{"other.png"}, {"sub/0.png", "sub/25.png", "sub/330.png"}};
  EXPECT_NO_THROW(scale_bar_length(marked(views), views, second));
  const Passes apart{{"sub/0.png", "sub/25.png"}, {"sub/330.png"}};
  EXPECT_TRUE(why(marked(views), views, apart).starts_with("the object was moved between 'sub/0.png' and 'sub/330.png'"));
}

TEST(ScaleBarLength, IsToldInOneSentence) {
  EXPECT_EQ(scale_bar_text({.scene_units = 0.2, .metres_per_unit = 0.21347, .error_px = 0.42, .angle_rad = 1}),
            "one unit of the scene is 0.2135 m, by the scale bar, 0.4 px");
}

}  // namespace
}  // namespace vitrine
