// ply-albedo: the header, every value, which side normals face, and what is said without the decompose stage.
#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/color.h"
#include "core/render/picture/decomposed_materials.h"
#include "stages/export/export.h"
#include "stages/export/formats/gaussian_ply.h"
#include "tests/stages/export/float_ply.h"
#include "tests/stages/export/pane_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using test::FloatPly;

class PlyAlbedo : public testing::Test {
 protected:
  PlyAlbedo() {
    // Half of the disks lie the other way round: training does not tell the sides apart.
    for (size_t i = 0; i < scene_.diffuse.size(); i += 2) {
      float* q = scene_.diffuse.at(Attribute::Rotation, i);
      const Quatf turned = quaternion(rotation_matrix(Quatf{q[0], q[1], q[2], q[3]}) * Mat3f{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
      q[0] = turned.w, q[1] = turned.x, q[2] = turned.y, q[3] = turned.z;
    }
    scene_.write(root_.path());
    found_.resize(scene_.diffuse.size());
    Rng rng(11);
    for (size_t i = 0; i < found_.size(); ++i) {
      found_.albedo[i] = {rng.uniform(), rng.uniform(), rng.uniform()};
      found_.roughness[i] = rng.uniform();
      found_.f0[i] = {rng.uniform(), rng.uniform(), rng.uniform()};
      found_.specular_weight[i] = rng.uniform();
      found_.transmission[i] = rng.uniform();
    }
    found_.albedo[kSky] = found_.f0[kSky] = {};
    found_.specular_weight[kSky] = 0;
    write_decomposed_materials(root_.path() / "decompose", found_);
  }
  test::RecordingContext context(bool decomposed = true) const {
    std::map<std::string, fs::path> inputs;
    for (const char* stage : {"sfm", "optimize", "mesh", "decompose"})
      if (decomposed || std::string_view(stage) != "decompose") inputs[stage] = root_.path() / stage;
    return test::RecordingContext(inputs);
  }
  FloatPly written(const ExportConfig& config) const {
    test::RecordingContext c = context();
    run_export(config, c);
    return test::parsed_ply(c.output() / "export/gaussians_albedo.ply");
  }

  static constexpr size_t kSky = 5;  // shows the light of the photos
  TemporaryFolder root_;
  test::PaneScene scene_;
  DecomposedMaterials found_;
};

TEST_F(PlyAlbedo, HasTheMaterialsBehindThePropertiesOfTheDialect) {
  const FloatPly ply = written({.formats = {"ply-albedo"}});
  EXPECT_EQ(ply.properties, (std::vector<std::string>{"x",           "y",
                                                      "z",           "nx",
                                                      "ny",          "nz",
                                                      "f_dc_0",      "f_dc_1",
                                                      "f_dc_2",      "opacity",
                                                      "scale_0",     "scale_1",
                                                      "scale_2",     "rot_0",
                                                      "rot_1",       "rot_2",
                                                      "rot_3",       "roughness",
                                                      "f0_r",        "f0_g",
                                                      "f0_b",        "specular_weight",
                                                      "transmission"}));
  EXPECT_TRUE(std::ranges::count(ply.comments, "color srgb_rec709"));
  ASSERT_EQ(ply.rows.size(), scene_.diffuse.size() - 1) << "all but the surfel that shows the light of the photos";
  for (size_t row = 0; row < ply.rows.size(); ++row) {
    const size_t i = row < kSky ? row : row + 1;
    EXPECT_EQ(ply.value(row, "x"), scene_.diffuse.at(Attribute::Mean, i)[0]);
    EXPECT_EQ(ply.value(row, "opacity"), *scene_.diffuse.at(Attribute::Opacity, i));
    EXPECT_EQ(ply.value(row, "scale_1"), scene_.diffuse.at(Attribute::LogScale, i)[1]);
    EXPECT_EQ(ply.value(row, "rot_2"), scene_.diffuse.at(Attribute::Rotation, i)[2]);
    for (size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(linear_from_srgb(0.5f + 0.28209479f * ply.value(row, fmt::format("f_dc_{}", c))), found_.albedo[i][c], 1e-5);
    EXPECT_EQ(ply.value(row, "roughness"), found_.roughness[i]);
    EXPECT_EQ(ply.value(row, "f0_g"), found_.f0[i].y);
    EXPECT_EQ(ply.value(row, "specular_weight"), found_.specular_weight[i]);
    EXPECT_EQ(ply.value(row, "transmission"), found_.transmission[i]);
  }
}

TEST_F(PlyAlbedo, NormalsFaceOutInEveryFrame) {
  const size_t floor = 40 * 40;
  for (const auto& [axes, up] :
       {std::pair{ExportAxes::Rhzu, "nz"}, {ExportAxes::Rhyu, "ny"}, {ExportAxes::Lhyu, "ny"}, {ExportAxes::Lhzu, "nz"}}) {
    const FloatPly ply = written({.formats = {"ply-albedo"}, .axes = axes, .scale = 3});
    for (size_t row = 0; row < ply.rows.size(); ++row) {
      const bool on_floor = row + 1 < floor;
      EXPECT_NEAR(ply.value(row, on_floor ? up : "nx"), 1, 1e-5) << kExportAxesWords[size_t(axes)] << " " << row;
    }
  }
}

TEST(OutwardNormals, LookAtTheCamerasWhereThereIsNoMesh) {
  const TriMesh far{.positions = {{50, 0, 0}}, .normals = {{1, 0, 0}}, .colors = {}, .faces = {}};
  SplatLayer layer(LayerKind::Diffuse, 0, 4);
  for (size_t i = 0; i < 4; ++i) {
    layer.at(Attribute::Mean, i)[2] = i < 2 ? 0.3f : 4;  // a thing in the middle, and a ceiling
    layer.at(Attribute::Rotation, i)[i % 2] = 1;         // normal +z or -z
  }
  const std::vector<Vec3f> normals = outward_normals(layer, far, 0.1f);
  for (size_t i = 0; i < 4; ++i) EXPECT_NEAR(normals[i].z, i < 2 ? 1 : -1, 1e-6) << i;
}

TEST_F(PlyAlbedo, WithoutTheDecomposeStageItIsAnErrorWhereItWasAskedFor) {
  test::RecordingContext asked = context(false);
  const Error e = error_of([&] { run_export({.formats = {"ply-2dgs", "ply-albedo"}}, asked); });
  EXPECT_EQ(e.kind(), ErrorKind::Input);
  EXPECT_EQ(e.message(), "the format ply-albedo needs the decompose stage");
}

}  // namespace
}  // namespace vitrine
