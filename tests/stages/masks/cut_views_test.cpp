// Views cut from fisheye photos: what the lens does not show is ignored, and masks of the photos are cut like the photos.
#include <gtest/gtest.h>

#include "core/foundation/config/json_file.h"
#include "core/scene/camera/holdout.h"
#include "core/scene/camera/view_masks.h"
#include "core/scene/camera/wide_views.h"
#include "stages/masks/masks.h"
#include "tests/stages/masks/tiny_masks.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using namespace test;

constexpr int kCutSide = 120;
constexpr double kCircle_px = 52;  // of 156 degrees: the sides of the faces end in an arc

class CutViews : public testing::Test {
 protected:
  CutViews() : views(lens_views({1, 5, kCutSide, kCutSide, {38.2, 38.2, 60, 60, 0, 0, 0, 0}}, kCircle_px)) {
    ColmapModel model;
    nlohmann::json cameras = nlohmann::json::array();
    Gains gains;
    Rigs rigs;
    for (size_t v = 0; v < views.size(); ++v) {
      const auto id = uint32_t(v) + 1;
      model.cameras.push_back(colmap_pinhole(id, views[v].target));
      const Quatd q = quaternion(*views[v].rotation);
      cameras.push_back(
          {{"photographed",
            {{"id", id}, {"model", "OPENCV_FISHEYE"}, {"width", kCutSide}, {"height", kCutSide}, {"params", views[v].source.params}}},
           {"view_from_photo", {q.w, q.x, q.y, q.z}},
           {"circle_px", kCircle_px}});
    }
    for (const char* photo : {"a", "b"})
      for (size_t v = 0; v < views.size(); ++v) {
        View view;
        view.name = view_name(photo, std::string(photo) + ".jpg", v);
        model.images.push_back(
            {uint32_t(model.images.size() + 1), quaternion(*views[v].rotation), {}, uint32_t(v) + 1, view.name, {}});
        write_exr_rgb(linear_image_path(sfm(), view), ImageF(views[v].target.width, views[v].target.height, 3, 0.3f));
        gains[view.name] = {1, 1, 1};
        rigs[view.name] = std::string(photo) + ".jpg";
      }
    write_colmap_model(sfm() / "sparse/0", model, ColmapFormat::Binary);
    write_gains(sfm() / "sfm/gains.json", gains);
    write_scene_info(sfm() / "scene.json", {});
    write_rigs(sfm(), rigs);
    write_json_file(sfm() / "sfm/lenses.json", {{"cameras", cameras}});
  }
  fs::path sfm() const { return folder.path() / "sfm"; }
  fs::path given() const { return folder.path() / "given"; }
  void put(const fs::path& relative, const Image8& mask) const {
    make_folders((given() / relative).parent_path());
    write_ldr(given() / relative, mask);
  }
  std::unique_ptr<RecordingContext> run(std::map<std::string, fs::path> inputs) const {
    auto context = std::make_unique<RecordingContext>(std::move(inputs));
    MasksConfig config;
    config.transparent.source = config.specular.source = MaskSourceKind::None;
    run_masks(config, *context);
    return context;
  }
  static Image8 mask_of(const RecordingContext& context, const char* kind, const char* stem) {
    return read_grey8(context.output() / "masks" / kind / (std::string(stem) + ".png"));
  }

  TemporaryFolder folder;
  std::vector<Undistortion> views;
};

TEST_F(CutViews, WhatTheLensDoesNotShowIsIgnoredWithoutAnyMask) {
  const auto context = run({{"sfm", sfm()}});
  size_t unseen_anywhere = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    const ImageF unseen = unseen_pixels(views[v]);
    const Image8 ignore = mask_of(*context, "ignore", fmt::format("b/view_{:02}", v).c_str());
    ASSERT_EQ(ignore.width(), views[v].target.width);
    for (size_t i = 0; i < ignore.pixel_count(); ++i)
      ASSERT_EQ(ignore.data()[i], unseen.pixel_count() > 0 && unseen.data()[i] > 0 ? 255 : 0);
    unseen_anywhere += unseen.pixel_count() > 0;
  }
  EXPECT_EQ(unseen_anywhere, 4u) << "the view ahead is seen everywhere";
  EXPECT_EQ(mask_origin(context->output(), MaskClass::Ignore).source, "lens");
}

TEST_F(CutViews, MasksOfThePhotosAreCutAndUnseenPixelsAreAdded) {
  put("ignore/a.png", disk_mask(kCutSide, kCutSide, 14));                       // around the axis of the lens
  put("object/a.png", disk_mask(kCutSide, kCutSide, 9, 60 + 1.25 * 38.2, 60));  // 72 degrees to the right
  const auto context = run({{"sfm", sfm()}, {"masks", given()}});
  const Image8 ahead = mask_of(*context, "ignore", "a/view_00");
  const Intrinsics& k = views[0].target;
  EXPECT_EQ(ahead.at(int(k.cx), int(k.cy)), 255);
  EXPECT_EQ(ahead.at(2, 2), 0);
  EXPECT_GT(coverage(mask_of(*context, "ignore", "a/view_01")), 0.03) << "unseen pixels";
  EXPECT_EQ(coverage(mask_of(*context, "ignore", "b/view_00")), 0);
  EXPECT_GT(coverage(mask_of(*context, "ignore", "b/view_01")), 0.03) << "of a photo without a mask";
  const Vec3d to_the_right{std::sin(1.25), 0, std::cos(1.25)};
  const Vec3d in_view = *views[1].rotation * to_the_right;
  const Intrinsics& right = views[1].target;
  const int x = int(right.fx * in_view.x / in_view.z + right.cx), y = int(right.fy * in_view.y / in_view.z + right.cy);
  EXPECT_EQ(mask_of(*context, "object", "a/view_01").at(x, y), 255);
  EXPECT_EQ(coverage(mask_of(*context, "object", "a/view_02")), 0);
}

TEST_F(CutViews, AMaskNamedAfterAViewIsOfTheView) {
  put("object/a/view_00.png", disk_mask(views[0].target.width, views[0].target.height, 10));
  const auto context = run({{"sfm", sfm()}, {"masks", given()}});
  EXPECT_EQ(mask_of(*context, "object", "a/view_00"), disk_mask(views[0].target.width, views[0].target.height, 10));
}

}  // namespace
}  // namespace vitrine
