// USD text, the merged preview, Gaussians as glTF and SPZ, and the environment, each read without the writers' code.
#include <algorithm>
#include <cstring>
#include <regex>
#include <sstream>

#include <gtest/gtest.h>
#include <zstd.h>

#include "core/foundation/base/json.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/image/exr.h"
#include "core/render/picture/decomposed_materials.h"
#include "stages/export/bake/preview_fit.h"
#include "stages/export/export.h"
#include "tests/stages/export/float_ply.h"
#include "tests/stages/export/pane_scene.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using nlohmann::json;
using test::PaneScene;
using test::RecordingContext;

// A camera at `eye` that looks at the scene's middle.
View view_from(const Vec3d& eye) {
  const Vec3d forward = normalized(Vec3d{0, 0, 0.3} - eye), right = normalized(cross(forward, Vec3d{0, 0, 1}));
  View v;
  v.intrinsics = {48, 36, 45, 45, 24, 18};
  const Mat3d world_from_cam{right, cross(forward, right), forward};
  v.cam_from_world.rotation = transposed(world_from_cam);
  v.cam_from_world.translation = -(v.cam_from_world.rotation * eye);
  return v;
}

std::vector<View> ring() {
  std::vector<View> views;
  for (int i = 0; i < 8; ++i) views.push_back(view_from({2.5 * std::cos(0.785 * i), 2.5 * std::sin(0.785 * i), 1.5}));
  return views;
}

// Behind the pane stands a bright red wall that is seen through the glass only.
TrainedScene scene_behind_glass() {
  const PaneScene pane;
  TrainedScene scene;
  scene.surfels.diffuse = pane.diffuse;
  scene.surfels.reflection = SplatLayer(LayerKind::Reflection, 0, 0);
  SplatLayer& wall = scene.surfels.transmittance;
  wall = SplatLayer(LayerKind::Transmittance, 0, 100);
  size_t i = 0;
  test::for_grid(10, {0, 0, 0.5f}, {0, 0.4f, 0}, {0, 0, 0.4f}, [&](const Vec3f& p, float, float) {
    wall.at(Attribute::Mean, i)[0] = p.x - 0.1f;
    wall.at(Attribute::Mean, i)[1] = p.y, wall.at(Attribute::Mean, i)[2] = p.z;
    std::memcpy(wall.at(Attribute::Rotation, i), pane.diffuse.at(Attribute::Rotation, pane.diffuse.size() - 1), 16);
    for (size_t c = 0; c < 2; ++c) wall.at(Attribute::LogScale, i)[c] = std::log(0.05f);
    *wall.at(Attribute::Opacity, i) = logit(0.95f);
    const Vec3f red{0.9f, 0.05f, 0.05f};
    for (size_t c = 0; c < 3; ++c) wall.at(Attribute::ShDc, i)[c] = (red[c] - 0.5f) / kShDc;
    ++i;
  });
  scene.image.diffuse.sh_degree = 1;
  return scene;
}

TEST(PreviewFit, PaintsOntoThePaneWhatIsSeenThroughIt) {
  const TrainedScene scene = scene_behind_glass();
  const PreviewFit fit = fit_preview(scene, ring(), {.views = 8, .max_side = 48, .steps = 10});
  EXPECT_GT(fit.psnr_after, fit.psnr_before + 3);
  EXPECT_GT(fit.psnr_after, 20);
  // A surfel in the middle of the pane was nearly black and now is red for those who look through it at the wall.
  const size_t middle = PaneScene().diffuse.size() - 210;
  float basis[4];
  sh_basis(1, normalized(Vec3f{-1, 0, -0.4f}), basis);
  const auto shown = [&](size_t c) {
    float v = 0.5f + basis[0] * fit.surfels.at(Attribute::ShDc, middle)[c];
    for (size_t k = 1; k < 4; ++k) v += basis[k] * fit.surfels.at(Attribute::ShRest, middle)[3 * (k - 1) + c];
    return v;
  };
  EXPECT_GT(shown(0), shown(1) + 0.3f);
  // Geometry is untouched.
  EXPECT_TRUE(std::ranges::equal(fit.surfels.values(Attribute::Mean), scene.surfels.diffuse.values(Attribute::Mean)));
  EXPECT_TRUE(std::ranges::equal(fit.surfels.values(Attribute::Opacity), scene.surfels.diffuse.values(Attribute::Opacity)));
}

TEST(PreviewFit, PaintsOntoSurfelsThatWereBlack) {
  // Panes absorb: their mean colour falls below zero in training, where the clamp of the rasteriser has no slope.
  TrainedScene scene = scene_behind_glass();
  const size_t first = PaneScene().diffuse.size() - 400;
  for (size_t i = first; i < first + 400; ++i)
    for (size_t c = 0; c < 3; ++c) scene.surfels.diffuse.at(Attribute::ShDc, i)[c] = -4;
  // One that nobody sees stays as it is.
  for (size_t c = 0; c < 3; ++c) scene.surfels.diffuse.at(Attribute::Mean, 0)[c] = -50;
  for (size_t c = 0; c < 3; ++c) scene.surfels.diffuse.at(Attribute::ShDc, 0)[c] = -4;
  const PreviewFit fit = fit_preview(scene, ring(), {.views = 8, .max_side = 48, .steps = 10});
  EXPECT_GT(fit.psnr_after, fit.psnr_before + 3);
  EXPECT_GT(fit.psnr_after, 20);
  EXPECT_LT(0.5f + kShDc * fit.surfels.at(Attribute::ShDc, 0)[0], 0.001f);
}

TEST(PreviewFit, MoreStepsNeverMakeItWorse) {
  const TrainedScene scene = scene_behind_glass();
  double last = 0;
  for (int steps : {1, 2, 4, 8}) {
    const double psnr = fit_preview(scene, ring(), {.views = 8, .max_side = 48, .steps = steps}).psnr_after;
    EXPECT_GT(psnr, last);
    last = psnr;
  }
}

class MoreFormats : public testing::Test {
 protected:
  MoreFormats() {
    scene_.write(root_.path());
    ColmapModel model;
    const auto views = ring();
    for (uint32_t i = 0; i < views.size(); ++i) {
      model.cameras.push_back(colmap_pinhole(i + 1, views[i].intrinsics));
      const Rigid& pose = views[i].cam_from_world;
      model.images.push_back(
          {i + 1, quaternion(pose.rotation), pose.translation, i + 1, "view_" + std::to_string(i) + ".jpg", {}});
    }
    make_folders(root_.path() / "sfm/sparse/0");
    write_colmap_model(root_.path() / "sfm/sparse/0", model, ColmapFormat::Binary);
  }
  RecordingContext context() const {
    std::map<std::string, fs::path> inputs;
    for (const char* stage : {"sfm", "optimize", "mesh", "decompose"})
      if (fs::exists(root_.path() / stage)) inputs[stage] = root_.path() / stage;
    return RecordingContext(inputs);
  }

  TemporaryFolder root_;
  PaneScene scene_;
};

// The numbers of "type name = [ ... ]" in USD text.
std::vector<double> numbers_of(const std::string& text, const std::string& declaration) {
  const size_t at = text.find(declaration + " = [");
  EXPECT_NE(at, std::string::npos) << declaration;
  if (at == std::string::npos) return {};
  const size_t begin = at + declaration.size() + 4, end = text.find(']', begin);
  std::string list = text.substr(begin, end - begin);
  std::ranges::replace_if(
      list, [](char c) { return c == ',' || c == '(' || c == ')'; }, ' ');
  std::istringstream in(list);
  std::vector<double> out;
  for (double v; in >> v;) out.push_back(v);
  return out;
}

TEST_F(MoreFormats, UsdHasTheMeshItsSubsetsAndTheirMaterials) {
  for (const bool y_up : {false, true}) {
    RecordingContext c = context();
    run_export({.formats = {"mesh-usd"}, .axes = y_up ? ExportAxes::Rhyu : ExportAxes::Rhzu, .texture_size = 256}, c);
    const fs::path folder = c.output() / "export";
    const std::string text = read_file(folder / "mesh.usda");
    EXPECT_TRUE(text.starts_with("#usda 1.0\n"));
    EXPECT_NE(text.find(y_up ? "upAxis = \"Y\"" : "upAxis = \"Z\""), std::string::npos);
    for (const auto& [open, close] : {std::pair{'{', '}'}, {'[', ']'}, {'(', ')'}})
      EXPECT_EQ(std::ranges::count(text, open), std::ranges::count(text, close));
    const auto points = numbers_of(text, "point3f[] points");
    const auto indices = numbers_of(text, "int[] faceVertexIndices");
    const auto st = numbers_of(text, "texCoord2f[] primvars:st");
    EXPECT_EQ(numbers_of(text, "int[] faceVertexCounts"), std::vector<double>(scene_.mesh.faces.size(), 3.0));
    ASSERT_EQ(indices.size(), 3 * scene_.mesh.faces.size());
    EXPECT_EQ(st.size() / 2, points.size() / 3);
    EXPECT_EQ(numbers_of(text, "normal3f[] normals").size(), points.size());
    for (double i : indices) ASSERT_LT(i, double(points.size() / 3));
    double high[3] = {0, 0, 0};
    for (size_t i = 0; i < points.size(); ++i) high[i % 3] = std::max(high[i % 3], points[i]);
    EXPECT_NEAR(high[y_up ? 1 : 2], 0.9, 1e-5);
    // Two subsets share the faces; each has a material that exists, whose textures exist.
    const size_t glass = text.find("def GeomSubset \"glass\"");
    ASSERT_NE(glass, std::string::npos);
    EXPECT_EQ(numbers_of(text, "int[] indices").size(), scene_.floor_faces);
    EXPECT_EQ(numbers_of(text.substr(glass), "int[] indices").size(), scene_.mesh.faces.size() - scene_.floor_faces);
    for (const char* name : {"opaque", "glass"}) {
      EXPECT_NE(text.find(fmt::format("rel material:binding = </scene/materials/{}>", name)), std::string::npos);
      EXPECT_NE(text.find(fmt::format("def Material \"{}\"", name)), std::string::npos);
    }
    const size_t material = text.find("def Material \"glass\"");
    EXPECT_NE(text.find("inputs:opacity.connect = </scene/materials/glass/transmission.outputs:r>", material), std::string::npos);
    const std::regex asset("@([^@]+)@");
    size_t textures = 0;
    for (auto it = std::sregex_iterator(text.begin(), text.end(), asset); it != std::sregex_iterator(); ++it, ++textures)
      EXPECT_TRUE(fs::exists(folder / (*it)[1].str())) << (*it)[1];
    EXPECT_EQ(textures, 7u);
    // Every connection leads to a shader and an output that are declared.
    const std::regex connection("connect = </scene/materials/(\\w+)/(\\w+).outputs:(\\w+)>");
    for (auto it = std::sregex_iterator(text.begin(), text.end(), connection); it != std::sregex_iterator(); ++it) {
      const size_t in_material = text.find(fmt::format("def Material \"{}\"", (*it)[1].str()));
      const size_t shader = text.find(fmt::format("def Shader \"{}\"", (*it)[2].str()), in_material);
      ASSERT_NE(shader, std::string::npos) << it->str();
      const std::string body = text.substr(shader, text.find("}\n", shader) - shader);
      EXPECT_NE(body.find("outputs:" + (*it)[3].str() + "\n"), std::string::npos) << it->str();
    }
  }
}

TEST_F(MoreFormats, UsdStaysRightHanded) {
  for (const auto& [left, right] : {std::pair{ExportAxes::Lhyu, ExportAxes::Rhyu}, {ExportAxes::Lhzu, ExportAxes::Rhzu}}) {
    RecordingContext a = context(), b = context();
    run_export({.formats = {"mesh-usd"}, .axes = left, .texture_size = 256}, a);
    run_export({.formats = {"mesh-usd"}, .axes = right, .texture_size = 256}, b);
    EXPECT_EQ(read_file(a.output() / "export/mesh.usda"), read_file(b.output() / "export/mesh.usda"));
    EXPECT_NE(read_file(a.output() / "export/formats.json").find("USD is right-handed"), std::string::npos);
    EXPECT_EQ(read_file(b.output() / "export/formats.json").find("USD is right-handed"), std::string::npos);
  }
}

TEST_F(MoreFormats, GaussiansGlbHasTheExtensionsAttributes) {
  RecordingContext c = context();
  run_export({.formats = {"preview-3dgs", "gaussians-glb"}}, c);
  const std::string bytes = read_file(c.output() / "export/gaussians.glb");
  uint32_t text = 0;
  std::memcpy(&text, bytes.data() + 12, 4);
  const json doc = json::parse(bytes.substr(20, text));
  const char* binary = bytes.data() + 28 + text;
  const json& primitive = doc["meshes"][0]["primitives"][0];
  EXPECT_EQ(primitive["mode"], 0);
  // The properties of the ratified extension and their values; the first two are required.
  const json properties = {{"kernel", "ellipse"},
                           {"colorSpace", "srgb_rec709_display"},
                           {"projection", "perspective"},
                           {"sortingMethod", "cameraDistance"}};
  EXPECT_EQ(primitive["extensions"]["KHR_gaussian_splatting"], properties);
  EXPECT_EQ(doc["extensionsUsed"], json::array({"KHR_gaussian_splatting"}));
  EXPECT_FALSE(doc.contains("extensionsRequired")) << "viewers without the extension show points";
  const auto first = [&](const std::string& name, const std::string& type, size_t row) {
    const json& a = doc["accessors"][primitive["attributes"].at(name).get<size_t>()];
    EXPECT_EQ(a["type"], type) << name;
    EXPECT_EQ(a["count"], scene_.diffuse.size());
    const size_t width = type == "SCALAR" ? 1 : size_t(type[3] - '0');
    const size_t at = doc["bufferViews"][a["bufferView"].get<size_t>()]["byteOffset"].get<size_t>() + 4 * width * row;
    std::vector<float> v(width);
    std::memcpy(v.data(), binary + at, 4 * width);
    return v;
  };
  const std::string prefix = "KHR_gaussian_splatting:";
  const size_t row = 17;
  const float* mean = scene_.diffuse.at(Attribute::Mean, row);
  EXPECT_EQ(first("POSITION", "VEC3", row), (std::vector<float>{mean[0], mean[2], -mean[1]}));
  EXPECT_NEAR(first(prefix + "SCALE", "VEC3", row)[0], 1.f / 40, 1e-6);
  EXPECT_NEAR(first(prefix + "OPACITY", "SCALAR", row)[0], 0.95, 1e-5);
  const auto q = first(prefix + "ROTATION", "VEC4", row);  // x y z w; the floor's disks lie in x z, normal +y
  const Mat3f r = rotation_matrix(Quatf{q[3], q[0], q[1], q[2]});
  EXPECT_NEAR(std::abs(r.c2.y), 1, 1e-5);
  for (size_t i = 0; i < scene_.diffuse.size(); ++i) {
    const auto unit = first(prefix + "ROTATION", "VEC4", i), scale = first(prefix + "SCALE", "VEC3", i),
               opacity = first(prefix + "OPACITY", "SCALAR", i);
    ASSERT_NEAR(std::hypot(std::hypot(unit[0], unit[1]), std::hypot(unit[2], unit[3])), 1, 1e-5);
    ASSERT_GE(*std::ranges::min_element(scale), 0);
    ASSERT_TRUE(opacity[0] >= 0 && opacity[0] <= 1);
  }
  // The same colours as preview_3dgs.ply; degree 1 is complete.
  for (int m = 0; m < 3; ++m) first(fmt::format("{}SH_DEGREE_1_COEF_{}", prefix, m), "VEC3", row);
  EXPECT_FALSE(primitive["attributes"].contains(prefix + "SH_DEGREE_2_COEF_0"));
  const std::string ply = read_file(c.output() / "export/preview_3dgs.ply");
  const size_t body = ply.find("end_header\n") + 11, floats = 9 + 45 + 1 + 3 + 4;
  EXPECT_EQ(ply.size(), body + 248 * scene_.diffuse.size());
  float dc[3];
  std::memcpy(dc, ply.data() + body + 4 * (row * floats + 6), 12);
  const auto dc_glb = first(prefix + "SH_DEGREE_0_COEF_0", "VEC3", row);
  for (size_t k = 0; k < 3; ++k) EXPECT_EQ(dc_glb[k], dc[k]);
}

// The header and the decompressed streams of an SPZ file of version 4.
struct SpzFile {
  uint32_t version = 0, surfels = 0;
  uint8_t degree = 0, fraction_bits = 0, flags = 0;
  std::vector<std::string> streams;  // positions, opacities, colours, scales, rotations, f_rest
};

template <class T>
T number_at(const std::string& bytes, size_t at) {
  T v{};
  EXPECT_LE(at + sizeof v, bytes.size());
  std::memcpy(&v, bytes.data() + at, std::min(sizeof v, bytes.size() - std::min(at, bytes.size())));
  return v;
}

SpzFile parsed_spz(const fs::path& path) {
  const std::string bytes = read_file(path);
  SpzFile file;
  EXPECT_EQ(bytes.substr(0, 4), "NGSP");
  file.version = number_at<uint32_t>(bytes, 4), file.surfels = number_at<uint32_t>(bytes, 8);
  file.degree = number_at<uint8_t>(bytes, 12), file.fraction_bits = number_at<uint8_t>(bytes, 13);
  file.flags = number_at<uint8_t>(bytes, 14);
  const size_t streams = number_at<uint8_t>(bytes, 15), table = number_at<uint32_t>(bytes, 16);
  EXPECT_EQ(table, 32u) << "no extensions";
  EXPECT_EQ(bytes.substr(20, 12), std::string(12, '\0'));
  size_t at = table + 16 * streams;
  for (size_t i = 0; i < streams; ++i) {
    const auto packed = number_at<uint64_t>(bytes, table + 16 * i), size = number_at<uint64_t>(bytes, table + 16 * i + 8);
    std::string stream(size, '\0');
    EXPECT_EQ(ZSTD_decompress(stream.data(), size, bytes.data() + at, packed), size);
    file.streams.push_back(std::move(stream));
    at += packed;
  }
  EXPECT_EQ(at, bytes.size());
  return file;
}

// Decodes as the specification says and compares with the floats of preview_3dgs.ply.
TEST_F(MoreFormats, GaussiansSpzHoldsThePreviewInFewerBits) {
  SplatLayer degree2(LayerKind::Diffuse, 2, scene_.diffuse.size());
  for (const AttributeRow& r : kAttributes)
    if (r.id != Attribute::ShRest) std::ranges::copy(scene_.diffuse.values(r.id), degree2.values(r.id).begin());
  for (size_t i = 0; i < degree2.values(Attribute::ShRest).size(); ++i)
    degree2.values(Attribute::ShRest)[i] = 0.01f * float(i % 37) - 0.18f;
  const size_t n = degree2.size();
  write_layer(root_.path() / "optimize/gaussians/diffuse.ply", degree2);
  RecordingContext c = context(), again = context();
  run_export({.formats = {"preview-3dgs", "gaussians-spz"}, .axes = ExportAxes::Rhyu}, c);
  run_export({.formats = {"gaussians-spz"}}, again);  // always y up
  const fs::path path = c.output() / "export/gaussians.spz";
  EXPECT_EQ(read_file(path), read_file(again.output() / "export/gaussians.spz"));
  EXPECT_LT(fs::file_size(path), fs::file_size(c.output() / "export/preview_3dgs.ply") / 8);
  const SpzFile spz = parsed_spz(path);
  EXPECT_EQ(spz.version, 4u);
  ASSERT_EQ(spz.surfels, n);
  EXPECT_EQ(spz.degree, 2);
  EXPECT_EQ(spz.flags, 0);
  ASSERT_EQ(spz.streams.size(), 6u);
  const size_t widths[] = {9, 1, 3, 3, 4, 24};
  for (size_t k = 0; k < 6; ++k) ASSERT_EQ(spz.streams[k].size(), widths[k] * n) << k;
  const test::FloatPly ply = test::parsed_ply(c.output() / "export/preview_3dgs.ply");
  const auto byte = [&](size_t stream, size_t at) { return double(uint8_t(spz.streams[stream][at])); };
  double worst_sh[2] = {0, 0};
  for (size_t i = 0; i < n; ++i) {
    const char* const axes[] = {"x", "y", "z"};
    for (size_t k = 0; k < 3; ++k) {
      uint32_t fixed = 0;
      std::memcpy(&fixed, spz.streams[0].data() + 9 * i + 3 * k, 3);
      const double position = double(int32_t(fixed << 8) >> 8) / double(1 << spz.fraction_bits);
      ASSERT_NEAR(position, ply.value(i, axes[k]), 0.51 / (1 << spz.fraction_bits));
      ASSERT_NEAR((byte(2, 3 * i + k) / 255 - 0.5) / 0.15, ply.value(i, fmt::format("f_dc_{}", k)), 0.51 / 255 / 0.15);
      const double scale = byte(3, 3 * i + k) / 16 - 10;
      ASSERT_NEAR(scale, std::max(ply.value(i, fmt::format("scale_{}", k)), -10.f), 0.51 / 16);
    }
    ASSERT_NEAR(byte(1, i) / 255, 1 / (1 + std::exp(-double(ply.value(i, "opacity")))), 0.51 / 255);
    auto packed = number_at<uint32_t>(spz.streams[4], 4 * i);
    const size_t largest = packed >> 30;
    double q[4], square = 0, dot = 0;  // x y z w
    for (size_t k = 4; k-- > 0;) {
      if (k == largest) continue;
      q[k] = std::sqrt(0.5) * (packed & 511) / 511 * ((packed & 512) != 0 ? -1 : 1);
      square += q[k] * q[k], packed >>= 10;
    }
    q[largest] = std::sqrt(1 - square);
    for (size_t k = 0; k < 4; ++k) dot += q[k] * ply.value(i, fmt::format("rot_{}", (k + 1) % 4));
    ASSERT_NEAR(std::abs(dot), 1, 1e-5);
    for (size_t k = 0; k < 8; ++k)
      for (size_t ch = 0; ch < 3; ++ch) {
        const double h = (byte(5, 24 * i + 3 * k + ch) - 128) / 128, meant = ply.value(i, fmt::format("f_rest_{}", 15 * ch + k));
        worst_sh[k >= 3] = std::max(worst_sh[k >= 3], std::abs(h - std::clamp(meant, -1.0, 127.0 / 128)));
      }
  }
  EXPECT_LE(worst_sh[0], 4.51 / 128);
  EXPECT_LE(worst_sh[1], 8.51 / 128);
}

TEST_F(MoreFormats, GaussiansSpzRefusesWhatItsPositionsCannotHold) {
  scene_.diffuse.at(Attribute::Mean, 0)[0] = 50;
  write_layer(root_.path() / "optimize/gaussians/diffuse.ply", scene_.diffuse);
  RecordingContext c = context(), all = context();
  try {
    run_export({.formats = {"gaussians-spz"}, .scale = 1e6}, c);
    ADD_FAILURE() << "positions of 5e7 file units were written";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_EQ(e.detail().code, kFormatRange);
    EXPECT_NE(e.detail().why.find("5e+07"), std::string::npos) << e.detail().why;
    EXPECT_NE(e.detail().hint.find("--scale"), std::string::npos);
  }
  // All formats, as by default: the others are written.
  const fs::path model = root_.path() / "sfm/sparse/0";
  write_colmap_model(model, read_colmap_model(model), ColmapFormat::Text);
  make_folders(root_.path() / "sfm/images");
  for (int i = 0; i < 8; ++i) write_file(root_.path() / fmt::format("sfm/images/view_{}.jpg", i), "photo");
  run_export({.scale = 1e6, .texture_size = 32}, all);
  EXPECT_FALSE(fs::exists(all.output() / "export/gaussians.spz"));
  EXPECT_TRUE(fs::exists(all.output() / "export/gaussians.glb"));
  EXPECT_NE(read_file(all.output() / "export/formats.json").find("not written: a surfel is 5e+07 file units"), std::string::npos);
}

TEST_F(MoreFormats, EnvironmentIsCopiedWhenThereIsOne) {
  RecordingContext without = context();
  run_export({.formats = {"environment"}}, without);
  EXPECT_FALSE(fs::exists(without.output() / "export/environment.exr"));
  make_folders(root_.path() / "decompose/decompose");
  write_exr_rgb(decomposed_environment_path(root_.path() / "decompose"), ImageF(8, 4, 3, 2.5f));
  RecordingContext with = context();
  run_export({.formats = {"environment"}}, with);
  EXPECT_EQ(read_exr_rgb(with.output() / "export/environment.exr").at(3, 2, 1), 2.5f);
}

}  // namespace
}  // namespace vitrine
