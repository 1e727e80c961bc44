// The objects of a scene in the files that know them: names, and which faces, vertices and surfels are theirs.
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "core/scene/objects/object_set.h"
#include "stages/export/export.h"
#include "tests/stages/export/float_ply.h"
#include "tests/stages/export/glb_reader.h"
#include "tests/stages/export/pane_scene.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

constexpr uint16_t kPane = 3, kTile = 7;  // the table knows the pane alone

bool on_tile(const Vec3f& p) { return p.x > 0.5f && p.z < 0.01f; }

class ObjectNames : public testing::Test {
 protected:
  ObjectNames() {
    std::vector<uint16_t> of_surfel;
    for (size_t i = 0; i < scene_.diffuse.size(); ++i) {
      const float* p = scene_.diffuse.at(Attribute::Mean, i);
      of_surfel.push_back(i >= 1600 ? kPane : on_tile({p[0], p[1], p[2]}) ? kTile : uint16_t(0));
    }
    scene_.diffuse.set_object_ids(std::move(of_surfel));
    for (size_t v = 0; v < scene_.mesh.positions.size(); ++v)
      scene_.mesh.object_ids.push_back(v >= 41 * 41 ? kPane : on_tile(scene_.mesh.positions[v]) ? kTile : uint16_t(0));
    scene_.write(root_.path());
    ObjectSet set;
    set.objects = {{.id = 1, .name = "guess", .role = ObjectRole::Mirror, .trust = ObjectTrust::Guessed},
                   {.id = kPane, .name = "mesh \"é\"", .role = ObjectRole::ThinGlass}};
    make_folders(root_.path() / "objects/objects");
    write_objects(root_.path() / "objects/objects", set);
    for (size_t f = 0; f < scene_.mesh.faces.size(); ++f) ++faces_[scene_.mesh.object_of_face(f)];
  }

  fs::path exported(std::vector<std::string> formats) {
    context_.emplace(std::map<std::string, fs::path>{{"sfm", root_.path() / "sfm"},
                                                     {"optimize", root_.path() / "optimize"},
                                                     {"mesh", root_.path() / "mesh"},
                                                     {"objects", root_.path() / "objects"}});
    run_export({.formats = std::move(formats), .texture_size = 256}, *context_);
    return context_->output() / "export";
  }

  TemporaryFolder root_;
  test::PaneScene scene_;
  std::map<uint16_t, size_t> faces_;  // of the mesh, by object
  std::optional<test::RecordingContext> context_;
};

TEST_F(ObjectNames, AreNodesOfTheGlb) {
  const test::Glb glb(exported({"mesh-glb"}) / "mesh.glb");
  std::map<std::string, size_t> corners;
  std::set<size_t> below{0};
  for (const auto& child : glb.doc["nodes"][0]["children"]) below.insert(size_t(child));
  for (size_t n = 0; n < glb.doc["nodes"].size(); ++n) {
    const auto& node = glb.doc["nodes"][n];
    EXPECT_TRUE(below.contains(n)) << "no node stands alone";
    for (const auto& p : glb.doc["meshes"][size_t(node["mesh"])]["primitives"])
      corners[node["name"]] += glb.indices(p["indices"]).size();
  }
  EXPECT_EQ(corners, (std::map<std::string, size_t>{
                         {"scene", 3 * faces_[0]}, {"mesh \"é\"", 3 * faces_[kPane]}, {"object-7", 3 * faces_[kTile]}}));
}

TEST_F(ObjectNames, AreObjectsOfTheObj) {
  std::istringstream in(read_file(exported({"mesh-obj"}) / "mesh.obj"));
  std::map<std::string, size_t> faces;
  std::string current = "none";
  for (std::string line; std::getline(in, line);) {
    EXPECT_FALSE(line.starts_with("g ")) << "a group would rename the object";
    if (line.starts_with("o ")) current = line.substr(2);
    if (line.starts_with("f ")) ++faces[current];
  }
  EXPECT_EQ(faces,
            (std::map<std::string, size_t>{{"scene", faces_[0]}, {"mesh \"é\"", faces_[kPane]}, {"object-7", faces_[kTile]}}));
}

TEST_F(ObjectNames, ArePrimsOfTheUsd) {
  const std::string text = read_file(exported({"mesh-usd"}) / "mesh.usda");
  EXPECT_NE(text.find("  def Mesh \"mesh\"\n"), std::string::npos) << "what belongs to none";
  EXPECT_NE(text.find("  def Mesh \"mesh_____\" (\n    displayName = \"mesh \\\"é\\\"\"\n"), std::string::npos);
  EXPECT_NE(text.find("  def Mesh \"object_7\" (\n    displayName = \"object-7\"\n"), std::string::npos);
  // Each prim has its own vertices: the largest index is the number of its points less one.
  size_t prims = 0;
  for (size_t at = text.find("faceVertexIndices"); at != std::string::npos; at = text.find("faceVertexIndices", at + 1)) {
    ++prims;
    const size_t first = text.find('[', text.find('=', at)) + 1, points = text.find("points = [", at);
    std::string list = text.substr(first, text.find(']', first) - first);
    std::ranges::replace(list, ',', ' ');
    std::istringstream numbers(list);
    size_t most = 0;
    for (size_t i = 0; numbers >> i;) most = std::max(most, i);
    const std::string of_points = text.substr(points, text.find(']', points) - points);
    EXPECT_EQ(most + 1, size_t(std::ranges::count(of_points, '(')));
  }
  EXPECT_EQ(prims, 3u);
}

TEST_F(ObjectNames, OfPrimsDiffer) {
  ObjectSet set;
  set.objects = {{.id = kPane, .name = "mesh"}, {.id = kTile, .name = "mesh_"}};
  write_objects(root_.path() / "objects/objects", set);
  const std::string text = read_file(exported({"mesh-usd"}) / "mesh.usda");
  for (const char* prim : {"  def Mesh \"mesh\"\n", "  def Mesh \"mesh_\" (\n    displayName = \"mesh\"\n",
                           "  def Mesh \"mesh__\" (\n    displayName = \"mesh_\"\n"})
    EXPECT_NE(text.find(prim), std::string::npos) << prim;
}

TEST_F(ObjectNames, AreTheLegendOfIdsInPlyFiles) {
  const fs::path folder = exported({"ply-2dgs", "ply-3dgs", "mesh-ply"});
  for (const char* file : {"gaussians_2dgs.ply", "gaussians_3dgs.ply"}) {
    const test::FloatPly ply = test::parsed_ply(folder / file);
    EXPECT_EQ(ply.properties.back(), "object_id");
    EXPECT_TRUE(std::ranges::none_of(ply.comments, [](const std::string& c) { return c.starts_with("object 1"); })) << "guessed";
    EXPECT_EQ(ply.comments.back(), "object 3: mesh \"é\", thin_glass");
    for (size_t i = 0; i < ply.rows.size(); ++i) ASSERT_EQ(ply.value(i, "object_id"), float(scene_.diffuse.object_ids()[i]));
  }
  const TriMesh mesh = read_mesh_ply(folder / "mesh.ply");
  EXPECT_EQ(mesh.object_ids, scene_.mesh.object_ids);
  EXPECT_NE(read_file(folder / "mesh.ply").find("comment object 3: mesh \"é\", thin_glass\n"), std::string::npos);
}

}  // namespace
}  // namespace vitrine
