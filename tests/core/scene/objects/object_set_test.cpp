// The table of objects and its labels in files.
#include "core/scene/objects/object_set.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/scene/image/ldr.h"
#include "core/scene/objects/object_labels.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

const Box kBox{Mat3d::identity(), {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.2}};

ShapeSet::Entry entry(const Shape& shape, ObjectRole role, uint16_t object, bool exact = true, int parent = -1) {
  return {.shape = shape,
          .role = shape_role(role),
          .tolerance = 0.01,
          .parent = parent,
          .clear = {},
          .exact = exact,
          .object = object};
}

TriMesh tetrahedron() {
  TriMesh mesh;
  mesh.positions = {{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, {0, 0, 0.1f}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

// A case, a kettle with a handle, a guessed mirror, a hull of a spoon, a block of glass, and a coat that nothing fixes in space.
ObjectSet table() {
  ObjectSet set;
  set.objects = {{.id = 1, .name = "case", .role = ObjectRole::ThinGlass, .trust = ObjectTrust::Marked},
                 {.id = 2, .name = "kettle", .role = ObjectRole::Mirror, .trust = ObjectTrust::Given},
                 {.id = 5, .name = "mirror-2", .role = ObjectRole::Mirror, .trust = ObjectTrust::Guessed},
                 {.id = 6, .name = "spoon", .role = ObjectRole::Mirror, .trust = ObjectTrust::Detected},
                 {.id = 7, .name = "paperweight", .role = ObjectRole::SolidGlass, .trust = ObjectTrust::Given},
                 {.id = 9, .name = "coat-1", .role = ObjectRole::Coat, .trust = ObjectTrust::Given},
                 {.id = 10, .name = "book", .role = ObjectRole::Opaque, .trust = ObjectTrust::Given}};
  set.objects[1].evidence = {.views = 12, .inside = 0.97, .covered = 0.95, .view_dependence = 0.6};
  set.objects[4].evidence = {.views = 3, .straight = -0.05, .bent = 0.6};
  const Shape mesh = TriangleShape(tetrahedron());
  set.shapes.entries = {entry(kBox, ObjectRole::ThinGlass, 1),       entry(kBox, ObjectRole::Mirror, 2),
                        entry(mesh, ObjectRole::Mirror, 2, true, 1), entry(kBox, ObjectRole::Mirror, 5),
                        entry(mesh, ObjectRole::Mirror, 6, false),   entry(kBox, ObjectRole::SolidGlass, 7),
                        entry(mesh, ObjectRole::Opaque, 10)};
  return set;
}

TEST(ObjectTable, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  const ObjectSet set = table();
  write_objects(folder.path(), set);
  for (const fs::path& given : {folder.path(), folder.path() / "objects.json"}) {
    const ObjectSet read = read_objects_file(given);
    ASSERT_EQ(read.objects.size(), set.objects.size());
    for (size_t i = 0; i < set.objects.size(); ++i) {
      EXPECT_EQ(read.objects[i].id, set.objects[i].id);
      EXPECT_EQ(read.objects[i].name, set.objects[i].name);
      EXPECT_EQ(read.objects[i].role, set.objects[i].role);
      EXPECT_EQ(read.objects[i].trust, set.objects[i].trust);
      EXPECT_EQ(read.objects[i].evidence.views, set.objects[i].evidence.views);
      EXPECT_EQ(read.objects[i].evidence.view_dependence, set.objects[i].evidence.view_dependence);
      EXPECT_EQ(read.objects[i].evidence.inside, set.objects[i].evidence.inside);
      EXPECT_EQ(read.objects[i].evidence.straight, set.objects[i].evidence.straight);
      EXPECT_EQ(read.objects[i].evidence.bent, set.objects[i].evidence.bent);
    }
    ASSERT_EQ(read.shapes.entries.size(), set.shapes.entries.size());
    for (size_t i = 0; i < set.shapes.entries.size(); ++i) {
      EXPECT_EQ(read.shapes.entries[i].object, set.shapes.entries[i].object);
      EXPECT_EQ(read.shapes.entries[i].role, set.shapes.entries[i].role);
      EXPECT_EQ(read.shapes.entries[i].parent, set.shapes.entries[i].parent);
      EXPECT_EQ(read.shapes.entries[i].exact, set.shapes.entries[i].exact);
      EXPECT_EQ(read.shapes.entries[i].shape.index(), set.shapes.entries[i].shape.index());
    }
  }
}

TEST(ObjectTable, NothingIsDoneWithWhatIsGuessedOrOpaque) {
  const ObjectSet trusted = table().trusted();
  std::vector<uint16_t> ids, of_shapes;
  for (const Object& o : trusted.objects) ids.push_back(o.id);
  for (const ShapeSet::Entry& e : trusted.shapes.entries) of_shapes.push_back(e.object);
  EXPECT_EQ(ids, (std::vector<uint16_t>{1, 2, 6, 7, 9}));
  EXPECT_EQ(of_shapes, (std::vector<uint16_t>{1, 2, 2, 6, 7}));
  EXPECT_EQ(trusted.shapes.entries[2].parent, 1);
}

TEST(ObjectTable, DrawsExactShapesOfGlassAndMirrors) {
  const ObjectSet trusted = table().trusted();
  const ShapeSet drawn = trusted.drawn_shapes();
  std::vector<uint16_t> ids;
  for (const ShapeSet::Entry& e : drawn.entries) ids.push_back(e.object);
  EXPECT_EQ(ids, (std::vector<uint16_t>{1, 2, 2, 7})) << "no hull";
  EXPECT_TRUE(trusted.is_drawn_mirror(*trusted.find(2)));
  EXPECT_FALSE(trusted.is_drawn_mirror(*trusted.find(6)));
  EXPECT_FALSE(trusted.is_drawn_mirror(*trusted.find(9)));
}

std::string with(const std::string& objects) { return "{\"format\": 1,\n\"objects\": [\n" + objects + "\n]}"; }

TEST(ObjectTable, NamesThePlaceOfAMistake) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "objects.json";
  const auto detail = [&](const std::string& text) {
    write_file(file, text);
    const Error e = error_of([&] { read_objects_file(file); });
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    return e.detail();
  };
  const std::string good = R"({"id": 1, "name": "a", "role": "mirror"})";
  const auto expect = [&](const std::string& text, int line, const std::string& why) {
    const auto d = detail(text);
    EXPECT_TRUE(d.where.starts_with(fmt::format("{}:{}:", file.string(), line))) << d.where;
    EXPECT_NE(d.why.find(why), std::string::npos) << d.why;
  };
  expect(with(good + ",\n" + good), 4, "two objects have the id 1");
  expect(with(good + ",\n" + R"({"id": 2, "name": "a", "role": "coat"})"), 4, "two objects are called \"a\"");
  expect(with(R"({"id": 1, "name": "a", "role": "metal"})"), 3, "there is no role \"metal\"; there are opaque, thin_glass,");
  expect(with(R"({"id": 1, "name": "a", "role": "coat", "trust": "sure"})"), 3, "there is no trust \"sure\"");
  expect(with(R"({"id": 0, "name": "a", "role": "coat"})"), 3, "whole number from 1 to 65534");
  expect(with(R"({"id": 1, "name": "", "role": "coat"})"), 3, "at least one letter");
  expect(with(R"({"id": 1, "name": "a", "role": "coat", "shapes": [{"kind": "cube"}]})"), 3, "there is no such kind");
  expect(with(R"({"id": 1, "name": "a", "role": "coat", "shapes": [{"kind": "box", "parent": 0}]})"), 3, "parent");
  const std::string outside = R"([{"kind": "triangles", "tolerance": 1, "mesh": "../x.ply"}])";
  EXPECT_NE(detail(with(R"({"id": 1, "name": "a", "role": "coat", "shapes": )" + outside + "}"))
                .why.find("'../x.ply' is not a path inside"),
            std::string::npos);
  detail("{}"), detail("{\"objects\": 3}"), detail("no JSON");
}

// [h,w] of ids, two objects side by side.
struct Labelled {
  TemporaryFolder folder;
  View view{.name = "a/b.jpg", .intrinsics = {8, 4, 5, 5, 4, 2}, .cam_from_world = {}};
  explicit Labelled(const ObjectSet& set) {
    make_folders(folder.path() / "objects");
    write_objects(folder.path() / "objects", set);
    Image16 labels(8, 4, 1);
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 8; ++x) labels.at(x, y) = x < 3 ? 1 : x < 5 ? 5 : x < 7 ? 9 : 0;
    make_folders(label_path(folder.path(), view).parent_path());
    write_png16(label_path(folder.path(), view), labels);
  }
};

TEST(ObjectLabels, CoverTheObjectsThatCount) {
  const Labelled files(table());
  const auto all = LabelledObjects::all(files.folder.path()), trusted = LabelledObjects::trusted(files.folder.path());
  const Image16 labels = all.labels(files.view, files.view.intrinsics);
  EXPECT_EQ(labels.at(0, 0), 1);
  EXPECT_EQ(labels.at(4, 3), 5);
  EXPECT_EQ(labels.at(7, 1), 0);
  EXPECT_EQ(trusted.labels(files.view, files.view.intrinsics).at(4, 3), 0) << "guessed";
  const auto specular = [](const Object& o) { return is_specular(o.role); };
  const ImageF half = all.coverage(files.view, files.view.intrinsics.scaled_to(4, 2), specular);
  EXPECT_EQ(half.at(0, 0), 1);
  EXPECT_EQ(half.at(3, 1), 0.5f);
  const ImageF sure = trusted.coverage(files.view, files.view.intrinsics.scaled_to(4, 2), specular);
  EXPECT_EQ(sure.at(1, 0), 0.5f);
  EXPECT_EQ(sure.at(2, 0), 0.5f);
  View other = files.view;
  other.name = "c.jpg";
  EXPECT_TRUE(all.labels(other, other.intrinsics).empty());
  EXPECT_TRUE(LabelledObjects().labels(files.view, files.view.intrinsics).empty());
}

TEST(ClassPixels, GlassReflectsAsWell) {
  const Labelled files(table());
  const ClassPixels pixels(std::nullopt, LabelledObjects::all(files.folder.path()));
  EXPECT_TRUE(pixels.has(MaskClass::Transparent));
  EXPECT_FALSE(pixels.has(MaskClass::Object));
  const ImageF glass = *pixels.of(MaskClass::Transparent, files.view), specular = *pixels.of(MaskClass::Specular, files.view);
  EXPECT_EQ(std::ranges::count(glass.data(), 1.f), 3 * 4);
  EXPECT_EQ(std::ranges::count(specular.data(), 1.f), 7 * 4);
  EXPECT_FALSE(pixels.of(MaskClass::Object, files.view));
}

}  // namespace
}  // namespace vitrine
