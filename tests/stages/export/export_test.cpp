// Write, then read with a parser that shares no code with the writer.
#include <cstring>
#include <sstream>

#include <gtest/gtest.h>

#include "core/foundation/base/json.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/rigid.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/export/export.h"
#include "stages/export/formats/gaussian_ply.h"
#include "stages/export/formats/source.h"
#include "tests/core/scene/camera/tiny_model.h"
#include "tests/stages/export/float_ply.h"
#include "tests/stages/export/ring_of_cameras.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using test::FloatPly;
using test::parsed_ply;
using test::RecordingContext;

SplatLayer random_layer(int sh_degree, size_t n) {
  SplatLayer layer(LayerKind::Diffuse, sh_degree, n);
  Rng rng(7);
  for (const AttributeRow& r : kAttributes)
    for (float& v : layer.values(r.id)) v = rng.normal();
  return layer;
}

TriMesh tetrahedron() {
  TriMesh m;
  m.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  m.normals = {{-0.6f, 0, -0.8f}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  m.colors = {{1, 0, 0}, {0, 1, 0}, {0.2f, 0.2f, 0.2f}, {0, 0, 0}};
  m.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return m;
}

class ExportStage : public testing::Test {
 protected:
  ExportStage() { fill(random_layer(3, 50)); }

  void fill(const SplatLayer& layer) {
    make_folders(root_.path() / "optimize/gaussians");
    make_folders(root_.path() / "mesh/mesh");
    make_folders(root_.path() / "sfm/sparse/0");
    write_layer(layer_path(), layer);
    write_mesh_ply(mesh_path(), tetrahedron());
    model_ = test::tiny_model();
    write_colmap_model(root_.path() / "sfm/sparse/0", model_, ColmapFormat::Binary);
    write_colmap_model(root_.path() / "sfm/sparse/0", model_, ColmapFormat::Text);
    for (const ColmapImage& image : model_.images) {
      make_folders((root_.path() / "sfm/images" / image.name).parent_path());
      write_file(root_.path() / "sfm/images" / image.name, "photo " + image.name);
    }
    write_scene_info(root_.path() / "sfm/scene.json", {});
  }
  fs::path layer_path() const { return root_.path() / "optimize/gaussians/diffuse.ply"; }
  fs::path mesh_path() const { return root_.path() / "mesh/mesh/mesh.ply"; }
  RecordingContext context() const {
    return RecordingContext(
        {{"sfm", root_.path() / "sfm"}, {"optimize", root_.path() / "optimize"}, {"mesh", root_.path() / "mesh"}});
  }

  TemporaryFolder root_;
  ColmapModel model_;
};

std::vector<std::string> property_list(int rest, int scales) {
  std::vector<std::string> names{"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"};
  for (int i = 0; i < rest; ++i) names.push_back("f_rest_" + std::to_string(i));
  names.push_back("opacity");
  for (int i = 0; i < scales; ++i) names.push_back("scale_" + std::to_string(i));
  for (int i = 0; i < 4; ++i) names.push_back("rot_" + std::to_string(i));
  return names;
}

TEST_F(ExportStage, Ply2dgsHoldsTheRawValuesBitForBit) {
  RecordingContext c = context();
  run_export({.formats = {"ply-2dgs"}}, c);
  const FloatPly ply = parsed_ply(c.output() / "export/gaussians_2dgs.ply");
  EXPECT_EQ(ply.properties, property_list(45, 2));
  EXPECT_NE(std::find(ply.comments.begin(), ply.comments.end(), "color lin_rec709"), ply.comments.end());
  const SplatLayer layer = read_layer(layer_path());
  ASSERT_EQ(ply.rows.size(), layer.size());
  for (size_t i = 0; i < layer.size(); ++i) {
    EXPECT_EQ(ply.value(i, "y"), layer.at(Attribute::Mean, i)[1]);
    EXPECT_EQ(ply.value(i, "f_dc_2"), layer.at(Attribute::ShDc, i)[2]);
    // Channel-major in the file, coefficient-major in memory: green's third coefficient above the DC.
    EXPECT_EQ(ply.value(i, "f_rest_17"), layer.at(Attribute::ShRest, i)[2 * 3 + 1]);
    EXPECT_EQ(ply.value(i, "f_rest_44"), layer.at(Attribute::ShRest, i)[14 * 3 + 2]);
    EXPECT_EQ(ply.value(i, "opacity"), *layer.at(Attribute::Opacity, i));
    EXPECT_EQ(ply.value(i, "scale_1"), layer.at(Attribute::LogScale, i)[1]);
    EXPECT_EQ(ply.value(i, "rot_0"), layer.at(Attribute::Rotation, i)[0]);
    EXPECT_EQ(ply.value(i, "rot_3"), layer.at(Attribute::Rotation, i)[3]);
    // The disk normal is orthogonal to both axes of the disk.
    const Vec3f n{ply.value(i, "nx"), ply.value(i, "ny"), ply.value(i, "nz")};
    const float* q = layer.at(Attribute::Rotation, i);
    const Mat3<float> rotation = rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]}));
    EXPECT_NEAR(length(n), 1, 1e-5);
    EXPECT_NEAR(dot(n, rotation * Vec3f{1, 0, 0}), 0, 1e-5);
    EXPECT_NEAR(dot(n, rotation * Vec3f{0, 1, 0}), 0, 1e-5);
  }
}

TEST_F(ExportStage, Ply3dgsShowsTheEncodedMeanColour) {
  RecordingContext c = context();
  run_export({.formats = {"ply-3dgs"}}, c);
  const FloatPly ply = parsed_ply(c.output() / "export/gaussians_3dgs.ply");
  EXPECT_EQ(ply.properties, property_list(45, 3));
  const SplatLayer layer = read_layer(layer_path());
  for (size_t i = 0; i < layer.size(); ++i) {
    EXPECT_FLOAT_EQ(ply.value(i, "scale_2"), std::log(1e-6f));
    EXPECT_EQ(ply.value(i, "nx"), 0);
    for (size_t ch = 0; ch < 3; ++ch) {
      const float linear = 0.5f + 0.28209479f * layer.at(Attribute::ShDc, i)[ch];
      const float shown = 0.5f + 0.28209479f * ply.value(i, "f_dc_" + std::to_string(ch));
      EXPECT_NEAR(shown, srgb_from_linear(std::max(linear, 0.f)), 1e-5);
    }
  }
}

TEST_F(ExportStage, DisksAreAsThinInEveryUnit) {
  RecordingContext c = context();
  run_export({.formats = {"ply-3dgs"}, .scale = 1000}, c);
  const FloatPly ply = parsed_ply(c.output() / "export/gaussians_3dgs.ply");
  const SplatLayer layer = read_layer(layer_path());
  for (size_t i = 0; i < layer.size(); ++i) {
    EXPECT_NEAR(ply.value(i, "scale_0"), layer.at(Attribute::LogScale, i)[0] + std::log(1000.f), 1e-5);
    EXPECT_NEAR(ply.value(i, "scale_2"), std::log(1e-3f), 1e-5);
  }
}

// Importers of both layouts require the 45 coefficients of degree 3 and refuse 0, 9 or 24.
TEST_F(ExportStage, LowerShDegreesArePaddedToDegreeThree) {
  for (const int degree : {0, 1, 2, 3}) {
    const SplatLayer layer = random_layer(degree, 3);
    const int own = (degree + 1) * (degree + 1) - 1;  // coefficients per channel above the DC
    write_layer(layer_path(), layer);
    RecordingContext c = context();
    run_export({.formats = {"ply-2dgs", "ply-3dgs"}}, c);
    const FloatPly flat = parsed_ply(c.output() / "export/gaussians_2dgs.ply"),
                   splats = parsed_ply(c.output() / "export/gaussians_3dgs.ply");
    EXPECT_EQ(flat.properties, property_list(45, 2));
    EXPECT_EQ(splats.properties, property_list(45, 3));
    for (size_t i = 0; i < layer.size(); ++i)
      for (int ch = 0; ch < 3; ++ch)
        for (int k = 0; k < 15; ++k) {
          const std::string name = fmt::format("f_rest_{}", 15 * ch + k);
          EXPECT_EQ(flat.value(i, name), k < own ? layer.at(Attribute::ShRest, i)[3 * k + ch] : 0) << degree << " " << name;
          if (k >= own) {
            EXPECT_EQ(splats.value(i, name), 0) << degree << " " << name;
          }
        }
  }
  for (const char* format : {"ply-2dgs", "ply-3dgs", "preview-3dgs"})
    EXPECT_NE(find_export_format(format)->holds.find("45 f_rest"), std::string_view::npos) << format;
}

TEST_F(ExportStage, AScaleBarInThePhotosGivesEveryFormatItsUnit) {
  const ColmapModel cameras = test::ring_of_cameras();
  for (const ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text})
    write_colmap_model(root_.path() / "sfm/sparse/0", cameras, format);
  for (const ColmapImage& image : cameras.images) write_file(root_.path() / "sfm/images" / image.name, "photo");
  const Vec3d ends[2] = {{-0.1, 0.05, 0}, {0.1, 0.2, 0.05}};  // 0.255 units
  const std::string bar = test::marked_bar(cameras, ends) + " = 51mm";
  const double metres = 0.051 / length(ends[1] - ends[0]);
  const std::vector<std::string> formats{"ply-2dgs", "ply-3dgs", "colmap", "mesh-ply", "mesh-obj", "mesh-glb", "mesh-usd"};
  RecordingContext c = context();
  run_export({.formats = formats, .scale_bar = bar, .texture_size = 32}, c);
  EXPECT_NEAR(c.metrics.at("metres_per_unit"), metres, 1e-4 * metres);  // pixels are written with three digits
  const std::string told = fmt::format("one unit of the scene is {:.4g} m, by the scale bar, 0.0 px", metres);
  EXPECT_NE(c.summary_text.find(told), std::string::npos) << c.summary_text;
  RecordingContext by_hand = context();
  run_export({.formats = formats, .scale = c.metrics.at("metres_per_unit"), .texture_size = 32}, by_hand);
  RecordingContext unscaled = context();
  run_export({.formats = formats, .texture_size = 32}, unscaled);
  for (const char* file : {"gaussians_2dgs.ply", "gaussians_3dgs.ply", "mesh.ply", "mesh.obj", "mesh.glb", "mesh.usda"}) {
    const auto bytes = [&](const RecordingContext& of) { return read_file(of.output() / "export" / file); };
    EXPECT_TRUE(bytes(c) == bytes(by_hand)) << file;
    EXPECT_FALSE(bytes(c) == bytes(unscaled)) << file;
  }
  EXPECT_NE(read_file(c.output() / "export/mesh.usda").find("metersPerUnit = 1\n"), std::string::npos);
  const FloatPly ply = parsed_ply(c.output() / "export/gaussians_2dgs.ply");
  const SplatLayer layer = read_layer(layer_path());
  EXPECT_NEAR(ply.value(3, "y"), metres * double(layer.at(Attribute::Mean, 3)[1]), 1e-4);
  // Formats that have lengths note where their unit comes from.
  const auto written = nlohmann::json::parse(read_file(c.output() / "export/formats.json"));
  for (const auto& format : written) {
    const std::string notes = format.value("notes", nlohmann::json()).dump();
    EXPECT_EQ(notes.find(told) != std::string::npos, format.at("format") != "colmap") << format;
  }
}

TEST_F(ExportStage, TwoPointsOfTheSceneGiveTheFilesTheirUnit) {
  const auto files = [&](const ExportConfig& config) {
    RecordingContext c = context();
    run_export(config, c);
    if (!config.scale_points.empty()) {
      EXPECT_NEAR(c.metrics.at("metres_per_unit"), 0.5, 1e-12);
      EXPECT_NE(c.summary_text.find("one unit of the scene is 0.5 m, by two points that are 0.48 units apart"), std::string::npos)
          << c.summary_text;
    }
    return read_file(c.output() / "export/mesh.ply") + read_file(c.output() / "export/gaussians_2dgs.ply");
  };
  const std::vector<std::string> formats{"ply-2dgs", "mesh-ply"};
  const std::string by_points = files({.formats = formats, .scale_points = "0.1,0.2,0.3 0.1,0.68,0.3 24cm"});
  EXPECT_TRUE(by_points == files({.formats = formats, .scale = 0.5}));
  EXPECT_FALSE(by_points == files({.formats = formats}));
  EXPECT_EQ(problem(ExportConfig{.scale_bar = "a:1,2,3,4 b:1,2,3,4 = 5cm", .scale_points = "0,0,0 1,0,0 1m"}),
            "scale_bar and scale_points both give the unit: leave one of them out");
}

TEST_F(ExportStage, AScaleBarThatIsOfNoUseIsAnError) {
  const ColmapModel cameras = test::ring_of_cameras();
  for (const ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text})
    write_colmap_model(root_.path() / "sfm/sparse/0", cameras, format);
  const Vec3d ends[2] = {{-0.1, 0.05, 0}, {0.1, 0.2, 0.05}};
  const auto code = [&](const std::string& bar) {
    RecordingContext c = context();
    const Error e = error_of([&] { run_export({.formats = {"mesh-ply"}, .scale_bar = bar}, c); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << bar;
    EXPECT_FALSE(fs::exists(c.output() / "export/mesh.ply"));
    return e.detail().code;
  };
  EXPECT_EQ(code(test::marked_bar(cameras, ends)), "SCALE_BAR");
  EXPECT_EQ(code("a.jpg:1,2,3,4 b.jpg:1,2,3,4 = 5cm"), "SCALE_BAR");
  write_passes(root_.path() / "sfm", {{cameras.images[0].name, cameras.images[1].name}, {cameras.images[2].name}},
               PosesOf::Object);
  EXPECT_EQ(code(test::marked_bar(cameras, ends) + " = 51mm"), "SCALE_BAR");
  EXPECT_EQ(problem(ExportConfig{.scale = 1, .scale_bar = "a:1,2,3,4 b:1,2,3,4 = 5cm"}),
            "scale and scale_bar both give the unit: leave one of them out");
  EXPECT_EQ(problem(ExportConfig{.scale_bar = "a:1,2,3,4 b:1,2,3,4 = 5cm"}), "");
}

TEST(DisplayColor, FollowsTheEncodedRadianceToFirstOrder) {
  // A mid grey with a small view dependence: the encoded value along any direction agrees to second order.
  std::vector<float> sh(3 * 4, 0.f);
  for (size_t ch = 0; ch < 3; ++ch) sh[ch] = (0.3f - 0.5f) / kShDc;
  sh[3 + 0] = 0.02f;
  sh[6 + 1] = -0.015f;
  sh[9 + 2] = 0.01f;
  const std::vector<float> linear = sh;
  encode_sh_for_display(sh);
  const auto value = [](const std::vector<float>& c, const Vec3f& d, size_t ch) {
    float basis[4];
    sh_basis(1, d, basis);
    float v = 0.5f;
    for (size_t k = 0; k < 4; ++k) v += basis[k] * c[3 * k + ch];
    return v;
  };
  for (const Vec3f& d : {Vec3f{1, 0, 0}, Vec3f{0, -1, 0}, Vec3f{0, 0, 1}, normalized(Vec3f{1, 2, -1})})
    for (size_t ch = 0; ch < 3; ++ch)
      EXPECT_NEAR(value(sh, d, ch), srgb_from_linear(value(linear, d, ch)), 2e-4);  // worst seen 1.1e-4
}

TEST(DisplayColor, DoesNotBlowUpHighlightsOfBlackSurfels) {
  std::vector<float> sh(3 * 4, 0.f);
  sh[0] = (0.0005f - 0.5f) / kShDc;
  sh[6] = 0.1f;  // up to 0.0494 along +z
  encode_sh_for_display(sh);
  float basis[4];
  sh_basis(1, Vec3f{0, 0, 1}, basis);
  const float shown = 0.5f + basis[0] * sh[0] + basis[2] * sh[6];
  const float exact = srgb_from_linear(0.0005f + 0.0488603f);
  EXPECT_NEAR(shown, exact, 0.15f);  // the tangent at the DC would show 0.64 instead of 0.25
}

TEST_F(ExportStage, MeshFilesHoldTheSameTriangles) {
  RecordingContext c = context();
  run_export({.formats = {"mesh-ply", "mesh-obj"}}, c);
  std::istringstream obj(read_file(c.output() / "export/mesh.obj"));
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<uint32_t, 3>> faces;
  for (std::string line; std::getline(obj, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v") {
      std::array<float, 3> v{};
      for (float& x : v) words >> x;
      vertices.push_back(v);
    } else if (word == "f") {
      std::array<uint32_t, 3> f{};
      for (uint32_t& index : f) {
        words >> word;
        index = uint32_t(std::stoul(word)) - 1;
      }
      faces.push_back(f);
    }
  }
  const TriMesh expected = tetrahedron();
  EXPECT_EQ(faces, expected.faces);
  ASSERT_EQ(vertices.size(), 4u);
  EXPECT_FLOAT_EQ(vertices[3][2], 1);
  // The PLY: 4 vertices, 4 faces of a count byte and three 4-byte indices at the very end.
  const std::string ply = read_file(c.output() / "export/mesh.ply");
  EXPECT_NE(ply.find("element vertex 4\n"), std::string::npos);
  EXPECT_NE(ply.find("element face 4\n"), std::string::npos);
  uint32_t last[3];
  std::memcpy(last, ply.data() + ply.size() - 12, 12);
  EXPECT_EQ(ply[ply.size() - 13], 3);
  for (size_t k = 0; k < 3; ++k) EXPECT_EQ(last[k], expected.faces[3][k]);
}

TEST_F(ExportStage, EveryFormatListsItsFilesAndWhatIsLost) {
  RecordingContext c = context();
  run_export(ExportConfig{}, c);
  const std::string list = read_file(c.output() / "export/formats.json");
  for (const ExportFormat& f : export_formats()) {
    EXPECT_FALSE(f.holds.empty() || f.loses.empty() || f.summary.empty()) << f.name;
    EXPECT_NE(list.find('"' + std::string(f.name) + '"'), std::string::npos) << f.name;
  }
  EXPECT_EQ(ExportConfig{}.formats.size(), export_formats().size());
  EXPECT_FALSE(fs::exists(c.output() / "export/gaussians_albedo.ply")) << "there is no albedo";
  EXPECT_NE(list.find("not written: it needs the decompose stage"), std::string::npos);
  EXPECT_NE(c.summary_text.find(fmt::format("{} formats", export_formats().size())), std::string::npos);
}

TEST_F(ExportStage, TwoRunsGiveTheSameBytes) {
  RecordingContext a = context(), b = context();
  run_export(ExportConfig{}, a);
  run_export(ExportConfig{}, b);
  for (const auto& entry : fs::recursive_directory_iterator(a.output()))
    if (entry.is_regular_file()) {
      EXPECT_EQ(read_file(entry.path()), read_file(b.output() / fs::relative(entry.path(), a.output()))) << entry.path();
    }
}

TEST(ExportConfigTest, UnknownAndRepeatedFormatsAreRefused) {
  Stage stage = export_stage();
  Option* formats = stage.options.find("formats");
  ASSERT_NE(formats, nullptr);
  try {
    formats->assign_list({"ply-2dsg"}, "--set");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Usage);
    EXPECT_NE(std::string(e.what()).find("ply-2dgs"), std::string::npos) << e.what();
  }
  formats->assign_list({"colmap", "colmap"}, "--set");
  EXPECT_NE(stage.problem().find("colmap"), std::string::npos);
}

// Damaged inputs: truncated at many places, and with single bytes changed. An Error{Input}, or a file that is still valid.
TEST_F(ExportStage, DamagedInputsAreNamedErrorsNeverACrash) {
  size_t refused = 0;
  const auto attempt = [&](const std::vector<std::string>& formats, const fs::path& path, const std::string& bytes) {
    write_file(path, bytes);
    RecordingContext c = context();
    try {
      run_export({.formats = formats, .texture_size = 32}, c);
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::Input) << e.what();
      EXPECT_NE(std::string(e.what()).find(root_.path().string()), std::string::npos) << e.what();
      ++refused;
    }
  };
  const std::vector<std::pair<fs::path, std::vector<std::string>>> cases{{layer_path(), {"ply-2dgs", "ply-3dgs", "mesh-glb"}},
                                                                         {mesh_path(), {"mesh-ply", "mesh-obj", "mesh-glb"}},
                                                                         {root_.path() / "sfm/sparse/0/images.bin", {"colmap"}},
                                                                         {root_.path() / "sfm/sparse/0/cameras.bin", {"colmap"}}};
  Rng rng(3);
  for (const auto& [path, formats] : cases) {
    const std::string good = read_file(path);
    for (int i = 0; i < 8; ++i) attempt(formats, path, good.substr(0, rng.below(uint32_t(good.size()))));
    EXPECT_GE(refused, 8u) << "a truncated " << path << " passed";
    for (int i = 0; i < 24; ++i) {
      std::string bad = good;
      bad[rng.below(uint32_t(i < 16 ? std::min<size_t>(good.size(), 400) : good.size()))] = char(rng.below(256));
      attempt(formats, path, bad);
    }
    refused = 0;
    write_file(path, good);
  }
}

TEST_F(ExportStage, AMissingPhotoIsAnErrorThatNamesIt) {
  fs::remove(root_.path() / "sfm/images/a.jpg");
  RecordingContext c = context();
  try {
    run_export({.formats = {"colmap"}}, c);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_NE(std::string(e.what()).find("a.jpg"), std::string::npos);
  }
}

}  // namespace
}  // namespace vitrine
