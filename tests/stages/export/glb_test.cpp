// The GLB, read by a parser of its own: container, accessors, materials, and what was baked where.
#include <gtest/gtest.h>

#include "core/foundation/math/color.h"
#include "stages/export/export.h"
#include "tests/stages/export/glb_reader.h"
#include "tests/stages/export/pane_scene.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using nlohmann::json;
using test::Glb;

class PaneGlb : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const TemporaryFolder root;
    scene_ = new test::PaneScene;
    scene_->write(root.path());
    test::RecordingContext c(
        {{"sfm", root.path() / "sfm"}, {"optimize", root.path() / "optimize"}, {"mesh", root.path() / "mesh"}});
    run_export({.formats = {"mesh-glb"}, .texture_size = 512}, c);
    glb_ = new Glb(c.output() / "export/mesh.glb");
  }
  static void TearDownTestSuite() { delete scene_, delete glb_; }

  const json& primitive(const std::string& material) const {
    for (const json& p : glb_->doc["meshes"][0]["primitives"])
      if (glb_->doc["materials"][size_t(p["material"])]["name"] == material) return p;
    throw std::runtime_error("no primitive " + material);
  }
  const json& material(const std::string& name) const { return glb_->doc["materials"][size_t(primitive(name)["material"])]; }
  // visit(position in the scene's axes, value of the texture there) at the centre of every face of a primitive.
  template <class Visit>
  void for_faces(const std::string& name, const ImageF& picture, Visit&& visit) const {
    const json& p = primitive(name);
    const auto positions = glb_->positions(p["attributes"]["POSITION"]);
    const auto uvs = glb_->floats(p["attributes"]["TEXCOORD_0"], "VEC2");
    const auto index = glb_->indices(p["indices"]);
    for (size_t f = 0; f + 2 < index.size(); f += 3) {
      Vec3f centre{};
      float u = 0, v = 0;
      for (size_t k = 0; k < 3; ++k) {
        const size_t i = index[f + k];
        ASSERT_LT(3 * i + 2, positions.size());
        centre += Vec3f{positions[3 * i], -positions[3 * i + 2], positions[3 * i + 1]} / 3.f;
        u += uvs[2 * i] / 3, v += uvs[2 * i + 1] / 3;
      }
      visit(centre, picture.pixel(int(u * float(picture.width())), int(v * float(picture.height()))));
    }
  }

  static inline test::PaneScene* scene_ = nullptr;
  static inline Glb* glb_ = nullptr;
};

TEST_F(PaneGlb, IsYUpWithUnitNormalsAndTangentsAndExactBounds) {
  const json& p = primitive("opaque");
  const auto positions = glb_->positions(p["attributes"]["POSITION"]);
  const json& accessor = glb_->doc["accessors"][size_t(p["attributes"]["POSITION"])];
  const auto raw = glb_->floats(p["attributes"]["POSITION"], "VEC3");
  for (size_t c = 0; c < 3; ++c) {
    float low = 1e30f, high = -1e30f, low_raw = 2, high_raw = -1;
    for (size_t i = c; i < positions.size(); i += 3) {
      low = std::min(low, positions[i]), high = std::max(high, positions[i]);
      low_raw = std::min(low_raw, raw[i]), high_raw = std::max(high_raw, raw[i]);
    }
    EXPECT_EQ(accessor["min"][c].get<float>() / 65535, low_raw) << "bounds of quantised positions are integers";
    EXPECT_EQ(accessor["max"][c].get<float>() / 65535, high_raw);
    if (c != 1) continue;
    EXPECT_NEAR(high, 0.9, 2e-5);  // the pane stands up along y
    EXPECT_NEAR(low, 0, 2e-5);
  }
  const auto normals = glb_->floats(p["attributes"]["NORMAL"], "VEC3");
  const auto tangents = glb_->floats(p["attributes"]["TANGENT"], "VEC4");
  ASSERT_EQ(tangents.size() / 4, normals.size() / 3);
  for (size_t i = 0; i < normals.size() / 3; ++i) {
    const Vec3f n{normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]};
    const Vec3f t{tangents[4 * i], tangents[4 * i + 1], tangents[4 * i + 2]};
    EXPECT_NEAR(length(n), 1, 1e-4);
    EXPECT_NEAR(length(t), 1, 0.01);  // 8 bits
    EXPECT_NEAR(dot(n, t), 0, 0.01);
    EXPECT_EQ(std::abs(tangents[4 * i + 3]), 1);
  }
}

TEST_F(PaneGlb, TangentsFollowTheTexture) {
  // d position / d u has the tangent's direction, d position / d(-v) that of w (n x t): what a viewer assumes.
  const json& p = primitive("opaque");
  const auto positions = glb_->positions(p["attributes"]["POSITION"]);
  const auto uvs = glb_->floats(p["attributes"]["TEXCOORD_0"], "VEC2");
  const auto normals = glb_->floats(p["attributes"]["NORMAL"], "VEC3");
  const auto tangents = glb_->floats(p["attributes"]["TANGENT"], "VEC4");
  for (const char* name : {"opaque", "glass"}) {
    const auto index = glb_->indices(primitive(name)["indices"]);
    for (size_t f = 0; f + 2 < index.size(); f += 3) {
      const auto at = [&](size_t k) {
        return Vec3f{positions[3 * index[f + k]], positions[3 * index[f + k] + 1], positions[3 * index[f + k] + 2]};
      };
      const auto du = [&](size_t k) { return uvs[2 * index[f + k]] - uvs[2 * index[f]]; };
      const auto dv = [&](size_t k) { return uvs[2 * index[f + k] + 1] - uvs[2 * index[f] + 1]; };
      const Vec3f e1 = at(1) - at(0), e2 = at(2) - at(0);
      const float d = du(1) * dv(2) - du(2) * dv(1);
      const Vec3f along_u = normalized((dv(2) * e1 - dv(1) * e2) / d), along_v = normalized((du(1) * e2 - du(2) * e1) / d);
      const uint32_t i = index[f];
      const Vec3f n{normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]};
      const Vec3f t{tangents[4 * i], tangents[4 * i + 1], tangents[4 * i + 2]};
      EXPECT_GT(dot(along_u, t), 0.999);
      EXPECT_GT(dot(-along_v, tangents[4 * i + 3] * cross(n, t)), 0.999);
      EXPECT_GT(dot(cross(e1, e2), n), 0) << "front faces are counter-clockwise";
    }
  }
}

TEST_F(PaneGlb, ThePaneIsTransmissiveAndDoubleSidedAndTheFloorIsNot) {
  EXPECT_EQ(glb_->indices(primitive("opaque")["indices"]).size(), 3 * scene_->floor_faces);
  EXPECT_EQ(glb_->indices(primitive("glass")["indices"]).size(), 3 * (scene_->mesh.faces.size() - scene_->floor_faces));
  const json& glass = material("glass");
  EXPECT_EQ(glass["doubleSided"], true);
  const json& transmission = glass["extensions"]["KHR_materials_transmission"];
  EXPECT_EQ(transmission["transmissionFactor"], 1.0);
  EXPECT_EQ(glass["extensions"]["KHR_materials_ior"]["ior"], 1.5);
  EXPECT_FALSE(glass.contains("alphaMode"));
  EXPECT_FALSE(material("opaque")["extensions"].contains("KHR_materials_transmission"));
  const auto& used = glb_->doc["extensionsUsed"];
  EXPECT_NE(std::find(used.begin(), used.end(), "KHR_materials_transmission"), used.end());
  for_faces("glass", glb_->picture(transmission["transmissionTexture"]["index"]),
            [](const Vec3f&, const float* v) { EXPECT_NEAR(v[0], test::kPaneTransmission, 0.01); });
}

TEST_F(PaneGlb, BaseColourIsTheSurfelsColour) {
  const ImageF picture = glb_->picture(material("opaque")["pbrMetallicRoughness"]["baseColorTexture"]["index"]);
  size_t looked = 0;
  for_faces("opaque", picture, [&](const Vec3f& p, const float* v) {
    // Away from the borders of tiles, where discs of both colours overlap.
    const float x = 2 * p.x - std::floor(2 * p.x), y = 2 * p.y - std::floor(2 * p.y);
    if (std::min({x, y, 1 - x, 1 - y}) < 0.25f || std::max(std::abs(p.x), std::abs(p.y)) > 0.95f) return;
    ++looked;
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(v[c], srgb_from_linear(test::tile_color(p.x, p.y)[c]), 0.02);
  });
  EXPECT_GT(looked, 500u);
}

TEST_F(PaneGlb, SpecularAndRoughnessOfThePaneAreItsOwn) {
  const json& glass = material("glass");
  const json& specular = glass["extensions"]["KHR_materials_specular"];
  const float factor = specular["specularColorFactor"][0];
  const float expected = test::kPaneSpecular + (1 - test::kPaneSpecular) * test::kPaneF0;  // k_s + (1 - k_s) f0: g(0.05) = 1
  for_faces("glass", glb_->picture(specular["specularColorTexture"]["index"]),
            [&](const Vec3f&, const float* v) { EXPECT_NEAR(0.04f * factor * linear_from_srgb(v[0]), expected, 0.003); });
  for_faces("glass", glb_->picture(glass["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"]),
            [](const Vec3f&, const float* v) {
              EXPECT_NEAR(v[1], test::kPaneRoughness * (1 - test::kPaneTransmission), 0.01);
              EXPECT_EQ(v[2], 0);
            });
  // The floor sends no rays: nobody measured how rough it is.
  for_faces("opaque", glb_->picture(material("opaque")["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"]),
            [](const Vec3f&, const float* v) { EXPECT_GT(v[1], 0.99f); });
}

TEST_F(PaneGlb, NormalTextureIsFlatWhereSurfelsLieInTheMesh) {
  for_faces("opaque", glb_->picture(material("opaque")["normalTexture"]["index"]), [](const Vec3f&, const float* v) {
    EXPECT_NEAR(v[0], 0.5, 0.01);
    EXPECT_NEAR(v[1], 0.5, 0.01);
    EXPECT_GT(v[2], 0.99f);
  });
}

// A green sheet behind the pane that only the transmittance layer knows.
class SheetBehindPaneGlb : public PaneGlb {
 protected:
  static constexpr float kAway = -0.3f;
  static void SetUpTestSuite() {
    const TemporaryFolder root;
    scene_ = new test::PaneScene;
    constexpr int kSide = 24;
    SplatLayer& content = scene_->transmittance;
    content = SplatLayer(LayerKind::Transmittance, 0, 0);
    const Quatf turn = quaternion(Mat3f{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}});
    test::for_grid(kSide, {kAway, 0, 0.5f}, {0, 0.3f, 0}, {0, 0, 0.3f}, [&](const Vec3f& p, float, float) {
      const size_t i = content.size();
      content.resize(i + 1);
      const float raw[4] = {turn.w, turn.x, turn.y, turn.z}, green[3] = {0.1f, 0.6f, 0.1f};
      std::copy_n(raw, 4, content.at(Attribute::Rotation, i));
      for (size_t c = 0; c < 3; ++c) {
        content.at(Attribute::Mean, i)[c] = p[c];
        content.at(Attribute::ShDc, i)[c] = (green[c] - 0.5f) / kShDc;
      }
      for (size_t c = 0; c < 2; ++c) content.at(Attribute::LogScale, i)[c] = std::log(0.3f / kSide);
      *content.at(Attribute::Opacity, i) = logit(0.95f);
    });
    scene_->write(root.path());
    TriMesh sheet;
    sheet.positions = {{kAway, -0.3f, 0.2f}, {kAway, 0.3f, 0.2f}, {kAway, 0.3f, 0.8f}, {kAway, -0.3f, 0.8f}};
    sheet.normals.assign(4, {1, 0, 0});
    sheet.colors.assign(4, {0.5f, 0.5f, 0.5f});
    sheet.faces = {{0, 1, 2}, {0, 2, 3}};
    write_mesh_ply(root.path() / "mesh/mesh/behind_glass.ply", sheet);
    test::RecordingContext c(
        {{"sfm", root.path() / "sfm"}, {"optimize", root.path() / "optimize"}, {"mesh", root.path() / "mesh"}});
    run_export({.formats = {"mesh-glb", "mesh-obj"}, .texture_size = 512}, c);
    glb_ = new Glb(c.output() / "export/mesh.glb");
  }
};

TEST_F(SheetBehindPaneGlb, IsOpaqueAndHasItsOwnColours) {
  EXPECT_EQ(glb_->indices(primitive("opaque")["indices"]).size(), 3 * (scene_->floor_faces + 2));
  size_t sheet = 0, pane = 0;
  for_faces("opaque", glb_->picture(material("opaque")["pbrMetallicRoughness"]["baseColorTexture"]["index"]),
            [&](const Vec3f& p, const float* v) {
              if (p.z < 0.1f) return;
              ++sheet;
              EXPECT_NEAR(p.x, kAway, 1e-5);
              for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(v[c], srgb_from_linear(c == 1 ? 0.6f : 0.1f), 0.02);
            });
  EXPECT_EQ(sheet, 2u);
  // The pane in front stays as clear as it was.
  for_faces("glass", glb_->picture(material("glass")["extensions"]["KHR_materials_transmission"]["transmissionTexture"]["index"]),
            [&](const Vec3f&, const float* v) {
              ++pane;
              EXPECT_NEAR(v[0], test::kPaneTransmission, 0.01);
            });
  EXPECT_GT(pane, 500u);
}

TEST(MeshGlb, WithoutATransmittanceLayerNothingIsGlass) {
  const TemporaryFolder root;
  test::PaneScene scene;
  scene.write(root.path());
  fs::remove(root.path() / "optimize/gaussians/transmittance.ply");
  test::RecordingContext c(
      {{"sfm", root.path() / "sfm"}, {"optimize", root.path() / "optimize"}, {"mesh", root.path() / "mesh"}});
  run_export({.formats = {"mesh-glb"}, .texture_size = 256}, c);
  const Glb glb(c.output() / "export/mesh.glb");
  EXPECT_EQ(glb.doc["materials"].size(), 1u);
  EXPECT_EQ(glb.doc["materials"][0]["name"], "opaque");
}

TEST(MeshGlb, IsInMetresWhenTheSceneKnowsThem) {
  const TemporaryFolder root;
  test::PaneScene scene;
  scene.write(root.path());
  SceneInfo info;
  info.scene_from_colmap.scale = 0.25;
  info.scale_known = true;
  write_scene_info(root.path() / "sfm/scene.json", info);
  const auto height = [&](double scale) {
    test::RecordingContext c(
        {{"sfm", root.path() / "sfm"}, {"optimize", root.path() / "optimize"}, {"mesh", root.path() / "mesh"}});
    run_export({.formats = {"mesh-glb"}, .scale = scale, .texture_size = 256}, c);
    const Glb glb(c.output() / "export/mesh.glb");
    EXPECT_EQ(glb.doc["asset"]["extras"]["unit"], "metre");
    const auto positions = glb.positions(0);
    float highest = 0;
    for (size_t i = 1; i < positions.size(); i += 3) highest = std::max(highest, positions[i]);
    return double(highest);
  };
  EXPECT_NEAR(height(0), 0.9 * 4, 1e-4);  // the poses' frame is metric: four metres to a unit
  EXPECT_NEAR(height(0.1), 0.09, 1e-5);   // somebody measured it
}

TEST(MeshGlb, HasThePlaceByGps) {
  const TemporaryFolder root;
  test::PaneScene scene;
  scene.write(root.path());
  SceneInfo info;
  info.scene_from_colmap.scale = 0.25;
  info.scale_known = true;
  info.geo = GeoOrigin{.latitude = 47.5, .longitude = 8.25, .altitude = 431, .metres_per_unit = 12};
  write_scene_info(root.path() / "sfm/scene.json", info);
  test::RecordingContext c(
      {{"sfm", root.path() / "sfm"}, {"optimize", root.path() / "optimize"}, {"mesh", root.path() / "mesh"}});
  run_export({.formats = {"mesh-glb"}, .texture_size = 256}, c);
  const Glb glb(c.output() / "export/mesh.glb");
  const auto extras = glb.doc["asset"]["extras"];
  EXPECT_EQ(extras["unit"], "metre");
  EXPECT_EQ(extras["enu_origin"]["latitude"], 47.5);
  EXPECT_EQ(extras["enu_origin"]["longitude"], 8.25);
  EXPECT_EQ(extras["enu_origin"]["altitude"], 431);
  EXPECT_EQ(extras["enu_origin"]["axes"], "x east, y up, z south");
  const auto positions = glb.positions(0);
  float highest = 0;
  for (size_t i = 1; i < positions.size(); i += 3) highest = std::max(highest, positions[i]);
  EXPECT_NEAR(highest, 0.9 * 12, 1e-3) << "metres by GPS, not by the frame of the poses";
  EXPECT_NE(read_file(c.output() / "export/formats.json").find("latitude 47.5000000, longitude 8.2500000, altitude 431.0 m"),
            std::string::npos);
}

}  // namespace
}  // namespace vitrine
