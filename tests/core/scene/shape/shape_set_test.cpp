// Several shapes together: which one a ray shows, subsets, and files of sets.
#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/scene/shape/shape_file.h"

namespace vitrine {
namespace {

Plane square(const Vec3d& centre, double half = 1) { return {centre, Mat3d::identity(), {half, half}}; }
const Ray kDown{{0.1, 0.2, 5}, {0, 0, -1}};

TEST(ShapeSet, ARayShowsTheNearestOfAllThatCount) {
  ShapeSet set;
  for (const double z : {1.0, 2.0, 3.0}) set.entries.push_back({square({0, 0, z}), ShapeRole::Mirror, 0.1, -1, {}});
  set.entries.push_back({square({0, 0, 4}), ShapeRole::Sheet, 0.1, -1, {}});
  ASSERT_TRUE(set.first_hit(kDown, ShapeRole::Mirror));
  EXPECT_EQ(set.first_hit(kDown, ShapeRole::Mirror)->entry, 2u);
  EXPECT_EQ(set.first_hit(kDown, ShapeRole::Sheet)->entry, 3u);
  const auto shown = [](const ShapeSet::Hit& hit) { return hit.t > 2.5; };
  EXPECT_EQ(set.first_hit(kDown, ShapeRole::Mirror, shown)->entry, 1u) << "what does not count hides nothing";
  EXPECT_FALSE(set.first_hit(kDown, ShapeRole::Mirror, [](const ShapeSet::Hit&) { return false; }));
}

TEST(ShapeSet, ABulgeIsItsParent) {
  constexpr double kTolerance = 0.2;
  ShapeSet set{{{square({0, 0, 1}), ShapeRole::Mirror, 0.1, -1, {}}}};
  set.entries.push_back({square({0, 0, 1.08}), ShapeRole::Mirror, kTolerance, 0, {}});
  EXPECT_EQ(set.first_hit(kDown, ShapeRole::Mirror)->entry, 0u);
  const auto not_it = [](const ShapeSet::Hit& hit) { return hit.entry != 0; };
  EXPECT_EQ(set.first_hit(kDown, ShapeRole::Mirror, not_it)->entry, 1u) << "the parent does not count here";
  set.entries[1].shape = square({0, 0, 1.12});
  EXPECT_EQ(set.first_hit(kDown, ShapeRole::Mirror)->entry, 1u);
  Plane steep = square({0.1, 0.2, 1.05});
  const double c = std::cos(0.6), s = std::sin(0.6);
  steep.axes = {{c, 0, -s}, {0, 1, 0}, {s, 0, c}};
  set.entries[1].shape = steep;
  EXPECT_EQ(set.first_hit(kDown, ShapeRole::Mirror)->entry, 1u) << "turned away";
  EXPECT_EQ(set.root(1), 0u);
}

TEST(ShapeSet, SubsetsAndUnionsKeepFamiliesTogether) {
  ShapeSet set;
  for (const int parent : {-1, -1, 1, 2, 0}) {
    const double z = double(set.entries.size());
    set.entries.push_back({square({0, 0, z}), ShapeRole::Mirror, 0.1, parent, {}});
  }
  const ShapeSet some = set.kept(std::vector<uint8_t>{0, 1, 1, 1, 1});
  ASSERT_EQ(some.entries.size(), 3u) << "an appendage goes with what it stands out of";
  EXPECT_EQ(some.entries[0].parent, -1);
  EXPECT_EQ(some.entries[1].parent, 0);
  EXPECT_EQ(some.entries[2].parent, 1);
  EXPECT_EQ(std::get<Plane>(some.entries[2].shape).centre.z, 3);
  EXPECT_TRUE(set.kept(std::vector<uint8_t>{1, 0, 1, 1, 0}).entries.size() == 1);
  ShapeSet both{{{square({}), ShapeRole::Sheet, 0.1, -1, {}}}};
  both.append(some);
  EXPECT_EQ(both.entries[3].parent, 2);
  EXPECT_EQ(both.without(ShapeRole::Sheet).entries[2].parent, 1);
  EXPECT_FALSE(both.without(ShapeRole::Mirror).has(ShapeRole::Mirror));
  both.entries.push_back({square({}), ShapeRole::Solid, 0.1, -1, {}});
  EXPECT_EQ(both.glass().entries.size(), 2u);
  EXPECT_EQ(both.no_glass().entries.size(), some.entries.size());
  EXPECT_TRUE(both.has_glass());
  EXPECT_FALSE(some.has_glass());
}

TEST(ShapeFile, KeepsSetsAndRefusesWhatIsNone) {
  const TemporaryFolder folder;
  Rng rng(3, 1);
  ShapeSet set;
  for (const ShapeKind& kind : shape_kinds()) set.entries.push_back({kind.sample(rng), ShapeRole::Mirror, 0.25, -1, {}});
  set.entries.back().parent = 1;
  set.entries[0].role = ShapeRole::Sheet, set.entries[0].clear = {1, 0};
  set.entries[1].role = set.entries.back().role = ShapeRole::Solid;
  set.entries[2].role = ShapeRole::Coat, set.entries[2].exact = false, set.entries[2].layered = 0.25;
  const std::string text = write_shapes(set, folder.path()).dump();
  const ShapeSet back = read_shapes(nlohmann::json::parse(text), folder.path());
  ASSERT_EQ(back.entries.size(), set.entries.size());
  EXPECT_EQ(write_shapes(back, folder.path()).dump(), text);
  EXPECT_FALSE(back.entries[0].is_clear(1));
  EXPECT_EQ(back.entries.back().parent, 1);
  EXPECT_EQ(back.entries[2].role, ShapeRole::Coat);
  EXPECT_EQ(back.entries[1].role, ShapeRole::Solid);
  EXPECT_FALSE(back.entries[2].exact);
  EXPECT_EQ(back.entries[2].layered, 0.25);
  EXPECT_EQ(back.entries[1].layered, 1);
  EXPECT_TRUE(back.entries[1].exact);
  const auto refused = [&](size_t entry, const char* key, const nlohmann::json& value) {
    nlohmann::json json = nlohmann::json::parse(text);
    json[entry][key] = value;
    try {
      read_shapes(json, folder.path());
    } catch (const std::domain_error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(refused(1, "kind", "torus"), "shape 1: there is no such kind");
  EXPECT_EQ(refused(1, "role", "door"), "shape 1: there is no role \"door\"; the roles are mirror, sheet, coat, solid");
  EXPECT_EQ(refused(1, "tolerance", 0), "shape 1: its tolerance is not positive");
  EXPECT_EQ(refused(1, "parent", 1), "shape 1: its parent is unknown");
  EXPECT_EQ(refused(1, "parent", 0), "shape 1: its parent has another role");
  EXPECT_EQ(refused(1, "clear", {1}), "shape 1: its clear facets are not its facets");
  EXPECT_EQ(refused(1, "low", {9, 9, 9}), "shape 1: its numbers are no box");
}

}  // namespace
}  // namespace vitrine
