// The objects of a scene in its page: their list, and the id of each drawn surfel.
#include "stages/view/page_surfels.h"

#include <gtest/gtest.h>

#include "stages/view/view.h"
#include "tests/stages/edit/two_balls.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using nlohmann::ordered_json;

// Words of a block, whose low bytes stand before its high ones.
std::vector<uint16_t> words_of(const PageBlocks& blocks, const char* name) {
  const auto block = *std::ranges::find_if(blocks.directory(), [&](const auto& b) { return b["name"] == name; });
  const size_t offset = block["offset"], count = block["count"];
  std::vector<uint16_t> out;
  for (size_t i = offset; i < offset + count; ++i)
    out.push_back(uint16_t(uint8_t(blocks.buffer()[i]) | uint8_t(blocks.buffer()[i + count]) << 8));
  return out;
}

TEST(PageObjects, EachDrawnSurfelHasItsStoredId) {
  const test::TwoBalls balls;
  TrainedScene scene;
  scene.surfels.diffuse = balls.layer, scene.surfels.transmittance = balls.behind_glass;
  std::vector<uint16_t> inside(balls.behind_glass.size(), 0);
  inside[2] = 300;
  scene.surfels.transmittance.set_object_ids(inside);
  const ObjectSet set{.objects = {{.id = 1, .name = "kettle", .role = ObjectRole::Coat},
                                  {.id = 300, .name = "a case", .role = ObjectRole::ThinGlass, .trust = ObjectTrust::Guessed}},
                      .shapes = {}};
  for (const size_t most : {100000, 1200}) {
    const PageSurfels surfels = page_surfels(scene, std::vector<Vec3d>{{1, 0, 0}}, most);
    PageBlocks blocks;
    const ordered_json list = add_objects(set, scene.surfels, surfels, blocks);
    EXPECT_EQ(list.dump(), R"([{"id":1,"name":"kettle","role":"coat","trust":"given"},)"
                           R"({"id":300,"name":"a case","role":"thin_glass","trust":"guessed"}])");
    const std::vector<uint16_t> ids = words_of(blocks, "part_object");
    ASSERT_EQ(ids.size(), surfels.drawn);
    size_t of_kettle = 0;
    for (size_t k = 0; k < ids.size(); ++k) {
      const uint32_t i = surfels.of_diffuse[k];
      EXPECT_EQ(ids[k], i != UINT32_MAX ? balls.layer.object_ids()[i] : inside[surfels.of_inside[k]]) << k;
      of_kettle += ids[k] == 1;
    }
    EXPECT_GT(of_kettle, 100u);
    EXPECT_LT(of_kettle, ids.size());
  }
}

TEST(PageObjects, SurfelsWithoutIdsBelongToNone) {
  TrainedScene scene;
  scene.surfels.diffuse = test::sphere_layer(0.4, 100);
  PageBlocks blocks;
  const ObjectSet set{.objects = {{.id = 1, .name = "kettle"}}, .shapes = {}};
  add_objects(set, scene.surfels, page_surfels(scene, std::vector<Vec3d>{{1, 0, 0}}, 1000), blocks);
  EXPECT_EQ(words_of(blocks, "part_object"), std::vector<uint16_t>(100, 0));
}

TEST(PageObjects, AreAbsentWithoutATable) {
  const test::TwoBalls balls;
  for (const bool table : {true, false}) {
    std::map<std::string, fs::path> inputs = balls.artifacts();
    if (!table) inputs.erase("objects");
    test::RecordingContext context(inputs);
    write_view("<html><!-- the data --></html>", {.photo_side = 0, .rays = 8}, context);
    const std::string page = read_file(context.output() / "view.html");
    for (const char* block : {"part_object", "absent_object", "mesh_object"})
      EXPECT_EQ(page.find(block) != std::string::npos, table) << block;
    EXPECT_EQ(page.find("\"objects\":[]") == std::string::npos, table);
  }
}

}  // namespace
}  // namespace vitrine
