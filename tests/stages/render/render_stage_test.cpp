// The program behind `vitrine render` on a capture whose scene is the truth itself.
#include "stages/render/render.h"

#include <gtest/gtest.h>

#include "core/foundation/math/color.h"
#include "core/render/picture/picture_views.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/image/metrics.h"
#include "tests/support/error_of.h"
#include "tests/support/files_below.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_capture.h"

namespace vitrine {
namespace {

using test::RecordingContext;
using test::TinyCapture;

size_t pictures_in(const fs::path& folder) {
  size_t n = 0;
  for (const auto& e : fs::directory_iterator(folder)) n += e.path().extension() == ".png";
  return n;
}

std::map<std::string, fs::path> inputs(const TinyCapture& capture, const fs::path& path = {}) {
  std::map<std::string, fs::path> in{{"sfm", capture.sfm()}, {"optimize", capture.optimize()}};
  if (!path.empty()) in["path"] = path;
  return in;
}

TEST(RenderStage, HeldOutViewsLookLikeTheirPhotos) {
  const TinyCapture capture;
  RecordingContext context(inputs(capture));
  run_render({}, context);
  const fs::path out = context.output() / "render";
  EXPECT_EQ(pictures_in(out), 1u);
  EXPECT_GT(psnr(read_srgb(out / "view_0.png"), srgb_from_linear_image(capture.photo(capture.views[0]))), 45);
  EXPECT_FALSE(fs::exists(out / "layers"));
  EXPECT_EQ(context.metrics.at("views"), 1);
}

TEST(RenderStage, AllViewsAreThoseOfTheCapture) {
  const TinyCapture capture;
  RecordingContext train(inputs(capture)), all(inputs(capture));
  run_render({.views = ViewChoice::Train}, train);
  EXPECT_EQ(pictures_in(train.output() / "render"), 7u);
  run_render({.views = ViewChoice::All}, all);
  EXPECT_EQ(pictures_in(all.output() / "render"), 8u);
  EXPECT_EQ(read_transforms_json(all.output() / "render/transforms.json").size(), 8u);
}

TEST(RenderStage, LayersOfAnOpaqueSceneAreItsRadianceAndSurface) {
  const TinyCapture capture;
  RecordingContext context(inputs(capture));
  run_render({.layers = true}, context);
  const fs::path layers = context.output() / "render/layers";
  std::set<std::string> names;
  for (const auto& e : fs::directory_iterator(layers)) names.insert(e.path().filename().string());
  EXPECT_EQ(names, (std::set<std::string>{"radiance", "diffuse", "normal", "depth"}));
  const ImageF radiance = read_exr(layers / "radiance/view_0.exr").pixels,
               diffuse = read_exr(layers / "diffuse/view_0.exr").pixels;
  EXPECT_EQ(radiance, diffuse);
  const ExrImage depth = read_exr(layers / "depth/view_0.exr"), normal = read_exr(layers / "normal/view_0.exr");
  EXPECT_EQ(depth.channels, std::vector<std::string>{"Z"});
  EXPECT_EQ(normal.channels, (std::vector<std::string>{"X", "Y", "Z"}));
  // The middle of the sphere, seen from its front.
  const View& v = capture.views[0];
  const Vec3d eye = v.centre_in_world();
  EXPECT_NEAR(depth.pixels.at(32, 24), length(eye) - TinyCapture::kRadius, 0.02);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(normal.pixels.at(32, 24, c), normalized(eye)[size_t(c)], 0.15);
}

TEST(RenderStage, AMediumIsShownOrLeftOut) {
  const TinyCapture capture;
  RecordingContext air(inputs(capture));
  run_render({}, air);
  ImageOptions image;
  image.medium = MediumCoefficients<double>{{0.5, 0.3, 0.2}, {0.4, 0.3, 0.2}, {0.1, 0.4, 0.5}};
  write_image_options(capture.optimize() / "optimize/model.json", image);
  RecordingContext seen(inputs(capture)), clear(inputs(capture));
  run_render({.layers = true}, seen);
  run_render({.without_medium = true}, clear);
  const char* file = "render/view_0.png";
  EXPECT_EQ(read_file(clear.output() / file), read_file(air.output() / file));
  const ImageF through = read_srgb(seen.output() / file), in_air = read_srgb(air.output() / file);
  EXPECT_LT(psnr(through, in_air), 20);
  // A corner shows no surface: the medium alone.
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(through.at(0, 0, c), srgb_from_linear(float(capture.views[0].gain[size_t(c)] * image.medium->veil[size_t(c)])),
                0.01);
  const fs::path layers = seen.output() / "render/layers";
  EXPECT_EQ(read_exr(layers / "clear/view_0.exr").pixels, read_exr(layers / "diffuse/view_0.exr").pixels);
}

TEST(RenderStage, APathIsRenderedWithItsOwnCameras) {
  const TinyCapture capture;
  const TemporaryFolder folder;
  std::vector<View> cameras{capture.views[3], capture.views[0]};
  cameras[0].name = "../../x/b.png", cameras[1].name = "../../x/a.png";
  write_transforms_json(folder.path() / "path.json", cameras, "images");
  RecordingContext context(inputs(capture, folder.path() / "path.json"));
  run_render({.views = ViewChoice::Path}, context);
  const fs::path out = context.output() / "render";
  EXPECT_EQ(pictures_in(out), 2u);
  // In the order of the file: b first. Cameras of a path have no photo, and so no gain.
  View plain = capture.views[3];
  plain.gain = {1, 1, 1};
  EXPECT_GT(psnr(read_srgb(out / "frame_0000.png"), srgb_from_linear_image(capture.photo(plain))), 45);
  const std::vector<View> written = read_transforms_json(out / "transforms.json");
  EXPECT_EQ(written[0].name, "frame_0000.png");
  EXPECT_LT(length(written[0].centre_in_world() - capture.views[3].centre_in_world()), 1e-9);
}

TEST(RenderStage, PartsAreTheFramesOfTheWhole) {
  const TinyCapture capture;
  const auto files_of = [&](const std::string& frames) {
    RecordingContext context(inputs(capture));
    run_render({.views = ViewChoice::All, .layers = true, .width = 32, .height = 24, .frames = frames}, context);
    return test::files_below(context.output());
  };
  const auto whole = files_of(""), first = files_of("0-2"), last = files_of("3-7");
  EXPECT_TRUE(first.contains("render/layers/depth/view_2.exr"));
  EXPECT_FALSE(first.contains("render/view_3.png"));
  auto both = first;
  both.insert(last.begin(), last.end());
  EXPECT_EQ(both, whole);
  EXPECT_EQ(first.at("render/transforms.json"), whole.at("render/transforms.json")) << "no clash in one folder";
  RecordingContext context(inputs(capture));
  EXPECT_EQ(error_of([&] { run_render({.frames = "1"}, context); }).detail().code, "NO_FRAME");
  EXPECT_FALSE(fs::exists(context.output() / "render"));
}

TEST(RenderStage, AnotherSizeKeepsPixelsSquareAndTheMiddleInPlace) {
  const Intrinsics k{64, 48, 70, 72, 30, 25};
  EXPECT_EQ(covering(k, 128, 96), k.scaled_to(128, 96));
  const Intrinsics wide = covering(k, 128, 64);  // the width decides; 16 rows are cut off at the top and at the bottom
  EXPECT_EQ(wide, (Intrinsics{128, 64, 140, 144, 60, 34}));
  const TinyCapture capture;
  RecordingContext context(inputs(capture));
  run_render({.width = 40, .height = 90}, context);
  const ImageF picture = read_srgb(context.output() / "render/view_0.png");
  EXPECT_EQ(picture.width(), 40);
  EXPECT_EQ(picture.height(), 90);
}

TEST(RenderStage, BadPathsAreToldApart) {
  const TinyCapture capture;
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "path.json";
  const auto fails = [&](const std::string& text, const std::string& why) {
    write_file(path, text);
    RecordingContext context(inputs(capture, path));
    const auto error = error_of([&] { run_render({.views = ViewChoice::Path}, context); });
    EXPECT_EQ(error.kind(), ErrorKind::Input) << text;
    EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("path.json"), std::string::npos) << error.what();
  };
  const std::string frame = R"("w": 32, "h": 24, "fl_x": 30, "frames": [{"file_path": "a.png", "transform_matrix": )";
  fails("{", "ends in the middle");
  fails(R"({"frames": []})", "no frames");
  fails("{" + frame + "[[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,1]]}]}", "mirrors or flattens space");
  fails("{" + frame + "[[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]]}]}", "mirrors or flattens space");
  fails("{" + frame + "[[1,0,0,0],[0.5,1,0,0],[0,0,1,0],[0,0,0,1]]}]}", "not a rotation");
  fails("{" + frame + "[[1,0,0],[0,1,0]]}]}", "4x4");
  fails(R"({"w": 0, "h": 24, "fl_x": 30, "frames": [{"file_path": "a.png", "transform_matrix": []}]})", "not a size in pixels");
  RecordingContext nothing(inputs(capture));
  EXPECT_EQ(error_of([&] { run_render({.views = ViewChoice::Path}, nothing); }).kind(), ErrorKind::Usage);
}

TEST(RenderStage, WithoutHeldOutViewsThereIsNothingToShow) {
  const TinyCapture capture;
  capture.write_split({}, {0, 1, 2});
  RecordingContext context(inputs(capture));
  EXPECT_EQ(error_of([&] { run_render({}, context); }).detail().code, "NO_VIEWS");
}

TEST(ImageOptionsFile, KeepsWhatAPictureDependsOn) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "model.json";
  ImageOptions o;
  o.composite.blend = LayerBlend::RtrGs;
  o.reflection.lobe = Lobe::Sampled;
  o.reflection.near = 0.0237f;
  o.transmission.near = 0.05f;
  o.diffuse.near_z = 0.07f;
  write_image_options(path, o);
  const ImageOptions back = read_image_options(path);
  EXPECT_EQ(back.composite.blend, LayerBlend::RtrGs);
  EXPECT_EQ(back.reflection.lobe, Lobe::Sampled);
  EXPECT_EQ(back.reflection.near, 0.0237f);
  EXPECT_EQ(back.transmission.near, 0.05f);
  EXPECT_EQ(back.diffuse.near_z, 0.07f);
  EXPECT_EQ(back.panes.mirrored, SIZE_MAX);
  EXPECT_EQ(back.shape.set, nullptr);
  EXPECT_EQ(back.opaque.layered, 1);
  EXPECT_FALSE(back.medium);
  TriMesh mesh;
  mesh.positions = {{0, 0, 0}, {0.5f, 0, 0}, {0, 0.25f, 0.125f}};
  mesh.faces = {{0, 1, 2}};
  const SurfaceOfRevolution turned{{0.1, 0.2, 0.3}, {0, 0.6, 0.8}, {{0, -0.5}, {0.25, 0.125}, {0, 0.5}}};
  const Box box{rotation_matrix(normalized(Quatd{0.9, 0.1, -0.2, 0.3})), {-0.5, -0.2, -0.75}, {0.3, 0.2, 0.1}};
  o.panes.mirrored = 1234;
  o.opaque.layered = 0.625f;
  o.medium = MediumCoefficients<double>{{0.5, 0.25, 0.125}, {0.4375, 0.375, 0.3125}, {0.0078125, 0.5, 0.75}};
  o.shape.set = std::make_shared<const ShapeSet>(ShapeSet{{{turned, ShapeRole::Mirror, 0.0625, -1, {}},
                                                           {TriangleShape(mesh), ShapeRole::Mirror, 0.03125, 0, {}},
                                                           {box, ShapeRole::Sheet, 0.125, -1, {1, 1, 1, 1, 0, 1}}}});
  o.shape.silhouettes = false;
  write_image_options(path, o);
  const ShapeOptions out = read_image_options(path).shape;
  EXPECT_FALSE(out.silhouettes);
  ASSERT_NE(out.set, nullptr);
  ASSERT_EQ(out.set->entries.size(), 3u);
  EXPECT_EQ(read_image_options(path).panes.mirrored, 1234u);
  EXPECT_EQ(read_image_options(path).opaque.layered, 0.625f);
  ASSERT_TRUE(read_image_options(path).medium);
  EXPECT_EQ(read_image_options(path).medium->direct, o.medium->direct);
  EXPECT_EQ(read_image_options(path).medium->backscatter, o.medium->backscatter);
  EXPECT_EQ(read_image_options(path).medium->veil, o.medium->veil);
  EXPECT_EQ(out.set->entries[2].clear, o.shape.set->entries[2].clear);
  EXPECT_EQ(std::get<Box>(out.set->entries[2].shape).axes * Vec3d(1, 2, 3), box.axes * Vec3d(1, 2, 3));
  EXPECT_EQ(std::get<SurfaceOfRevolution>(out.set->entries[0].shape).axis, turned.axis);
  EXPECT_EQ(out.set->entries[1].parent, 0);
  EXPECT_EQ(out.set->entries[1].tolerance, 0.03125);
  EXPECT_EQ(std::get<TriangleShape>(out.set->entries[1].shape).mesh().positions, mesh.positions);
  for (const auto& [was, is] :
       {std::pair("0.25", "-0.25"), std::pair("0.25", "1e999"), std::pair("\"profile\"", "\"curve\""),
        std::pair("0.0625", "\"wide\""), std::pair("0.625", "1.625"), std::pair("0.0078125", "-0.5"), std::pair("0.0078125,", ""),
        std::pair("\"parent\": 0", "\"parent\": 1"), std::pair("\"kind\": \"tri", "\"kind\": \"quadri"),
        std::pair("-0.75", "0.4"), std::pair("\"clear\": [", "\"clear\": [3, ")}) {
    std::string text = read_file(path);
    const size_t at = text.find(was);
    ASSERT_NE(at, std::string::npos) << was << text;
    write_file(path, text.replace(at, std::string_view(was).size(), is));
    const Error error = error_of([&] { read_image_options(path); });
    EXPECT_EQ(error.detail().code, "BAD_IMAGE_OPTIONS") << is;
    EXPECT_FALSE(error.detail().hint.empty());
    write_image_options(path, o);
  }
  write_file(path, R"({"blend": "paint"})");
  EXPECT_EQ(error_of([&] { read_image_options(path); }).detail().code, "BAD_IMAGE_OPTIONS");
  write_file(path, "{}");
  EXPECT_EQ(error_of([&] { read_image_options(path); }).detail().code, "BAD_IMAGE_OPTIONS");
  EXPECT_EQ(read_image_options(folder.path() / "none.json").composite.blend, ImageOptions{}.composite.blend);
}

}  // namespace
}  // namespace vitrine
