// Which polished faces are on a known shape.
#include "stages/decompose/polished_faces.h"

#include <gtest/gtest.h>

namespace vitrine {
namespace {

// A small triangle at a height; no two hang together.
void add_face(TriMesh& mesh, float x, float y, float z) {
  const auto first = uint32_t(mesh.positions.size());
  for (const Vec3f& off : {Vec3f{-0.01f, -0.01f, 0}, Vec3f{0.02f, -0.01f, 0}, Vec3f{-0.01f, 0.02f, 0}})
    mesh.positions.push_back(Vec3f{x, y, z} + off);
  mesh.faces.push_back({first, first + 1, first + 2});
}

TEST(PolishedFaces, AreOnAShapeUpToTwoTolerancesFromIt) {
  ShapeSet shapes;
  const Mat3d axes = Mat3d::identity();
  shapes.entries.push_back({.shape = Box{axes, {-1, -1, -1}, {1, 1, 1}}, .tolerance = 0.1, .clear = {}});
  shapes.entries.push_back({.shape = Box{axes, {-0.2, -0.2, 1}, {0.2, 0.2, 1.4}}, .tolerance = 0.1, .parent = 0, .clear = {}});
  shapes.entries.push_back({.shape = Box{axes, {-1, -1, 3}, {1, 1, 4}}, .role = ShapeRole::Sheet, .tolerance = 0.1, .clear = {}});
  TriMesh mesh;
  add_face(mesh, 0.5f, 0, 1.19f);   // within two tolerances of the box
  add_face(mesh, 0.5f, 0, 1.21f);   // beyond
  add_face(mesh, 1.15f, 1.15f, 0);  // beyond, though within two of each side
  add_face(mesh, 0, 0, 1.45f);      // on what stands out of the box
  add_face(mesh, 0, 0, 3);          // on glass
  const PolishedFaces faces = polished_faces(mesh, std::vector<uint8_t>(mesh.faces.size(), 1), &shapes, {});
  const auto known = [&](size_t face) { return faces.known[size_t(faces.thing[face])]; };
  EXPECT_EQ(known(0), 0);
  EXPECT_EQ(known(1), -1);
  EXPECT_EQ(known(2), -1);
  EXPECT_EQ(known(3), 0);
  EXPECT_EQ(faces.thing[3], faces.thing[0]) << "an appendage is of one thing with its parent";
  EXPECT_EQ(known(4), -1);
  EXPECT_NE(faces.thing[1], faces.thing[2]);
}

TEST(PolishedFaces, AreOnNoneWithoutShapes) {
  TriMesh mesh;
  add_face(mesh, 0, 0, 0);
  add_face(mesh, 1, 0, 0);
  const PolishedFaces faces = polished_faces(mesh, {1, 0}, nullptr, {});
  EXPECT_EQ(faces.thing, (std::vector<int>{0, -1}));
  EXPECT_EQ(faces.known, std::vector<int>{-1});
}

}  // namespace
}  // namespace vitrine
