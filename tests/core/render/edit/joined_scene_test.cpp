// The union of scenes: order, ids, materials, and what cannot be joined.
#include "core/render/edit/joined_scene.h"

#include <gtest/gtest.h>

#include "tests/support/error_of.h"
#include "tests/support/spheres.h"

namespace vitrine {
namespace {

ScenePart part(const std::string& name, size_t surfels, int sh_degree = 0) {
  ScenePart out{.name = name, .where = "scene.yaml:1:1", .scene = {}, .objects = {}};
  SplatLayer& diffuse = out.scene.trained.surfels.diffuse;
  diffuse = SplatLayer(LayerKind::Diffuse, sh_degree, surfels);
  DecomposedMaterials& m = out.scene.materials.emplace();
  m.resize(surfels);
  for (size_t i = 0; i < surfels; ++i) {
    *diffuse.at(Attribute::Opacity, i) = float(surfels) + float(i) / 100;  // which surfel it is
    m.roughness[i] = *diffuse.at(Attribute::Opacity, i);
  }
  out.scene.mesh = test::sphere_mesh(0.1, {}, 4, 6);
  out.scene.keep_all();
  return out;
}

std::vector<float> opacities(const SplatLayer& layer) {
  const auto v = layer.values(Attribute::Opacity);
  return {v.begin(), v.end()};
}

TEST(JoinedScene, OnePartStaysAsItIs) {
  const ScenePart one = part("room", 4, 2);
  const JoinedScene all = joined({one});
  EXPECT_EQ(all.scene.trained.surfels.diffuse, one.scene.trained.surfels.diffuse);
  EXPECT_TRUE(all.objects.empty());
}

TEST(JoinedScene, SurfelsAndMaterialsFollowEachOtherWithGuessesAtTheEnd) {
  ScenePart room = part("room", 4), vase = part("vase", 3, 1);
  vase.scene.trained.surfels.diffuse.at(Attribute::ShRest, 0)[8] = 0.7f;
  room.scene.trained.image.panes.mirrored = 2;
  const JoinedScene all = joined({room, vase});
  const std::vector<float> order{4, 4.01f, 3, 3.01f, 3.02f, 4.02f, 4.03f};
  EXPECT_EQ(opacities(all.scene.trained.surfels.diffuse), order);
  EXPECT_EQ(all.scene.materials->roughness, order);
  EXPECT_EQ(all.scene.trained.image.panes.mirrored, 5u);
  EXPECT_EQ(all.scene.trained.surfels.diffuse.sh_degree(), 1);
  EXPECT_EQ(all.scene.trained.surfels.diffuse.at(Attribute::ShRest, 2)[8], 0.7f);
  EXPECT_EQ(all.scene.mesh.positions.size(), 2 * room.scene.mesh.positions.size());
  EXPECT_EQ(all.scene.mesh.faces.back()[0], vase.scene.mesh.faces.back()[0] + room.scene.mesh.positions.size());
  vase.scene.materials->scatter.assign(3, {0.1f, 0, 0});
  EXPECT_EQ(joined({room, vase}).scene.materials->scatter[0], Vec3f{}) << "the room lets no light in";
  EXPECT_EQ(joined({room, vase}).scene.materials->scatter[2], (Vec3f{0.1f, 0, 0}));
  vase.scene.materials.reset();
  EXPECT_FALSE(joined({room, vase}).scene.materials) << "no common light";
}

TEST(JoinedScene, ObjectsKeepTheirNamesAndGetTheirOwnIds) {
  ScenePart room = part("room", 2), shelf = part("shelf", 3);
  room.objects.objects = {{.id = 4, .name = "vase", .role = ObjectRole::Mirror}};
  room.scene.trained.surfels.diffuse.set_object_ids({4, 0});
  shelf.objects.objects = {{.id = 1, .name = "vase", .role = ObjectRole::Coat}, {.id = 2, .name = "cup"}};
  shelf.scene.trained.surfels.diffuse.set_object_ids({1, 0, 1});
  ShapeSet shapes;
  ShapeSet::Entry& pane = shapes.entries.emplace_back(Plane{{}, Mat3d::identity(), {1, 1}});
  pane.tolerance = 0.1, pane.object = 1;
  shelf.objects.shapes = shapes;
  shelf.scene.trained.image.shape.set = std::make_shared<const ShapeSet>(shapes);
  const JoinedScene all = joined({room, shelf});
  std::vector<std::string> names;
  for (const Object& o : all.objects.objects) names.push_back(o.name);
  EXPECT_EQ(names, (std::vector<std::string>{"vase", "shelf", "vase_2"})) << "the cup is not part of what was taken";
  EXPECT_EQ(all.objects.objects[2].role, ObjectRole::Coat);
  const auto ids = all.scene.trained.surfels.diffuse.object_ids();
  EXPECT_EQ(std::vector<uint16_t>(ids.begin(), ids.end()), (std::vector<uint16_t>{4, 0, 6, 5, 6}));
  EXPECT_EQ(all.ids[1], (std::vector<uint16_t>{5, 6}));
  EXPECT_EQ(all.objects.shapes.entries[0].object, 6);
  EXPECT_EQ(all.scene.trained.image.shape.set->entries[0].object, 6);
  EXPECT_EQ(all.scene.mesh.object_ids.front(), 0);
  EXPECT_EQ(all.scene.mesh.object_ids.back(), 5);
}

TEST(JoinedScene, UnlabelledBordersOfAnObjectAreItsOwn) {
  ScenePart vase = part("vase", 2);
  vase.objects.objects = {{.id = 7, .name = "vase"}};
  vase.scene.trained.surfels.diffuse.set_object_ids({7, 7});
  vase.scene.mesh.object_ids.assign(vase.scene.mesh.positions.size(), 7);
  vase.scene.mesh.object_ids[3] = 0;
  const JoinedScene all = joined({part("room", 2), vase});
  ASSERT_EQ(all.objects.objects.size(), 1u);
  EXPECT_EQ(all.scene.mesh.object_ids.back(), 1);
  EXPECT_EQ(all.scene.mesh.object_ids[all.scene.mesh.object_ids.size() / 2 + 3], 1);
}

TEST(JoinedScene, ADiffuseLayerTakesThePlaceOfAMissingTwin) {
  ScenePart room = part("room", 2), vase = part("vase", 3);
  room.scene.trained.surfels.opaque = SplatLayer(LayerKind::Diffuse, 0, 5);
  EXPECT_EQ(joined({room, vase}).scene.trained.surfels.opaque.size(), 8u);
  room.scene.trained.surfels.opaque = SplatLayer();
  EXPECT_EQ(joined({room, vase}).scene.trained.surfels.opaque.size(), 0u);
}

TEST(JoinedScene, PartsOfAnotherImageFormationAreRefused) {
  ScenePart room = part("room", 2), vase = part("vase", 3);
  room.scene.trained.surfels.reflection = vase.scene.trained.surfels.reflection = SplatLayer(LayerKind::Reflection, 0, 1);
  vase.scene.trained.image.reflection.lobe = Lobe::Sampled;
  EXPECT_EQ(error_of([&] { joined({room, vase}); }).detail().code, "PARTS_DIFFER");
  room.scene.trained.surfels.reflection = SplatLayer(LayerKind::Reflection, 0, 0);  // an opaque scene has no opinion
  EXPECT_EQ(joined({room, vase}).scene.trained.image.reflection.lobe, Lobe::Sampled);
  vase.scene.trained.image.medium.emplace();
  EXPECT_FALSE(joined({room, vase}).scene.trained.image.medium) << "the host was not under water";
}

TEST(JoinedScene, ATableWithoutFreeIdsIsAnError) {
  ScenePart room = part("room", 2);
  room.objects.objects = {{.id = 65534, .name = "vase"}};
  EXPECT_EQ(error_of([&] { joined({room, part("cup", 2)}); }).detail().code, "TOO_MANY_OBJECTS");
}

}  // namespace
}  // namespace vitrine
