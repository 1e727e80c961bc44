// Albedo and relit pictures against a truth in another frame and unit.
#include <gtest/gtest.h>

#include "core/scene/image/resample.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/surfel_colors.h"
#include "core/render/relight/relit_painter.h"
#include "stages/evaluate/evaluate.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_capture.h"

namespace vitrine::test {
namespace {

constexpr Vec3f kFactor{0.5f, 0.8f, 0.6f};  // ours = factor x truth

Vec3f paint(const float* p) { return {0.5f + 0.6f * p[0], 0.45f + 0.5f * p[1], 0.5f - 0.7f * p[2]}; }

// A sky that is bright towards one side of the truth's world.
Environment sky() {
  ImageF map(64, 32, 3);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x) {
      const float side =
          std::max(0.f, dot(lat_long_direction((float(x) + 0.5f) / 64, (float(y) + 0.5f) / 32), Vec3f{0, -0.6f, 0.8f}));
      for (int c = 0; c < 3; ++c) map.at(x, y, c) = 0.05f + (1.5f - 0.3f * float(c)) * side * side;
    }
  return Environment(map);
}

class AlbedoRelit : public testing::Test {
 protected:
  AlbedoRelit() {
    capture.write_truth(1);
    const size_t n = capture.layer.size();
    RelitScene scene;
    scene.trained.surfels.diffuse = capture.layer;
    scene.materials.resize(n);
    std::ranges::fill(scene.materials.roughness, 1.f);
    std::vector<Vec3f> truth(n);
    for (size_t i = 0; i < n; ++i) truth[i] = scene.materials.albedo[i] = paint(capture.layer.at(Attribute::Mean, i));
    scene.mesh = sphere_mesh(TinyCapture::kRadius);
    DecomposedMaterials ours = scene.materials;
    for (Vec3f& a : ours.albedo) a = hadamard(a, kFactor);
    write_decomposed_materials(decompose.path(), ours);
    write_environment(decomposed_environment_path(decompose.path()), sky());

    for (const char* f : {"albedo", "env", "relit/side"}) make_folders(capture.truth() / f);
    write_environment(capture.truth() / "env/side.exr", sky());
    SurfelColors albedo(capture.layer, truth, 0.01f);
    RelitPainter painter(std::move(scene));
    painter.set_lighting({.environment = sky().turned(cast<float>(transposed(capture.truth_from_ours.rotation))),
                          .points = {},
                          .directionals = {},
                          .areas = {}});
    for (const View& v : capture.views) {
      write_exr_rgb(capture.truth() / "albedo" / (v.stem() + ".exr"), albedo.picture(v), ExrPrecision::Float);
      write_exr_rgb(capture.truth() / "relit/side" / (v.stem() + ".exr"), painter.picture(v, {.samples = 64, .seed = 9}).radiance,
                    ExrPrecision::Float);
    }
  }

  nlohmann::json metrics(EvaluateConfig config) {
    auto inputs = capture.inputs(true);
    inputs["decompose"] = decompose.path();
    RecordingContext context(inputs);
    config.mesh_samples = 200;
    run_evaluate(config, context);
    has_relit_view = fs::exists(context.output() / "eval/relit/side/view_0.png");
    return nlohmann::json::parse(read_file(context.output() / "eval/metrics.json"));
  }

  nlohmann::json truth_figures() {
    EvaluateConfig config;
    config.relit_views = 2;
    const auto all = metrics(config);
    EXPECT_TRUE(has_relit_view);
    not_measured = all.value("not_measured", nlohmann::json::object());
    return all.at("truth");
  }

  nlohmann::json albedo_figures() {
    EvaluateConfig config;
    config.relit_samples = 0;
    return metrics(config).at("truth").at("albedo");
  }

  TinyCapture capture;
  TemporaryFolder decompose;
  nlohmann::json not_measured;
  bool has_relit_view = false;
};

TEST_F(AlbedoRelit, OneFactorPerChannelIsFoundAndTheLightIsTurnedIntoOurFrame) {
  const auto truth = truth_figures();
  const auto& albedo = truth.at("albedo");
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(albedo.at("scale")[c], 1 / kFactor[c], 0.02);
  EXPECT_GT(albedo.at("psnr"), 40);
  EXPECT_LT(albedo.at("undecomposed_psnr"), 25);
  const auto& side = truth.at("relit").at("environments").at("side");
  EXPECT_GT(side.at("psnr"), 28) << side;  // noise of 32 samples
  EXPECT_EQ(side.at("views"), 2);

  // The same light from elsewhere is noticed.
  const ImageF map = sky().map();
  ImageF upside_down(64, 32, 3);
  for (int y = 0; y < 32; ++y) std::copy_n(map.pixel(0, 31 - y), 3 * 64, upside_down.pixel(0, y));
  write_environment(capture.truth() / "env/side.exr", Environment(upside_down));
  EXPECT_LT(truth_figures().at("relit").at("environments").at("side").at("psnr"), 20);
}

// What stands behind glass is seen through it, whether surfels show the glass or a known sheet does.
TEST_F(AlbedoRelit, AlbedoBehindGlassIsSeenThroughIt) {
  std::vector<size_t> inside, outside;
  for (size_t i = 0; i < capture.layer.size(); ++i) (capture.layer.at(Attribute::Mean, i)[2] < 0 ? inside : outside).push_back(i);
  SplatScene scene{.diffuse = SplatLayer(LayerKind::Diffuse, 0, outside.size()),
                   .transmittance = SplatLayer(LayerKind::Transmittance, 0, inside.size())};
  DecomposedMaterials found;
  const auto albedo = [&](size_t i) { return hadamard(paint(capture.layer.at(Attribute::Mean, i)), kFactor); };
  const auto copy = [&](size_t from, SplatLayer& to, size_t at) {
    for (const AttributeRow& r : kAttributes)
      if (to.width(r.id) > 0) std::copy_n(capture.layer.at(r.id, from), to.width(r.id), to.at(r.id, at));
  };
  for (size_t k = 0; k < outside.size(); ++k) copy(outside[k], scene.diffuse, k), found.albedo.push_back(albedo(outside[k]));
  for (size_t k = 0; k < inside.size(); ++k)
    copy(inside[k], scene.transmittance, k), found.albedo_behind_glass.push_back(albedo(inside[k]));
  std::ranges::fill(scene.diffuse.values(Attribute::Transmission), -12.f);
  const SplatLayer glass = sphere_layer(1.1 * TinyCapture::kRadius);
  for (size_t i = 0; i < glass.size(); ++i) {
    if (glass.at(Attribute::Mean, i)[2] > 0) continue;
    const size_t at = scene.diffuse.size();
    scene.diffuse.resize(at + 1);
    for (const AttributeRow& r : kAttributes) std::copy_n(glass.at(r.id, i), glass.width(r.id), scene.diffuse.at(r.id, at));
    *scene.diffuse.at(Attribute::Transmission, at) = 6;
    found.albedo.push_back({0.3f, 0.1f, 0.2f});
  }
  found.resize(scene.diffuse.size());
  for (size_t i = 0; i < found.size(); ++i) found.transmission[i] = i < outside.size() ? 0.f : 0.99f;
  write_decomposed_materials(decompose.path(), found);
  write_layer(capture.optimize() / "gaussians/diffuse.ply", scene.diffuse);
  write_layer(capture.optimize() / "gaussians/transmittance.ply", scene.transmittance);
  for (const View& v : capture.views) {
    const auto lowest = TinyCapture::kHeight;
    capture.write_mask("object", v, 0, TinyCapture::kWidth);
    Image8 mask(TinyCapture::kWidth, lowest, 1);
    for (int y = 0; y < lowest; ++y)
      for (int x = 0; x < TinyCapture::kWidth; ++x) {  // where the ray meets the ball's lower half
        const Rigid world = inverse(v.cam_from_world);
        const Vec3d o = world.translation, d = normalized(world.rotation * v.intrinsics.ray(x + 0.5, y + 0.5));
        const double b = dot(o, d), disc = b * b - dot(o, o) + TinyCapture::kRadius * TinyCapture::kRadius;
        if (disc > 0 && (o + (-b - std::sqrt(disc)) * d).z < 0) mask.at(x, y) = 255;
      }
    make_folders(capture.truth() / "mask/transparent");
    write_ldr(capture.truth() / "mask/transparent" / (v.stem() + ".png"), mask);
  }
  ImageOptions image;
  image.transmission.glass = Glass::Thin;
  for (const bool known : {false, true}) {
    if (known) {
      const double r = 1.1 * TinyCapture::kRadius;
      const Box sheet{Mat3d::identity(), {-r, -r, -r}, {r, r, 0}};
      image.shape.set = std::make_shared<ShapeSet>(ShapeSet{{{sheet, ShapeRole::Sheet, 0.01, -1, {}}}});
    }
    write_image_options(capture.optimize() / "optimize/model.json", image);
    const auto scores = albedo_figures();
    EXPECT_GT(scores.at("psnr"), 35) << known;
    EXPECT_GT(scores.at("through_glass_psnr"), 33) << known;
  }
}

TEST_F(AlbedoRelit, ASmallerTruthIsComparedWithMeansOverItsPixels) {
  for (const View& v : capture.views) {
    const fs::path path = capture.truth() / "relit/side" / (v.stem() + ".exr");
    write_exr_rgb(path, resized(read_exr_rgb(path), TinyCapture::kWidth / 4, TinyCapture::kHeight / 4), ExrPrecision::Float);
  }
  // All pixels, the ball's outline among them: a ray through the middle of each has 25 dB.
  EXPECT_GT(truth_figures().at("relit").at("environments").at("side").at("everywhere_psnr"), 30);
}

TEST_F(AlbedoRelit, RegionsOfPicturesUnderAnotherLightAreScoredApart) {
  constexpr int kMiddle = TinyCapture::kWidth / 2, kReach = 6;  // on the ball
  for (const View& v : capture.views) {
    capture.write_mask("specular", v, kMiddle - kReach, kMiddle + kReach);
    capture.write_mask("coated", v, kMiddle - kReach, kMiddle);
    const fs::path path = capture.truth() / "relit/side" / (v.stem() + ".exr");
    ImageF truth = read_exr_rgb(path);
    for (int y = 0; y < truth.height(); ++y)
      for (int x = kMiddle; x < kMiddle + kReach; ++x)
        for (int c = 0; c < 3; ++c) truth.at(x, y, c) += 0.5f;
    write_exr_rgb(path, truth, ExrPrecision::Float);
  }
  const auto relit = truth_figures().at("relit");
  for (const auto& regions : {relit.at("regions"), relit.at("environments").at("side").at("regions")}) {
    EXPECT_GT(regions.at("coated").at("psnr"), 25) << regions;
    EXPECT_LT(regions.at("mirror").at("psnr"), 15) << regions;
    EXPECT_LT(regions.at("mirror").at("psnr"), regions.at("reflective").at("psnr")) << regions;
    EXPECT_FALSE(regions.contains("transparent"));
    EXPECT_FALSE(regions.contains("object"));  // relit.psnr
  }
}

TEST_F(AlbedoRelit, WithoutAMeshThereIsNoRelitFigure) {
  auto inputs = capture.inputs(true);
  inputs["decompose"] = decompose.path();
  inputs.erase("mesh");
  RecordingContext context(inputs);
  run_evaluate({}, context);
  const auto metrics = nlohmann::json::parse(read_file(context.output() / "eval/metrics.json"));
  EXPECT_FALSE(metrics.at("truth").contains("relit"));
  EXPECT_EQ(metrics.at("not_measured").at("truth.relit"), "there is no mesh artifact");
  EXPECT_GT(metrics.at("truth").at("albedo").at("psnr"), 40);
}

TEST_F(AlbedoRelit, WithoutAnOpaqueObjectTheOtherFiguresStay) {
  for (const View& v : capture.views) capture.write_mask("object", v, 0, 0);
  const auto truth = truth_figures();
  const auto& relit = truth.at("relit");
  EXPECT_FALSE(relit.contains("psnr"));
  EXPECT_TRUE(not_measured.contains("truth.relit.psnr"));
  const auto& side = relit.at("environments").at("side");
  EXPECT_FALSE(side.contains("psnr"));
  EXPECT_GT(side.at("everywhere_psnr"), 20);
  EXPECT_EQ(side.at("views"), 2);
}

TEST_F(AlbedoRelit, TruthThatShowsNothingOfOursIsNoFigure) {
  std::vector<View> elsewhere = capture.views;
  for (View& v : elsewhere) {
    v.cam_from_world = transformed_world(v.cam_from_world, capture.truth_from_ours);
    v.intrinsics.cx = -1000;
  }
  write_transforms_json(capture.truth() / "transforms.json", elsewhere, "../photos");
  const auto truth = truth_figures();
  EXPECT_EQ(truth.dump().find("null"), std::string::npos) << truth.dump(1);  // as JSON writes what is no number
  const auto& side = truth.at("relit").at("environments").at("side");
  EXPECT_EQ(side.at("views"), 0);
  EXPECT_FALSE(side.contains("everywhere_psnr"));
  EXPECT_FALSE(side.contains("ssim"));
}

TEST_F(AlbedoRelit, MaterialsOfAnotherSceneAreRefused) {
  DecomposedMaterials few;
  few.resize(3);
  write_decomposed_materials(decompose.path(), few);
  auto inputs = capture.inputs(true);
  inputs["decompose"] = decompose.path();
  RecordingContext context(inputs);
  try {
    run_evaluate({}, context);
    FAIL() << "no error";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_EQ(e.detail().code, "BAD_MATERIALS");
  }
}

}  // namespace
}  // namespace vitrine::test
