// What the page knows of every surfel for edits, on two balls of which that is known by construction.
#include "stages/view/page_surfels.h"

#include <gtest/gtest.h>

#include "core/scene/camera/mask_class.h"
#include "stages/view/page_blocks.h"
#include "stages/view/view.h"
#include "tests/stages/edit/two_balls.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using nlohmann::ordered_json;

// A sheet whose glass is the second ball: known glass is not drawn by its surfels.
class PageEdits : public testing::Test {
 protected:
  PageEdits()
      : scene(read_edit_scene(
            {.optimize = balls.capture.optimize(), .mesh = balls.capture.mesh(), .decompose = balls.decompose()})) {
    for (size_t i = 0; i < scene.trained.surfels.diffuse.size(); ++i)
      *scene.trained.surfels.diffuse.at(Attribute::Transmission, i) = balls.in_b(i) ? 4.f : -4.f;
    auto set = std::make_shared<ShapeSet>();
    set->entries.push_back({.shape = Box{Mat3d::identity(), balls.kB - kHalf, balls.kB + kHalf},
                            .role = ShapeRole::Sheet,
                            .tolerance = balls.kRadiusB,
                            .clear = {}});
    scene.trained.image.shape.set = set;
    scene.trained.image.transmission.glass = Glass::Thin;
    surfels = page_surfels(scene.trained, std::vector<Vec3d>{{1, 0, 0}}, 100000);
    mark_sky(*scene.materials, surfels);
    shapes = add_shapes(set.get(), blocks);
  }
  std::vector<uint8_t> bytes(const char* name) const {
    const auto entry = *std::ranges::find_if(blocks.directory(), [&](const auto& b) { return b["name"] == name; });
    const auto* begin = reinterpret_cast<const uint8_t*>(blocks.buffer().data()) + entry["offset"].get<size_t>();
    return {begin, begin + entry["count"].get<size_t>()};
  }
  static inline const Vec3d kHalf{test::TwoBalls::kRadiusB, test::TwoBalls::kRadiusB, test::TwoBalls::kRadiusB};
  test::TwoBalls balls;
  EditScene scene;
  PageSurfels surfels;
  PageBlocks blocks;
  ordered_json shapes;
};

TEST_F(PageEdits, SurfelsKnowTheirClassAndTheirComponent) {
  const ordered_json edits =
      add_edits(scene, balls.capture.views, {balls.masks(), LabelledObjects::all(balls.masks())}, surfels, shapes, blocks);
  EXPECT_EQ(edits["classes"], ordered_json::array({"specular"}));
  EXPECT_EQ(edits["components"], 2);
  EXPECT_FALSE(edits.contains("no_classes"));
  const std::vector<uint8_t> classes = bytes("part_class"), components = bytes("part_component");
  ASSERT_EQ(classes.size(), surfels.drawn);
  constexpr uint8_t kSpecular = 1 << static_cast<int>(MaskClass::Specular);
  size_t of_a = 0, inside = 0;
  for (size_t k = 0; k < surfels.drawn; ++k) {
    const uint32_t i = surfels.of_diffuse[k], j = surfels.of_inside[k];
    ASSERT_NE(i == UINT32_MAX, j == UINT32_MAX);
    if (j != UINT32_MAX) {
      EXPECT_EQ(components[k], j < balls.kInside ? 1 : 2) << "what glass shows is inside its component";
      ++inside;
    } else if (balls.in_a(i)) {
      EXPECT_EQ(classes[k], kSpecular) << i;
      EXPECT_EQ(components[k], i < balls.kSurfelsA ? 1 : 0) << "the hidden one lies in the middle, far from the mesh";
      ++of_a;
    }
  }
  EXPECT_EQ(inside, 2 * balls.kInside);
  EXPECT_EQ(of_a, balls.kSurfelsA + balls.kHidden);
}

TEST_F(PageEdits, SurfelsThatAreNotDrawnStandBehindThem) {
  SplatLayer& diffuse = scene.trained.surfels.diffuse;
  std::vector<uint16_t> ids(diffuse.size());
  for (size_t i = 0; i < ids.size(); ++i) ids[i] = balls.in_b(i) ? 7 : 1;
  diffuse.set_object_ids(ids);
  add_edits(scene, balls.capture.views, {balls.masks(), LabelledObjects::all(balls.masks())}, surfels, shapes, blocks);
  const std::vector<uint8_t> components = bytes("absent_component");
  ASSERT_EQ(components.size(), balls.kSurfelsB);
  EXPECT_TRUE(std::ranges::all_of(components, [](uint8_t c) { return c == 2; }));
  EXPECT_EQ(bytes("absent_object"), std::vector<uint8_t>(balls.kSurfelsB, 7)) << "low bytes of their ids";
  EXPECT_EQ(bytes("absent_place").size(), 3 * balls.kSurfelsB) << "counted in numbers of 16 bits";
  EXPECT_EQ(shapes["entries"][0]["surfels"], balls.kSurfelsB) << "all its glass shows the sheet";
  EXPECT_EQ(shapes["entries"][0]["parent"], -1);
}

TEST_F(PageEdits, WithoutMasksThePageSaysWhyThereAreNoClasses) {
  const ordered_json edits = add_edits(scene, balls.capture.views, {}, surfels, shapes, blocks);
  EXPECT_TRUE(edits["classes"].empty());
  EXPECT_NE(edits["no_classes"].get<std::string>().find("--masks marks.yaml"), std::string::npos);
  EXPECT_TRUE(std::ranges::all_of(bytes("part_class"), [](uint8_t c) { return c == 0; }));
}

TEST(PageOfEdits, AnEditedSceneIsNotEditedAgain) {
  const test::TwoBalls balls;
  write_file(balls.capture.optimize() / "edits.yaml", "edits: []\n");
  test::RecordingContext context(balls.artifacts());
  write_view("<html><!-- the data --></html>", {.photo_side = 0, .rays = 8}, context);
  const std::string page = read_file(context.output() / "view.html");
  EXPECT_NE(page.find("\"edits\":{\"there\":false,\"why\":\"This page shows edits that were made."), std::string::npos);
}

}  // namespace
}  // namespace vitrine
