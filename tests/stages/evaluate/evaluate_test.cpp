// The whole stage on a capture whose scene is the truth itself.
#include "stages/evaluate/evaluate.h"

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/color.h"
#include "core/render/picture/view_picture.h"
#include "core/scene/image/metrics.h"
#include "tests/stages/evaluate/metrics_of.h"
#include "tests/support/error_of.h"
#include "tests/support/feature_network_file.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_capture.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

using nlohmann::json;
using test::metrics_of, test::quick;
using test::RecordingContext;
using test::TinyCapture;

TEST(EvaluateStage, TrueSceneScoresAbove45Decibels) {
  const TinyCapture capture;
  RecordingContext context(capture.inputs(false));
  const json m = metrics_of(context, quick());
  EXPECT_GT(m["heldout"]["psnr"].get<double>(), 45);
  EXPECT_GT(m["heldout"]["ssim"].get<double>(), 0.999);
  EXPECT_LT(m["heldout"]["flip"].get<double>(), 0.02);
  EXPECT_GT(m["train"]["psnr"].get<double>(), 45);
  EXPECT_EQ(m["heldout"]["views"], 1);
  EXPECT_EQ(m["train"]["views"], 7);
  EXPECT_EQ(m["resolution"]["width"], TinyCapture::kWidth);
  EXPECT_FALSE(m["heldout"].contains("lpips"));  // without weights
  EXPECT_FALSE(m.contains("truth"));
  EXPECT_FALSE(m.contains("regions"));
  for (const char* file : {"view_0_gt.png", "view_0_pred.png", "view_0_err.png", "contact_sheet.jpg", "per_view.csv"})
    EXPECT_TRUE(fs::exists(context.output() / "eval" / file)) << file;
  EXPECT_FALSE(fs::exists(context.output() / "eval/view_1_gt.png"));  // a training view
  EXPECT_EQ(context.metrics.at("heldout.psnr"), m["heldout"]["psnr"].get<double>());
}

TEST(EvaluateStage, LpipsIsMeasuredWithWeights) {
  const TinyCapture capture;
  const TemporaryFolder folder;
  const auto layers = vitrine::testing::small_network();
  vitrine::testing::write_network(folder.path() / "lpips.safetensors", layers,
                                  {std::vector<float>(size_t(layers[1].out), 1), std::vector<float>(size_t(layers[2].out), 1)});
  RecordingContext context(capture.inputs(false));
  EvaluateConfig config = quick();
  config.lpips = (folder.path() / "lpips.safetensors").string();
  const json right = metrics_of(context, config);
  SplatLayer grey = capture.layer;
  for (size_t i = 0; i < grey.size(); ++i) std::fill_n(grey.at(Attribute::ShDc, i), 3, 0.f);
  write_layer(capture.optimize() / "gaussians/diffuse.ply", grey);
  RecordingContext without(capture.inputs(false));
  const json wrong = metrics_of(without, config);
  EXPECT_LT(right["heldout"]["lpips"].get<double>(), 0.3 * wrong["heldout"]["lpips"].get<double>());
  EXPECT_GT(right["train"]["lpips"].get<double>(), 0);
}

// Colours of one side that photos do not have: training photos know it, and held-out ones see it.
TEST(EvaluateStage, ConfidenceFromTrainingPhotosRanksErrorsOfOthers) {
  const TinyCapture capture;
  SplatLayer wrong = capture.layer;
  Rng rng(4, 1);
  for (size_t i = 0; i < wrong.size(); ++i) {
    const float* m = wrong.at(Attribute::Mean, i);
    const float shift = 0.6f * std::max(0.f, m[2] / float(TinyCapture::kRadius)) + 0.02f * float(rng.uniform_double());
    for (size_t c = 0; c < 3; ++c) wrong.at(Attribute::ShDc, i)[c] += shift / 0.28f;
  }
  write_layer(capture.optimize() / "gaussians/diffuse.ply", wrong);
  RecordingContext context(capture.inputs(false));
  const json c = metrics_of(context, quick())["confidence"];
  EXPECT_GT(c["rank_correlation"].get<double>(), 0.6);
  EXPECT_LT(c["mean"].get<double>(), 0.9);
  EXPECT_GT(c["pixels"].get<int>(), 500);
  EXPECT_TRUE(fs::exists(context.output() / "eval/view_0_conf.png"));
}

TEST(EvaluateStage, GainsOfTheViewsAreApplied) {
  const TinyCapture capture;
  Gains gains = read_gains(capture.sfm() / "sfm/gains.json");
  gains["view_0.png"] = {0.5, 0.5, 0.5};
  write_gains(capture.sfm() / "sfm/gains.json", gains);
  RecordingContext context(capture.inputs(false));
  const json m = metrics_of(context, quick());
  EXPECT_LT(m["heldout"]["psnr"].get<double>(), 30);
  EXPECT_GT(m["train"]["psnr"].get<double>(), 45);
}

TEST(EvaluateStage, TruthOfTheSameSceneHasSmallErrors) {
  const TinyCapture capture;
  capture.write_truth();
  RecordingContext context(capture.inputs(true));
  const json t = metrics_of(context, quick())["truth"];
  EXPECT_LT(t["pose"]["rotation_deg"].get<double>(), 1e-6);
  EXPECT_LT(t["pose"]["centre_rel"].get<double>(), 1e-9);
  EXPECT_NEAR(t["pose"]["truth_units_per_scene_unit"].get<double>(), 1.7, 1e-9);
  EXPECT_LT(t["normal_mae_deg"].get<double>(), 3);  // flat surfels on a round ball: seen 1.8
  EXPECT_LT(t["depth_rel"].get<double>(), 0.01);
  EXPECT_GT(t["mesh"]["fscore"].get<double>(), 0.999);
  EXPECT_LT(t["mesh"]["chamfer_rel"].get<double>(), 0.002);
  for (const char* key : {"accuracy_rel", "completeness_rel"}) EXPECT_TRUE(t["mesh"].contains(key)) << key;
  EXPECT_GT(t["mesh"]["samples"]["truth"].get<double>(), 10'000);
}

TEST(EvaluateStage, RegionsScoreTheirOwnPixelsOnly) {
  const TinyCapture capture;
  const View& v = capture.views[0];
  capture.write_mask("transparent", v, 0, 20);
  capture.write_mask("specular", v, 16, 32);
  capture.write_mask("object", v, 30, 34);
  // The photo is wrong by exactly 0.1 in sRGB, where it is mid grey, in the specular columns only.
  ImageF photo = capture.photo(v);
  for (int y = 0; y < photo.height(); ++y)
    for (int x = 16; x < 32; ++x)
      for (int c = 0; c < 3; ++c) photo.at(x, y, c) = linear_from_srgb(srgb_from_linear(photo.at(x, y, c)) + 0.1f);
  write_exr_rgb(linear_image_path(capture.sfm(), v), photo, ExrPrecision::Float);
  RecordingContext context(capture.inputs(true));
  const json m = metrics_of(context, quick());
  const json& r = m["regions"];
  EXPECT_NEAR(r["specular"]["psnr"].get<double>(), 20, 0.01);                            // -20 log10(0.1)
  EXPECT_NEAR(r["transparent"]["psnr"].get<double>(), 20 + 10 * std::log10(5.0), 0.01);  // 4 of 20 columns are wrong
  EXPECT_EQ(r["masks"], "truth");
  EXPECT_NEAR(r["reflective"]["psnr"].get<double>(), 20, 0.01);                     // specular, not glass
  EXPECT_NEAR(r["object"]["psnr"].get<double>(), 20 + 10 * std::log10(2.0), 0.01);  // 2 of 4
  EXPECT_GT(r["rest"]["psnr"].get<double>(), 45);
  EXPECT_EQ(r["rest"]["views"], 1);
  EXPECT_TRUE(m["not_measured"].contains("truth.pose"));  // no transforms.json, and it says so
}

TEST(EvaluateStage, WithoutAMeshTheOtherFiguresStay) {
  const TinyCapture capture;
  capture.write_truth(1);
  auto inputs = capture.inputs(true);
  inputs.erase("mesh");
  RecordingContext context(inputs);
  const json m = metrics_of(context, quick());
  EXPECT_GT(m["heldout"]["psnr"].get<double>(), 45);
  EXPECT_LT(m["truth"]["normal_mae_deg"].get<double>(), 3);
  EXPECT_FALSE(m["truth"].contains("mesh"));
  EXPECT_EQ(m["not_measured"]["truth.mesh"], "there is no mesh artifact");
}

// The sphere photographed through haze: I against the photos, J against the truth in air.
TEST(EvaluateStage, ASceneInHazeIsScoredWithAndWithoutIt) {
  TinyCapture capture;
  capture.write_truth();
  const View& v = capture.views[0];
  make_folders(capture.truth() / "clear");
  write_exr_rgb(capture.truth() / "clear" / (v.stem() + ".exr"), capture.photo(v), ExrPrecision::Float);
  ImageOptions image;
  image.medium = MediumCoefficients<double>{{0.4, 0.4, 0.4}, {0.4, 0.4, 0.4}, {0.5, 0.55, 0.6}};
  write_image_options(capture.optimize() / "optimize/model.json", image);
  ScenePainter painter(read_trained_scene(capture.optimize()), {.medium = true});
  ImageF hazed = painter.picture(v).linear;
  for (size_t i = 0; i < hazed.data().size(); ++i) hazed.data()[i] *= float(v.gain[i % 3]);
  write_exr_rgb(linear_image_path(capture.sfm(), v), hazed, ExrPrecision::Float);

  RecordingContext context(capture.inputs(true));
  const json m = metrics_of(context, quick());
  EXPECT_GT(m["heldout"]["psnr"].get<double>(), 45);
  EXPECT_GT(m["truth"]["clear"]["psnr"].get<double>(), 40);
  EXPECT_EQ(m["truth"]["clear"]["views"], 1);
  const ImageF clear = read_srgb(context.output() / "eval/view_0_clear.png"),
               seen = read_srgb(context.output() / "eval/view_0_pred.png");
  EXPECT_GT(psnr(clear, srgb_from_linear_image(capture.photo(v))), 40);
  EXPECT_LT(psnr(seen, clear), 20);
}

// The sphere turned to glass with a ball in it: layers, what lies behind the glass, and the glass itself.
TEST(EvaluateStage, LayeredSceneIsTakenApartAndScoredBehindItsGlass) {
  TinyCapture capture;
  capture.write_truth();
  const SplatLayer ball = test::sphere_layer(0.36, 900);  // fills the mask: no silhouette, where tracing has no low-pass
  SplatLayer inner(LayerKind::Transmittance, 0, ball.size());
  for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc})
    std::ranges::copy(ball.values(a), inner.values(a).begin());
  std::ranges::fill(capture.layer.values(Attribute::Transmission), 6.f);
  std::ranges::fill(capture.layer.values(Attribute::SpecularWeight), -8.f);
  write_layer(capture.optimize() / "gaussians/diffuse.ply", capture.layer);
  write_layer(capture.optimize() / "gaussians/transmittance.ply", inner);
  const View& v = capture.views[0];
  capture.write_mask("transparent", v, 26, 38);
  capture.layer = ball;  // photo() shows the scene without its glass now, times the gain
  make_folders(capture.truth() / "transmitted");
  write_exr_rgb(capture.truth() / "transmitted" / (v.stem() + ".exr"), capture.photo(v), ExrPrecision::Float);

  RecordingContext context(capture.inputs(true));
  const json m = metrics_of(context, quick());
  const json& t = m["truth"];
  EXPECT_GT(t["transmitted"]["psnr"].get<double>(), 38) << t["transmitted"];
  EXPECT_EQ(t["transmitted"]["views"], 1);
  EXPECT_LT(t["regions"]["transparent"]["normal_mae_deg"].get<double>(), 3);  // of the glass, not of the ball
  EXPECT_LT(t["regions"]["transparent"]["depth_rel"].get<double>(), 0.01);
  EXPECT_EQ(m["surfels"], 1800 + 900);
  const fs::path layers = context.output() / "eval/layers";
  for (const char* layer : {"radiance", "diffuse", "transmission", "transmitted", "transmission_weight", "normal", "depth"})
    EXPECT_TRUE(fs::exists(layers / layer / "view_0.exr")) << layer;
  EXPECT_FALSE(fs::exists(layers / "reflection"));
  // The parts sum up to the whole.
  const ImageF whole = read_exr(layers / "radiance/view_0.exr").pixels, front = read_exr(layers / "diffuse/view_0.exr").pixels;
  const ImageF behind = read_exr(layers / "transmission/view_0.exr").pixels;
  for (size_t i = 0; i < whole.data().size(); ++i)
    ASSERT_NEAR(whole.data()[i], front.data()[i] + behind.data()[i], 2e-3f);  // half floats
}

TEST(EvaluateStage, DisplacedMeshLosesItsFScore) {
  const TinyCapture capture;
  capture.write_truth();
  // The diagonal of the ball is 2 sqrt(3) r; 4 % of it is far beyond the threshold of 1 %.
  TriMesh grown = test::sphere_mesh(TinyCapture::kRadius * (1 + 0.04 * 2 * std::sqrt(3.0)));
  write_mesh_ply(capture.mesh() / "mesh/mesh.ply", grown);
  RecordingContext context(capture.inputs(true));
  const json mesh = metrics_of(context, quick())["truth"]["mesh"];
  EXPECT_NEAR(mesh["accuracy_rel"].get<double>(), 0.04, 0.001);
  EXPECT_NEAR(mesh["completeness_rel"].get<double>(), 0.04, 0.001);
  EXPECT_NEAR(mesh["chamfer_rel"].get<double>(), 0.04, 0.001);
  EXPECT_EQ(mesh["fscore"].get<double>(), 0);
}

TEST(EvaluateStage, WithoutHeldOutViewsItSaysSoAndScoresTraining) {
  const TinyCapture capture;
  capture.write_split({}, {0, 1, 2});
  RecordingContext context(capture.inputs(false));
  const json m = metrics_of(context, quick());
  EXPECT_FALSE(m.contains("heldout"));
  EXPECT_TRUE(m["not_measured"].contains("heldout"));
  EXPECT_EQ(m["train"]["views"], 3);
  EXPECT_FALSE(context.warnings.empty());
}

TEST(EvaluateStage, ForeignTruthIsAWarningNotAnEnd) {
  const TinyCapture capture;
  capture.write_truth();
  std::string text = read_file(capture.truth() / "transforms.json");
  for (size_t at; (at = text.find("view_")) != std::string::npos;) text.replace(at, 5, "shot-");
  write_file(capture.truth() / "transforms.json", text);
  RecordingContext context(capture.inputs(true));
  const json m = metrics_of(context, quick());
  EXPECT_GT(m["heldout"]["psnr"].get<double>(), 45);
  EXPECT_TRUE(m["not_measured"].contains("truth.pose"));
  EXPECT_FALSE(m["truth"].contains("normal_mae_deg"));
}

TEST(EvaluateStage, SameBytesForAnyNumberOfThreads) {
  const TinyCapture capture;
  capture.write_truth();
  RecordingContext one(capture.inputs(true)), four(capture.inputs(true));
  set_thread_limit(1);
  run_evaluate(quick(), one);
  set_thread_limit(4);
  run_evaluate(quick(), four);
  set_thread_limit(0);
  size_t files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(one.output()))
    if (entry.is_regular_file()) {
      EXPECT_EQ(read_file(entry.path()), read_file(four.output() / fs::relative(entry.path(), one.output()))) << entry.path();
      ++files;
    }
  EXPECT_EQ(files, 7u);
}

TEST(EvaluateStage, BrokenInputsAreErrorsThatNameTheFile) {
  const TinyCapture capture;
  capture.write_truth(1);
  capture.write_mask("transparent", capture.views[0], 0, 9);
  EvaluateConfig config = quick();
  config.mesh_samples = 200;
  config.mesh_views = 2;
  config.write_pictures = false;
  config.score_train_views = false;
  Rng rng(5);
  const std::vector<fs::path> files{capture.truth() / "transforms.json",
                                    capture.truth() / "depth/view_0.exr",
                                    capture.truth() / "normal/view_0.exr",
                                    capture.truth() / "mask/transparent/view_0.png",
                                    capture.truth() / "mesh.ply",
                                    capture.optimize() / "optimize/views.json",
                                    capture.optimize() / "gaussians/diffuse.ply",
                                    capture.sfm() / "linear/view_0.exr"};
  for (const fs::path& path : files) {
    const std::string good = read_file(path);
    const auto attempt = [&](const std::string& bytes, bool must_fail) {
      write_file(path, bytes);
      RecordingContext context(capture.inputs(true));
      try {
        run_evaluate(config, context);
        EXPECT_FALSE(must_fail) << path << " with " << bytes.size() << " bytes passed";
      } catch (const Error& e) {
        EXPECT_EQ(e.kind(), ErrorKind::Input) << e.what();
        EXPECT_NE(std::string(e.what()).find(path.parent_path().string()), std::string::npos) << e.what();
      }
    };
    attempt("", true);
    attempt("not a file of this kind", true);
    for (int i = 0; i < 3; ++i) attempt(good.substr(0, rng.below(uint32_t(good.size() * 9 / 10))), true);
    for (int i = 0; i < 10; ++i) {
      std::string bad = good;
      bad[rng.below(uint32_t(i < 7 ? std::min<size_t>(good.size(), 300) : good.size()))] = char(rng.below(256));
      attempt(bad, false);
    }
    write_file(path, good);
  }
}

TEST(EvaluateStage, MapsOfTheWrongShapeOrKindAreRefused) {
  const TinyCapture capture;
  capture.write_truth(1);
  const fs::path path = capture.truth() / "depth/view_0.exr";
  for (const ExrImage& wrong : {ExrImage{ImageF(50, 50, 1), {"Z"}, {}}, ExrImage{ImageF(64, 48, 2), {"A", "Q"}, {}}}) {
    write_exr(path, wrong);
    RecordingContext context(capture.inputs(true));
    try {
      run_evaluate(quick(), context);
      FAIL();
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::Input);
      EXPECT_EQ(e.detail().code, "TRUTH_BAD_MAP") << e.what();
    }
  }
}

}  // namespace
}  // namespace vitrine
