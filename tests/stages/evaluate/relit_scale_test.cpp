// What one factor per channel between albedo and light does to relit pictures of glass.
#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/scene/camera/view_set.h"
#include "stages/evaluate/relit_error.h"
#include "tests/core/render/relight/relit_ball.h"

namespace vitrine::test {
namespace {

// A light found at half its strength makes albedos twice as bright. What stands under glass has no albedo: it follows the light
// of the photos, and that must be brought to the truth's unit like the albedos.
TEST(RelitScale, ThingsUnderGlassFollowTheLightInTheTruthsUnit) {
  const TemporaryFolder folder;
  for (const char* f : {"env", "relit/lamp"}) make_folders(folder.path() / f);
  View view = view_from({1, 0, 0});
  view.name = "view.png";
  const std::vector<View> views{view};
  write_transforms_json(folder.path() / "transforms.json", views, "photos");
  const Lighting lamp = constant_light(1);
  write_environment(folder.path() / "env/lamp.exr", lamp.environment);
  RelitPainter painter(ball_in_glass(Glass::Thin));
  painter.set_lighting(lamp);
  write_exr_rgb(folder.path() / "relit/lamp/view.exr", painter.picture(view, {.samples = 16}).radiance, ExrPrecision::Float);

  RelitScene ours = ball_in_glass(Glass::Thin);
  ours.captured = Environment(ImageF(8, 4, 3, 0.5f));
  const Truth truth(folder.path(), views);
  RelitErrorDesc desc{
      .truth = truth, .views = views, .truth_from_ours = {}, .albedo_scale = Vec3d{0.5, 0.5, 0.5}, .pictures = {}};
  const auto score = [&] {
    const auto no_regions = [](size_t, const Intrinsics&) { return RegionMasks(); };
    return relit_scores(ours, no_regions, desc, [](double) {}).at(0).everywhere_psnr.value();
  };
  EXPECT_GT(score(), 35);
  desc.albedo_scale = Vec3d{1, 1, 1};
  EXPECT_LT(score(), 20);
}

}  // namespace
}  // namespace vitrine::test
