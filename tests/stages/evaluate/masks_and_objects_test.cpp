// Masks and the table of objects: what is judged, and by which regions.
#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/color.h"
#include "tests/stages/evaluate/metrics_of.h"
#include "tests/support/error_of.h"
#include "tests/support/tiny_capture.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

using nlohmann::json;
using test::metrics_of, test::quick;
using test::RecordingContext;
using test::TinyCapture;

// A mask as the masks stage writes it: columns [x0, x1) belong to the class.
void write_stage_mask(const fs::path& artifact, const char* kind, const View& v, int x0, int x1,
                      int width = TinyCapture::kWidth) {
  make_folders(artifact / "masks" / kind);
  Image16 mask(width, TinyCapture::kHeight, 1);
  for (int y = 0; y < mask.height(); ++y)
    for (int x = x0; x < x1; ++x) mask.at(x, y) = 65535;
  write_png16(artifact / "masks" / kind / (v.stem() + ".png"), mask);
}

// The photo is wrong outside the object: that counts in a scene that was trained whole, and not in an object trained alone.
TEST(EvaluateStage, AnObjectThatWasTrainedAloneIsJudgedAlone) {
  const TinyCapture capture;
  const View& v = capture.views[0];
  const TemporaryFolder masks;
  constexpr int kLeft = 24, kRight = 40;
  write_stage_mask(masks.path(), "object", v, kLeft, kRight);
  write_stage_mask(masks.path(), "specular", v, kLeft - 8, kLeft + 8);
  test::write_objects_artifact(masks.path(), masks.path(), {v});
  ImageF photo = capture.photo(v);
  for (int y = 0; y < photo.height(); ++y)
    for (int x = 0; x < photo.width(); ++x)
      if (x < kLeft || x >= kRight)
        for (int c = 0; c < 3; ++c) photo.at(x, y, c) = 0.9f;
  write_exr_rgb(linear_image_path(capture.sfm(), v), photo, ExrPrecision::Float);
  auto inputs = capture.inputs(false);
  inputs["masks"] = inputs["objects"] = masks.path();
  const auto judged = [&](bool alone) {
    capture.write_split({0}, {1, 2, 3, 4, 5, 6, 7}, alone);
    RecordingContext context(inputs);
    json m = metrics_of(context, quick());
    const Image8 shown = read_srgb8(context.output() / "eval" / (v.stem() + "_gt.png"));
    EXPECT_EQ(shown.at(2, 2) == 0, alone);
    return m;
  };
  const json whole = judged(false), alone = judged(true);
  EXPECT_LT(whole["heldout"]["psnr"].get<double>(), 15);
  EXPECT_LT(whole["heldout"]["ssim"].get<double>(), 0.8);
  EXPECT_GT(whole["heldout"]["flip"].get<double>(), 0.1);
  EXPECT_LT(whole["regions"]["specular"]["psnr"].get<double>(), 15);
  EXPECT_GT(alone["heldout"]["psnr"].get<double>(), 45);
  EXPECT_GT(alone["heldout"]["ssim"].get<double>(), 0.98);
  EXPECT_LT(alone["heldout"]["flip"].get<double>(), 0.02);
  EXPECT_GT(alone["regions"]["specular"]["psnr"].get<double>(), 45);  // its half on the object
}

// The photo shows a grey wall where the scene has its coloured ball. Where the object was trained alone, nothing outside its
// masks counts; nor does what the masks leave out.
TEST(EvaluateStage, NeutralPixelsOfAPhotoAreComparedWithTheRenderWhereItWasTrained) {
  const TinyCapture capture;
  const View& v = capture.views[0];
  EvaluateConfig config = quick();
  config.min_region_pixels = 20;
  RecordingContext plain(capture.inputs(false));
  write_exr_rgb(linear_image_path(capture.sfm(), v), ImageF(TinyCapture::kWidth, TinyCapture::kHeight, 3, 0.6f),
                ExrPrecision::Float);
  const json m = metrics_of(plain, config);
  EXPECT_GT(m["neutral"]["shift"].get<double>(), 0.1);
  EXPECT_EQ(m["neutral"]["photo"], v.name);
  EXPECT_EQ(m["neutral"]["views"], 1);
  EXPECT_EQ(plain.metrics.at("neutral.shift"), m["neutral"]["shift"].get<double>());
  const auto with_masks = [&](const char* kind, int x0, int x1, bool alone) {
    const TemporaryFolder masks;
    write_stage_mask(masks.path(), kind, v, x0, x1);
    capture.write_split({0}, {1, 2, 3, 4, 5, 6, 7}, alone);
    auto inputs = capture.inputs(false);
    inputs["masks"] = inputs["objects"] = test::write_objects_artifact(masks.path(), masks.path(), {v});
    RecordingContext context(inputs);
    return metrics_of(context, config).contains("neutral");
  };
  EXPECT_TRUE(with_masks("object", 0, 2, false));
  EXPECT_FALSE(with_masks("object", 0, 2, true));
  EXPECT_TRUE(with_masks("ignore", 0, 2, false));
  EXPECT_FALSE(with_masks("ignore", 0, TinyCapture::kWidth, false));
  EXPECT_FALSE(with_masks("transparent", 0, TinyCapture::kWidth, false));
}

// What stands still with the object was trained as well: its masks are the scene's own.
TEST(EvaluateStage, WhatWasTrainedWithTheObjectIsJudgedWithIt) {
  const TinyCapture capture;
  const View& v = capture.views[0];
  const TemporaryFolder masks;
  write_stage_mask(masks.path(), "object", v, 24, 40);
  write_stage_mask(capture.optimize() / "optimize/trained", "object", v, 16, 48);
  capture.write_split({0}, {1, 2, 3, 4, 5, 6, 7}, true);
  auto inputs = capture.inputs(false);
  inputs["masks"] = masks.path();
  RecordingContext context(inputs);
  metrics_of(context, quick());
  const Image8 shown = read_srgb8(context.output() / "eval" / (v.stem() + "_gt.png"));
  bool beside = false;
  for (int y = 0; y < shown.height(); ++y) {
    EXPECT_EQ(shown.at(12, y), 0);
    beside |= shown.at(20, y) > 0;
  }
  EXPECT_TRUE(beside);
}

// No surfel has the id of a guessed object: its pixels would count as mistakes.
TEST(EvaluateStage, AGuessedObjectHasNoFigures) {
  const TinyCapture capture;
  const View& v = capture.views[0];
  const TemporaryFolder masks;
  write_stage_mask(masks.path(), "transparent", v, 0, 20);
  write_stage_mask(masks.path(), "specular", v, 16, 32);
  SplatLayer layer = capture.layer;
  layer.set_object_ids(std::vector<uint16_t>(layer.size(), 0));
  write_layer(capture.optimize() / "gaussians/diffuse.ply", layer);
  for (const ObjectTrust trust : {ObjectTrust::Guessed, ObjectTrust::Given}) {
    const ObjectSet set{.objects = {{.id = 1, .name = "case", .role = ObjectRole::ThinGlass},
                                    {.id = 2, .name = "spoon", .role = ObjectRole::Mirror, .trust = trust}},
                        .shapes = {}};
    const TemporaryFolder objects;
    auto inputs = capture.inputs(false);
    inputs["objects"] = test::write_objects_artifact(objects.path(), masks.path(), {v}, set);
    RecordingContext context(inputs);
    const json m = metrics_of(context, quick());
    const bool guessed = trust == ObjectTrust::Guessed;
    ASSERT_EQ(m["objects"].size(), guessed ? 1u : 2u);
    EXPECT_EQ(m["objects"][0]["name"], "case");
    if (guessed)
      EXPECT_EQ(m["surfel_objects"], 1.0);
    else
      EXPECT_LT(m["surfel_objects"], 1.0);
    EXPECT_TRUE(m["regions"].contains("specular")) << "regions are of all objects";
  }
}

TEST(EvaluateStage, RegionsComeFromTheObjectsWhereTheTruthHasNone) {
  const TinyCapture capture;
  const View& v = capture.views[0];
  const TemporaryFolder masks;
  const auto write = [&](const char* kind, int x0, int x1, int width) { write_stage_mask(masks.path(), kind, v, x0, x1, width); };
  write("transparent", 0, 20, TinyCapture::kWidth);
  write("specular", 16, 32, TinyCapture::kWidth);
  ImageF photo = capture.photo(v);
  for (int y = 0; y < photo.height(); ++y)
    for (int x = 16; x < 32; ++x)
      for (int c = 0; c < 3; ++c) photo.at(x, y, c) = linear_from_srgb(srgb_from_linear(photo.at(x, y, c)) + 0.1f);
  write_exr_rgb(linear_image_path(capture.sfm(), v), photo, ExrPrecision::Float);
  auto inputs = capture.inputs(false);
  inputs["objects"] = test::write_objects_artifact(masks.path(), masks.path(), {v});
  RecordingContext context(inputs);
  const json m = metrics_of(context, quick()), r = m["regions"];
  EXPECT_EQ(r["masks"], "objects");
  ASSERT_EQ(m["objects"].size(), 2u);
  for (const json& object : m["objects"]) {
    EXPECT_EQ(object["views"], 1);
    EXPECT_NEAR(object["psnr"].get<double>(), object["name"] == "glass" ? 20 + 10 * std::log10(5.0) : 20, 0.01) << object;
  }
  EXPECT_NEAR(r["specular"]["psnr"].get<double>(), 20 + 10 * std::log10(2.0), 0.01) << "glass reflects as well";
  EXPECT_NEAR(r["reflective"]["psnr"].get<double>(), 20, 0.01);
  EXPECT_NEAR(r["transparent"]["psnr"].get<double>(), 20 + 10 * std::log10(5.0), 0.01);
  EXPECT_GT(r["rest"]["psnr"].get<double>(), 45);
  write_ldr(label_path(masks.path(), v), Image8(8, 6, 3));
  RecordingContext wrong(inputs);
  EXPECT_EQ(error_of([&] { run_evaluate(quick(), wrong); }).detail().code, "BAD_LABELS");
}

}  // namespace
}  // namespace vitrine
