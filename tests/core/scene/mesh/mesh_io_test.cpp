#include "core/scene/mesh/mesh_io.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/rng.h"
#include "tests/core/scene/mesh/shapes.h"

namespace vitrine {
namespace {

TriMesh coloured_sphere() {
  TriMesh m = shapes::sphere({1, 2, 3}, 0.5f, 12, 16);
  Rng rng(7);
  for (size_t v = 0; v < m.positions.size(); ++v) m.colors.push_back({rng.uniform(), rng.uniform(), rng.uniform()});
  return m;
}

TEST(MeshPly, RoundTripKeepsGeometryExactlyAndColoursToEightBits) {
  const TemporaryFolder folder;
  const TriMesh mesh = coloured_sphere();
  write_mesh_ply(folder.path() / "a.ply", mesh);
  const TriMesh back = read_mesh_ply(folder.path() / "a.ply");
  EXPECT_EQ(back.positions, mesh.positions);
  EXPECT_EQ(back.normals, mesh.normals);
  EXPECT_EQ(back.faces, mesh.faces);
  ASSERT_EQ(back.colors.size(), mesh.colors.size());
  for (size_t v = 0; v < mesh.colors.size(); ++v)
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(back.colors[v][c], mesh.colors[v][c], 0.005);  // half a step at white: 0.0045
  write_mesh_ply(folder.path() / "b.ply", back);
  EXPECT_EQ(read_file(folder.path() / "a.ply"), read_file(folder.path() / "b.ply"));
}

TEST(MeshPly, ReadsAsciiQuadsWithForeignPropertiesAndElements) {
  const TemporaryFolder folder;
  write_file(folder.path() / "q.ply",
             "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nelement vertex 4\r\nproperty double x\r\nproperty double y\r\n"
             "property double z\r\nproperty float quality\r\nelement camera 1\r\nproperty list uchar float data\r\n"
             "element face 1\r\nproperty uchar part\r\nproperty list uchar int vertex_index\r\nend_header\r\n"
             "0 0 0 9\r\n1 0 0 9\r\n1 1 0 9\r\n0 1 -2.5e-1 9\r\n3 1 2 3\r\n7 4 0 1 2 3");
  const TriMesh m = read_mesh_ply(folder.path() / "q.ply");
  ASSERT_EQ(m.positions.size(), 4u);
  EXPECT_EQ(m.positions[3], (Vec3f{0, 1, -0.25f}));
  ASSERT_EQ(m.faces.size(), 2u);
  EXPECT_EQ(m.faces[0], (std::array<uint32_t, 3>{0, 1, 2}));
  EXPECT_EQ(m.faces[1], (std::array<uint32_t, 3>{0, 2, 3}));
  EXPECT_TRUE(m.normals.empty());
}

TEST(MeshPly, ReadsBigEndian) {
  const TemporaryFolder folder;
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar ushort vertex_indices\nend_header\n";
  for (float v : {0.f, 0.f, 0.f, 1.5f, 0.f, 0.f, 0.f, -2.f, 0.f}) {
    uint32_t bits = std::bit_cast<uint32_t>(v);
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(bits >> shift & 0xff);
  }
  bytes += std::string("\3\0\0\0\1\0\2", 7);
  write_file(folder.path() / "be.ply", bytes);
  const TriMesh m = read_mesh_ply(folder.path() / "be.ply");
  EXPECT_EQ(m.positions[1], (Vec3f{1.5f, 0, 0}));
  EXPECT_EQ(m.positions[2], (Vec3f{0, -2.f, 0}));
  EXPECT_EQ(m.faces.at(0), (std::array<uint32_t, 3>{0, 1, 2}));
}

std::string reason_of(const fs::path& path) {
  try {
    read_mesh_ply(path);
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_EQ(e.detail().where, path.string());
    return e.detail().why;
  }
  return "accepted";
}

TEST(MeshPly, SaysWhatIsWrongWithABadFile) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "bad.ply";
  const std::string vertex = "property float x\nproperty float y\nproperty float z\n";
  const std::string face = "property list uchar int vertex_indices\nend_header\n";
  const auto reason = [&](const std::string& bytes) {
    write_file(path, bytes);
    return reason_of(path);
  };
  EXPECT_NE(reason("").find("no end"), std::string::npos);
  EXPECT_NE(reason("obj\n").find("begin with"), std::string::npos);
  EXPECT_NE(
      reason("ply\nformat binary_little_endian 1.0\nelement vertex 123456789012345\n" + vertex + "end_header\n").find("promises"),
      std::string::npos);
  EXPECT_NE(reason("ply\nformat ascii 1.0\nelement vertex 1\n" + vertex + "element face 1\n" + face + "0 0 0\n3 0 0 1\n")
                .find("vertex 1 of 1"),
            std::string::npos);
  EXPECT_NE(reason("ply\nformat ascii 1.0\nelement vertex 1\n" + vertex + "element face 1\n" + face + "0 0 0\n300 0 0 1\n")
                .find("list of 300"),
            std::string::npos);
  EXPECT_NE(reason("ply\nformat ascii 1.0\nelement vertex 1\n" + vertex + "end_header\n0 nan 0\n").find("finite"),
            std::string::npos);
  EXPECT_NE(reason("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n").find("no x, y, z"),
            std::string::npos);
}

// Every truncation, and thousands of flipped bytes: an answer or an Error{Input}, never a crash or a huge allocation.
TEST(MeshPly, SurvivesTruncationAndRandomDamage) {
  const TemporaryFolder folder;
  TriMesh mesh = shapes::cube();
  for (const Vec3f& p : mesh.positions) mesh.colors.push_back(p);
  write_mesh_ply(folder.path() / "good.ply", mesh);
  const std::string good = read_file(folder.path() / "good.ply");
  const fs::path path = folder.path() / "bad.ply";
  const auto write_quickly = [&](const std::string& bytes) {
    fs::remove(path);  // replacing a file in place makes some file systems flush
    FILE* f = std::fopen(path.c_str(), "wb");
    std::fwrite(bytes.data(), 1, bytes.size(), f);
    std::fclose(f);
  };
  for (size_t size = 0; size < good.size(); ++size) {
    write_quickly(good.substr(0, size));
    EXPECT_NE(reason_of(path), "accepted") << "truncated to " << size;
  }
  Rng rng(11);
  size_t refused = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    std::string bytes = good;
    for (uint32_t k = 0, n = 1 + rng.below(4); k < n; ++k)
      bytes[rng.below(static_cast<uint32_t>(bytes.size()))] = static_cast<char>(rng.next_u32());
    write_quickly(bytes);
    refused += reason_of(path) != "accepted";
  }
  EXPECT_GT(refused, 200u);
}

}  // namespace
}  // namespace vitrine
