// Solid glass in files of other programs: panes stay thin, the ball has thickness and index of refraction.
#include <gtest/gtest.h>

#include "stages/export/export.h"
#include "tests/stages/export/glb_reader.h"
#include "tests/stages/export/solid_ball.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using Document = nlohmann::json;
using test::SolidBallScene;

class SolidGlassExport : public testing::Test {
 protected:
  // `around`: with what is known to stand behind glass, in the ball and behind the pane.
  fs::path exported(bool solid, double scale = 1, std::vector<std::string> formats = {"mesh-glb"}, bool around = false) {
    scene_.write(root_.path(), solid);
    if (around) {
      TriMesh content;
      SolidBallScene::add_content(content, SolidBallScene::kCentre);
      SolidBallScene::add_content(content, {-0.3f, 0, 0.5f});
      write_mesh_ply(root_.path() / "mesh/mesh/behind_glass.ply", content);
    }
    context_.emplace(std::map<std::string, fs::path>{
        {"sfm", root_.path() / "sfm"}, {"optimize", root_.path() / "optimize"}, {"mesh", root_.path() / "mesh"}});
    run_export({.formats = std::move(formats), .scale = scale, .texture_size = 256}, *context_);
    return context_->output() / "export";
  }
  static Document material(const test::Glb& glb, const char* name) {
    return glb.doc["materials"][size_t(glb.primitive(name)["material"])];
  }

  SolidBallScene scene_;
  TemporaryFolder root_;
  std::optional<test::RecordingContext> context_;
};

TEST_F(SolidGlassExport, TheBallIsAVolumeAndThePaneIsNot) {
  constexpr double kScale = 0.5;
  const test::Glb glb(exported(true, kScale) / "mesh.glb");
  EXPECT_EQ(glb.indices(glb.primitive("solid_glass")["indices"]).size(), 3 * scene_.ball_faces);
  EXPECT_EQ(glb.indices(glb.primitive("opaque")["indices"]).size(), 3 * scene_.floor_faces);
  const Document pane = material(glb, "glass"), ball = material(glb, "solid_glass");
  EXPECT_FALSE(pane["extensions"].contains("KHR_materials_volume"));
  EXPECT_EQ(pane["extensions"]["KHR_materials_ior"]["ior"], 1.5);
  EXPECT_EQ(pane["doubleSided"], true);
  EXPECT_FALSE(material(glb, "opaque")["extensions"].contains("KHR_materials_volume"));

  EXPECT_FALSE(ball.contains("doubleSided")) << "the shell of a volume has an inside";
  EXPECT_EQ(ball["extensions"]["KHR_materials_ior"]["ior"], 1.33);
  EXPECT_EQ(ball["extensions"]["KHR_materials_transmission"]["transmissionFactor"], 1.0);
  const Document& volume = ball["extensions"]["KHR_materials_volume"];
  // In the mesh's own space, which the node scales.
  const double side = glb.doc["nodes"][0]["scale"][0];
  EXPECT_NEAR(side * volume["thicknessFactor"].get<double>(), kScale * 2 * double(SolidBallScene::kRadius), 2e-3);
  EXPECT_FALSE(volume.contains("attenuationColor"));
  EXPECT_FALSE(volume.contains("attenuationDistance"));
  const auto& used = glb.doc["extensionsUsed"];
  EXPECT_EQ(std::count(used.begin(), used.end(), "KHR_materials_volume"), 1);

  // Everywhere as thick as the ball; the texture of the thickness is where the ball's faces are.
  const ImageF thickness = glb.picture(volume["thicknessTexture"]["index"]);
  const Document p = glb.primitive("solid_glass");
  const auto uvs = glb.floats(p["attributes"]["TEXCOORD_0"], "VEC2");
  const auto normals = glb.floats(p["attributes"]["NORMAL"], "VEC3");
  const auto positions = glb.positions(p["attributes"]["POSITION"]);
  const ImageF bumps = glb.picture(ball["normalTexture"]["index"]);
  const Vec3f centre = float(kScale) * Vec3f{SolidBallScene::kCentre.x, SolidBallScene::kCentre.z, -SolidBallScene::kCentre.y};
  for (const uint32_t i : glb.indices(p["indices"])) {
    const int x = int(uvs[2 * i] * float(thickness.width())), y = int(uvs[2 * i + 1] * float(thickness.height()));
    EXPECT_GT(thickness.at(x, y), 0.98f);
    EXPECT_NEAR(bumps.at(x, y, 0), 0.5, 0.01);
    EXPECT_NEAR(bumps.at(x, y, 1), 0.5, 0.01);
    const Vec3f n{normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]};
    const Vec3f at = Vec3f{positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]} - centre;
    EXPECT_GT(dot(n, normalized(at)), 0.9999f) << "the normals at which rays bend, not those of the mesh";
  }

  // What it reflects head on is what was trained, whatever f0 glTF derives from the index.
  const double f0 = std::pow(0.33 / 2.33, 2);
  const double of_ball = ball["extensions"]["KHR_materials_specular"]["specularColorFactor"][0];
  const double of_pane = pane["extensions"]["KHR_materials_specular"]["specularColorFactor"][0];
  EXPECT_NEAR(f0 * of_ball, 0.04 * of_pane, 1e-6);
}

TEST_F(SolidGlassExport, GlassThatNobodyFoundSolidIsThin) {
  const test::Glb glb(exported(false) / "mesh.glb");
  EXPECT_TRUE(glb.primitive("solid_glass").is_null());
  const size_t glass = scene_.mesh.faces.size() - scene_.floor_faces;
  EXPECT_EQ(glb.indices(glb.primitive("glass")["indices"]).size(), 3 * glass);
  for (const Document& name : glb.doc["extensionsUsed"]) EXPECT_NE(name, "KHR_materials_volume");
}

TEST_F(SolidGlassExport, NothingIsInSolidGlassUnlessSurfelsAre) {
  const auto opaque = [&] {
    const test::Glb glb(exported(true, 1, {"mesh-glb"}, true) / "mesh.glb");
    return glb.indices(glb.primitive("opaque")["indices"]).size() / 3 - scene_.floor_faces;
  };
  EXPECT_EQ(opaque(), 2u) << "what stands behind the pane, but not what straight rays painted into the ball";
  float* place = scene_.transmittance.at(Attribute::Mean, 0);
  for (size_t c = 0; c < 3; ++c) place[c] = SolidBallScene::kCentre[c];
  EXPECT_EQ(opaque(), 4u) << "a thing cast into the glass";
}

TEST_F(SolidGlassExport, ObjAndUsdSayItsIndexOfRefraction) {
  const fs::path folder = exported(true, 1, {"mesh-obj", "mesh-usd", "mesh-glb"});
  const std::string mtl = read_file(folder / "mesh.mtl"), usd = read_file(folder / "mesh.usda");
  EXPECT_NE(read_file(folder / "mesh.obj").find("g solid_glass\nusemtl solid_glass\n"), std::string::npos);
  const size_t solid = mtl.find("newmtl solid_glass\n"), pane = mtl.find("newmtl glass\n");
  ASSERT_NE(solid, std::string::npos);
  ASSERT_NE(pane, std::string::npos);
  EXPECT_NE(mtl.find("Ni 1.33\n", solid), std::string::npos);
  EXPECT_LT(mtl.find("Ni 1.5\n", pane), solid);
  const size_t material = usd.find("def Material \"solid_glass\"");
  ASSERT_NE(material, std::string::npos);
  EXPECT_LT(usd.find("inputs:ior = 1.33", material), usd.find("def Shader \"st\"", material));
  EXPECT_NE(usd.find("</scene/materials/solid_glass>"), std::string::npos);
  const std::string told = read_file(folder / "formats.json");
  EXPECT_NE(told.find("solid glass, index of refraction 1.33, up to 0.4 thick"), std::string::npos) << told;
}

}  // namespace
}  // namespace vitrine
