// Brushed metal in the GLB: strength and direction of KHR_materials_anisotropy, which is rougher across the marks.
#include <gtest/gtest.h>

#include "core/render/picture/decomposed_materials.h"
#include "stages/export/export.h"
#include "tests/stages/export/glb_reader.h"
#include "tests/stages/export/pane_scene.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

test::Glb exported(const Vec3f& marks) {
  const TemporaryFolder root;
  test::PaneScene scene;
  scene.write(root.path());
  DecomposedMaterials found;
  found.resize(scene.diffuse.size());
  for (size_t i = 0; i < found.size(); ++i) {
    found.albedo[i] = found.f0[i] = {0.7f, 0.6f, 0.5f};
    found.specular_weight[i] = 0.05f;
  }
  if (marks != Vec3f{}) found.marks.assign(found.size(), marks);
  write_decomposed_materials(root.path() / "decompose", found);
  test::RecordingContext c({{"sfm", root.path() / "sfm"},
                            {"optimize", root.path() / "optimize"},
                            {"mesh", root.path() / "mesh"},
                            {"decompose", root.path() / "decompose"}});
  run_export({.formats = {"mesh-glb"}, .texture_size = 256}, c);
  return test::Glb(c.output() / "export/mesh.glb");
}

TEST(BrushedGlb, DirectionIsAcrossTheMarksAndStrengthTheirLength) {
  const test::Glb glb = exported(0.75f * normalized(Vec3f{2, 1, 0}));
  const nlohmann::json p = glb.primitive("opaque");
  ASSERT_FALSE(p.is_null());
  const nlohmann::json& extensions = glb.doc["materials"][size_t(p["material"])]["extensions"];
  ASSERT_TRUE(extensions.contains("KHR_materials_anisotropy"));
  EXPECT_EQ(extensions["KHR_materials_anisotropy"]["anisotropyStrength"], 1.0);
  const ImageF picture = glb.picture(extensions["KHR_materials_anisotropy"]["anisotropyTexture"]["index"]);
  const auto normals = glb.floats(p["attributes"]["NORMAL"], "VEC3"), tangents = glb.floats(p["attributes"]["TANGENT"], "VEC4"),
             uvs = glb.floats(p["attributes"]["TEXCOORD_0"], "VEC2");
  const Vec3f marks = normalized(Vec3f{2, 0, -1});  // +Y is up
  const auto index = glb.indices(p["indices"]);
  size_t seen = 0;
  for (size_t f = 0; f + 2 < index.size(); f += 3, ++seen) {  // at the centre of each face, which is no border of a chart
    Vec3f n{}, t{};
    Vec2f uv{};
    for (size_t k = 0; k < 3; ++k) {
      const size_t v = index[f + k];
      n += Vec3f{normals[3 * v], normals[3 * v + 1], normals[3 * v + 2]} / 3.f;
      t += Vec3f{tangents[4 * v], tangents[4 * v + 1], tangents[4 * v + 2]} / 3.f;
      uv = uv + (256 / 3.f) * Vec2f{uvs[2 * v], uvs[2 * v + 1]};
    }
    const auto texel = picture.pixel(int(uv.x), int(uv.y));
    const Vec3f across = (2 * texel[0] - 1) * t + (2 * texel[1] - 1) * tangents[4 * index[f] + 3] * cross(n, t);
    EXPECT_NEAR(length(across), 1, 0.02f);
    EXPECT_NEAR(dot(across, marks), 0, 0.03f);
    EXPECT_NEAR(texel[2], 0.75f, 0.01f);
  }
  EXPECT_GT(seen, 20u);
}

TEST(BrushedGlb, WithoutMarksThereIsNoExtension) {
  const test::Glb glb = exported({});
  for (const auto& used : glb.doc["extensionsUsed"]) EXPECT_NE(used, "KHR_materials_anisotropy");
}

}  // namespace
}  // namespace vitrine
