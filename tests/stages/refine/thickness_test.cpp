// A ball of glass before painted walls, photographed as solid glass by Snell's law in closed form, or as a thin shell: the stage
// finds out which, and bends its rays where that is true.
#include "stages/refine/thickness.h"

#include <gtest/gtest.h>

#include "core/foundation/math/color.h"
#include "core/render/picture/view_picture.h"
#include "stages/refine/refine.h"
#include "tests/core/render/model/snell_ball.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_capture.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

using Report = nlohmann::json;

class PaintedRoom : public ::testing::Test {
 protected:
  PaintedRoom() {
    scene = {ball.scene, test::GlassBallScene::image()};
    make_folders(masks() / "masks/transparent");
    Image8 mask(test::TinyCapture::kWidth, test::TinyCapture::kHeight, 1);
    for (const View& v : capture.views) {
      for (size_t i = 0; i < mask.pixel_count(); ++i) mask.data()[i] = ball.through(v, i) ? 255 : 0;
      write_ldr(masks() / "masks/transparent" / (v.stem() + ".png"), mask);
    }
    test::write_objects_artifact(masks(), masks(), capture.views);
    write_mesh_ply(capture.mesh() / "mesh/mesh.ply", test::sphere_mesh(ball.kBall, {}, 48, 96));
    write_file(capture.mesh() / "mesh/grid.json", R"({"voxel": 0.02})");
  }

  void photograph(bool solid) {
    ScenePainter painter(scene, {.layers = true});
    for (const View& v : capture.views) {
      ImageF photo = solid ? ball.photo(v) : *painter.picture(v).layer("radiance");
      if (!solid)
        for (size_t i = 0; i < photo.data().size(); ++i) photo.data()[i] *= float(v.gain[i % 3]);
      write_exr_rgb(linear_image_path(capture.sfm(), v), photo, ExrPrecision::Float);
    }
  }
  Report run(test::RecordingContext& context, GlassKind glass, int iterations = 0) {
    write_layer(capture.optimize() / "gaussians/diffuse.ply", scene.surfels.diffuse);
    write_layer(capture.optimize() / "gaussians/transmittance.ply", scene.surfels.transmittance);
    write_image_options(capture.optimize() / "optimize/model.json", scene.image);
    RefineConfig config;
    config.glass = glass;
    config.fine_tune.iterations = iterations;
    run_refine(config, context);
    return Report::parse(read_file(context.output() / "refine/report.json"));
  }
  std::map<std::string, fs::path> inputs() const {
    auto in = capture.inputs(false);
    in["masks"] = in["objects"] = masks();
    return in;
  }
  fs::path masks() const { return root.path() / "masks"; }
  static double figure(const Report& report, const char* which) {
    return report.at("glass").at("regions").at(0).at("psnr").at(which).get<double>();
  }
  static double glass_db(const Report& report, const char* when) { return report.at(when).at("glass").get<double>(); }

  test::TinyCapture capture;
  test::GlassBallScene ball;
  TemporaryFolder root;
  TrainedScene scene;
};

TEST_F(PaintedRoom, SolidGlassIsFoundAndItsRaysAreBent) {
  photograph(true);
  test::RecordingContext context(inputs());
  const Report report = run(context, GlassKind::Auto);
  ASSERT_EQ(report.at("glass").at("regions").size(), 1u);
  const Report& region = report.at("glass").at("regions").at(0);
  EXPECT_EQ(region.at("verdict"), "thick") << report.dump(1);
  EXPECT_GT(region.at("pixels"), 300);
  EXPECT_LT(region.at("no_exit"), 0.02);
  EXPECT_GT(figure(report, "bent"), figure(report, "straight") + 8) << report.dump(1);
  EXPECT_EQ(report.at("chosen"), "thick_glass") << report.dump(1);
  EXPECT_TRUE(report.at("glass").at("bent").get<bool>());
  EXPECT_GT(glass_db(report, "after"), glass_db(report, "before") + 8);
  EXPECT_EQ(context.metrics.at("thick_regions"), 1);

  // Whoever pictures the refined scene bends rays as the stage did.
  const TrainedScene refined = read_trained_scene(capture.optimize(), context.output());
  ASSERT_NE(refined.image.transmission.thick, nullptr);
  EXPECT_FLOAT_EQ(refined.image.transmission.thick->ior(), 1.5f);
  const View& view = capture.views[0];
  const auto error = [&](const TrainedScene& shown) {
    const ViewPicture picture = ScenePainter(shown, {}).picture(view);
    const ImageF photo = ball.photo(view);
    double sum = 0;
    for (size_t i = 0; i < photo.pixel_count(); ++i)
      if (const auto exact = ball.through(view, i); exact && exact->offset < 0.9)
        for (size_t c = 0; c < 3; ++c)
          sum += std::abs(picture.srgb.data()[3 * i + c] - srgb_from_linear(std::clamp(photo.data()[3 * i + c], 0.f, 1.f)));
    return sum;
  };
  EXPECT_LT(error(refined), 0.25 * error(scene));

  // The same bytes on one thread.
  set_thread_limit(1);
  test::RecordingContext alone(inputs());
  EXPECT_EQ(run(alone, GlassKind::Auto), report);
  set_thread_limit(0);
  for (const char* file : {"refine/thick_glass.ply", "refine/model.json"})
    EXPECT_EQ(read_file(alone.output() / file), read_file(context.output() / file)) << file;
}

TEST_F(PaintedRoom, ThinGlassStaysThinUnlessOneInsists) {
  photograph(false);
  test::RecordingContext context(inputs());
  const Report report = run(context, GlassKind::Auto);
  EXPECT_EQ(report.at("glass").at("regions").at(0).at("verdict"), "thin") << report.dump(1);
  EXPECT_GT(figure(report, "straight"), figure(report, "bent") + 8) << report.dump(1);
  EXPECT_EQ(report.at("state"), "kept");
  EXPECT_FALSE(fs::exists(context.output() / "refine/thick_glass.ply"));

  test::RecordingContext insisting(inputs());
  const Report forced = run(insisting, GlassKind::Thick);
  EXPECT_EQ(forced.at("state"), "refined");
  EXPECT_TRUE(forced.at("glass").at("bent").get<bool>());
  EXPECT_LT(glass_db(forced, "after"), glass_db(forced, "before"));
  EXPECT_NE(read_trained_scene(capture.optimize(), insisting.output()).image.transmission.thick, nullptr);
}

TEST_F(PaintedRoom, AnObjectOfSolidGlassIsThickWhateverItLooksLike) {
  photograph(false);
  const ObjectSet set{.objects = {{.id = 1, .name = "paperweight", .role = ObjectRole::SolidGlass}}, .shapes = {}};
  fs::remove_all(masks() / "objects");
  test::write_objects_artifact(masks(), masks(), capture.views, set);
  test::RecordingContext context(inputs());
  const Report report = run(context, GlassKind::Auto);
  EXPECT_EQ(report.at("state"), "refined");
  EXPECT_TRUE(report.at("glass").at("bent").get<bool>());
}

// A training on straight rays has put a picture of the bent room into the ball: here grey things that are not there.
TEST_F(PaintedRoom, WhatStraightRaysPaintedIntoSolidGlassGoes) {
  SplatLayer& painted = scene.surfels.transmittance;
  const SplatLayer grey = test::sphere_layer(0.25, 400);
  painted = SplatLayer(LayerKind::Transmittance, 0, grey.size());
  for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity})
    std::ranges::copy(grey.values(a), painted.values(a).begin());
  photograph(true);
  test::RecordingContext context(inputs());
  const Report report = run(context, GlassKind::Auto);
  EXPECT_EQ(report.at("glass").at("regions").at(0).at("verdict"), "thick") << report.dump(1);
  EXPECT_GT(figure(report, "bent_without_layer"), figure(report, "bent") + 3);
  EXPECT_EQ(report.at("chosen"), "thick_glass_clear");
  EXPECT_EQ(read_trained_scene(capture.optimize(), context.output()).surfels.transmittance.size(), 1u);

  test::RecordingContext unasked(inputs());
  EXPECT_FALSE(run(unasked, GlassKind::Thin).at("glass").contains("regions"));
  EXPECT_FALSE(fs::exists(unasked.output() / "refine/thick_glass.ply"));
}

TEST_F(PaintedRoom, FineTuningLearnsAlongBentRays) {
  photograph(true);
  for (float& v : scene.surfels.diffuse.values(Attribute::ShDc)) v -= 0.2f;
  test::RecordingContext context(inputs());
  const Report report = run(context, GlassKind::Auto, 21);
  EXPECT_EQ(report.at("chosen"), "fine_tuned") << report.dump(1);
  EXPECT_TRUE(report.at("glass").at("bent").get<bool>());
  EXPECT_GT(glass_db(report, "after"), report.at("candidates").at(0).at("psnr").at("glass").get<double>() + 0.1)
      << report.dump(1);
}

TEST_F(PaintedRoom, InsistingOnThickGlassWithoutAnyIsToldSo) {
  write_mesh_ply(capture.mesh() / "mesh/mesh.ply", TriMesh{});
  photograph(true);
  test::RecordingContext context(inputs());
  EXPECT_EQ(run(context, GlassKind::Thick).at("state"), "kept");
  EXPECT_TRUE(context.warnings.contains("NO_CLOSED_GLASS"));
}

TEST_F(PaintedRoom, ADamagedDescriptionOfThickGlassIsToldSo) {
  ImageOptions image = scene.image;
  image.transmission.thick = std::make_shared<ThickGlass>(test::sphere_mesh(ball.kBall), 1.5f, 0.02f);
  const fs::path path = root.path() / "model.json";
  write_image_options(path, image);
  const ImageOptions back = read_image_options(path);
  ASSERT_NE(back.transmission.thick, nullptr);
  EXPECT_EQ(back.transmission.thick->mesh().faces, image.transmission.thick->mesh().faces);
  EXPECT_EQ(back.transmission.thick->mesh().normals, image.transmission.thick->mesh().normals);
  const std::string text = read_file(path);
  for (const char* bad : {"0.9", "\"high\"", "null"}) {
    std::string broken = text;
    broken.replace(broken.find("1.5"), 3, bad);
    write_file(path, broken);
    EXPECT_EQ(error_of([&] { read_image_options(path); }).detail().code, "BAD_IMAGE_OPTIONS") << bad;
  }
  write_file(path, text);
  write_mesh_ply(root.path() / "thick_glass.ply", TriMesh{});
  EXPECT_EQ(error_of([&] { read_image_options(path); }).detail().code, "BAD_IMAGE_OPTIONS");
  fs::remove(root.path() / "thick_glass.ply");
  EXPECT_EQ(error_of([&] { read_image_options(path); }).kind(), ErrorKind::Input);
}

}  // namespace
}  // namespace vitrine
