// Regions of coats and of mirrors, on a capture whose scene is the truth itself.
#include <gtest/gtest.h>

#include "core/foundation/math/color.h"
#include "stages/evaluate/evaluate.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_capture.h"

namespace vitrine {
namespace {

using nlohmann::json;
using test::RecordingContext;
using test::TinyCapture;

json metrics_of_regions(RecordingContext& context) {
  EvaluateConfig config;
  config.mesh_samples = 200;
  run_evaluate(config, context);
  return json::parse(read_file(context.output() / "eval/metrics.json"));
}

TEST(EvaluateRegions, WhatIsReflectiveIsDividedWhereTheTruthKnowsCoats) {
  const TinyCapture capture;
  capture.write_truth(1);
  const View& v = capture.views[0];
  constexpr int kGlassUntil = 8, kCoatUntil = 32, kMirrorUntil = 40;
  capture.write_mask("transparent", v, 0, kGlassUntil);
  capture.write_mask("specular", v, 4, kMirrorUntil);
  // The photo is wrong by 0.1 in sRGB in the coat; the truth's normals point the other way in the mirror.
  ImageF photo = capture.photo(v);
  for (int y = 0; y < photo.height(); ++y)
    for (int x = kGlassUntil; x < kCoatUntil; ++x)
      for (int c = 0; c < 3; ++c) photo.at(x, y, c) = linear_from_srgb(srgb_from_linear(photo.at(x, y, c)) + 0.1f);
  write_exr_rgb(linear_image_path(capture.sfm(), v), photo, ExrPrecision::Float);
  const fs::path normals = capture.truth() / "normal" / (v.stem() + ".exr");
  ExrImage normal = read_exr(normals);
  for (int y = 0; y < normal.pixels.height(); ++y)
    for (int x = kCoatUntil; x < kMirrorUntil; ++x)
      for (int c = 0; c < 3; ++c) normal.pixels.at(x, y, c) *= -1;
  write_exr(normals, normal);

  RecordingContext before(capture.inputs(true));
  const json without_coats = metrics_of_regions(before);
  for (const char* region : {"mirror", "coated"}) {
    EXPECT_FALSE(without_coats["regions"].contains(region)) << region;
    EXPECT_FALSE(without_coats["truth"]["regions"].contains(region)) << region;
  }
  EXPECT_TRUE(without_coats["regions"].contains("reflective"));

  capture.write_mask("coated", v, 6, kCoatUntil);
  RecordingContext context(capture.inputs(true));
  const json m = metrics_of_regions(context);
  const json &r = m["regions"], &n = m["truth"]["regions"];
  EXPECT_NEAR(r["coated"]["psnr"].get<double>(), 20, 0.01);  // without the two columns that are glass
  EXPECT_GT(r["mirror"]["psnr"].get<double>(), 45);
  EXPECT_NEAR(r["reflective"]["psnr"].get<double>(), 20 + 10 * std::log10(32.0 / 24), 0.01);
  EXPECT_GT(r["rest"]["psnr"].get<double>(), 45);
  EXPECT_NEAR(r["coated"]["pooled_psnr"].get<double>(), r["coated"]["psnr"].get<double>(), 1e-9);  // of one view
  EXPECT_GT(r["rest"]["correlation"].get<double>(), 0.9);
  EXPECT_LT(n["coated"]["normal_mae_deg"].get<double>(), 3);
  EXPECT_LT(n["coated"]["normal_median_deg"].get<double>(), 3);
  EXPECT_GT(n["mirror"]["normal_mae_deg"].get<double>(), 170);
  EXPECT_GT(n["mirror"]["normal_median_deg"].get<double>(), 170);
  const std::string csv = read_file(context.output() / "eval/per_view.csv");
  EXPECT_NE(csv.find(",psnr_mirror,psnr_coated,"), std::string::npos) << csv;
}

TEST(EvaluateRegions, CoatsThatTheSpecularMaskLeavesOutAreNotTheRest) {
  const TinyCapture capture;
  const View& v = capture.views[0];
  capture.write_mask("coated", v, 16, 32);
  ImageF photo = capture.photo(v);
  for (int y = 0; y < photo.height(); ++y)
    for (int x = 16; x < 32; ++x) photo.at(x, y, 0) = 1;
  write_exr_rgb(linear_image_path(capture.sfm(), v), photo, ExrPrecision::Float);
  RecordingContext context(capture.inputs(true));
  const json r = metrics_of_regions(context)["regions"];
  EXPECT_LT(r["coated"]["psnr"].get<double>(), 22);
  EXPECT_GT(r["rest"]["psnr"].get<double>(), 45);
  EXPECT_FALSE(r.contains("mirror"));
}

}  // namespace
}  // namespace vitrine
