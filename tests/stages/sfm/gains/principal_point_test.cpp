#include "stages/sfm/gains/principal_point.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/stages/sfm/gains/ring_of_photos.h"

namespace vitrine {
namespace {

struct LensDesc {
  int model_id = 2;                                  // SIMPLE_RADIAL
  std::vector<double> params{600, 329, 233, -0.05};  // the truth: off the middle by 9 and -7 pixels
  size_t views = 16;
};

// Photos all around a cloud of points, with a pixel's third of noise, as mapped: the principal point in the middle of 640x480.
ColmapModel mapped(const LensDesc& lens, bool middle_is_true = false) {
  Rng rng(3);
  ColmapModel model;
  ColmapCamera camera{.id = 1, .model_id = lens.model_id, .width = 640, .height = 480, .params = lens.params};
  const bool two = lens.model_id == 1;  // PINHOLE: two focal lengths, no distortion
  const size_t at = two ? 2 : 1;
  if (middle_is_true) camera.params[at] = 320, camera.params[at + 1] = 240;
  const std::vector<double> truth = camera.params;
  test::add_cloud(model, 400, rng);
  for (uint32_t v = 1; v <= lens.views; ++v)
    test::add_photo(model, v, 2 * std::numbers::pi * v / double(lens.views), v % 2 == 0 ? 0.5 : 1.2, [&](double x, double y) {
      const double r = 1 + truth[at + 2] * (x * x + y * y);
      return Vec2d{truth[0] * x * r + truth[at] + 0.3 * rng.normal(), truth[two ? 1 : 0] * y * r + truth[at + 1] + 0.3 * rng.normal()};
    });
  camera.params[at] = 320, camera.params[at + 1] = 240;
  if (two) camera.params.resize(4);
  model.cameras.push_back(camera);
  return model;
}

TEST(PrincipalPoint, IsFoundWhereTheLensHasItAndPosesAlong) {
  for (const LensDesc& lens : {LensDesc{}, LensDesc{.model_id = 1, .params = {600, 604, 329, 233, 0}}}) {
    ColmapModel model = mapped(lens);
    const PrincipalPoints p = refine_principal_points(model);
    ASSERT_TRUE(p.asked && p.moved);
    const std::vector<double>& found = model.cameras[0].params;
    const size_t at = lens.model_id == 1 ? 2 : 1;
    fmt::print("{:.2f} -> {:.2f} px, at {:.2f} {:.2f}, focal length {:.2f}\n", p.error_before, p.error_after, found[at],
               found[at + 1], found[0]);
    EXPECT_NEAR(found[at], lens.params[at], 0.4);
    EXPECT_NEAR(found[at + 1], lens.params[at + 1], 0.4);
    EXPECT_NEAR(found[0], lens.params[0], 0.5);
    EXPECT_NEAR(p.error_after, 0.3 * std::sqrt(2.0), 0.03);
    double error = 0;
    for (const ColmapPoint3D& point : model.points) error += point.error_px / double(model.points.size());
    EXPECT_NEAR(error, 0.37, 0.05) << "points tell their errors anew";
    ColmapModel again = mapped(lens);
    refine_principal_points(again);
    EXPECT_TRUE(again == model) << "the same bytes";
  }
}

TEST(PrincipalPoint, StaysInTheMiddleWhereItIsOrNobodyCanTell) {
  const ColmapModel centred = mapped({}, true);
  ColmapModel model = centred;
  const PrincipalPoints p = refine_principal_points(model);
  EXPECT_TRUE(p.asked);
  EXPECT_FALSE(p.moved);
  EXPECT_TRUE(model == centred);

  const ColmapModel few = mapped({.views = 8});
  model = few;
  EXPECT_FALSE(refine_principal_points(model).asked);
  EXPECT_TRUE(model == few);

  ColmapModel strange = mapped({});
  strange.cameras[0].model_id = 5;  // a fisheye lens
  EXPECT_FALSE(refine_principal_points(strange).asked);
}

TEST(PrincipalPoint, OnesThatNoLensHasAreNotBelieved) {
  const ColmapModel cropped = mapped({.params = {600, 380, 240, -0.05}});  // a tenth of the picture off: somebody cropped it
  ColmapModel model = cropped;
  const PrincipalPoints p = refine_principal_points(model);
  EXPECT_TRUE(p.asked);
  EXPECT_GT(p.furthest, 0.05);
  EXPECT_FALSE(p.moved);
  EXPECT_TRUE(model == cropped);
}

}  // namespace
}  // namespace vitrine
