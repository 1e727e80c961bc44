// The same triangles, rounded as the header says, in an order that caches like.
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/rigid.h"
#include "stages/export/formats/compact_mesh.h"

namespace vitrine {
namespace {

constexpr uint32_t kSide = 40;

// A bumpy sheet, its triangles shuffled; every third is of the second part. One vertex is of no triangle.
struct Sheet {
  std::vector<Vec3f> positions, normals, tangents;
  std::vector<Vec2f> uv;
  std::vector<Triangles> parts{3};

  Sheet() {
    Rng rng(5);
    for (uint32_t j = 0; j <= kSide; ++j)
      for (uint32_t i = 0; i <= kSide; ++i) {
        positions.push_back({0.1f * float(i) - 3, 0.1f * float(j) + 7, 0.05f * rng.uniform()});
        normals.push_back(normalized(Vec3f{rng.normal(), rng.normal(), 1}));
        tangents.push_back(normalized(Vec3f{1, 0, -normals.back().x / normals.back().z}));
        uv.push_back({float(i) / kSide, float(j) / kSide});
      }
    positions.push_back({1000, 0, 0}), normals.push_back({0, 0, 1}), tangents.push_back({1, 0, 0}), uv.push_back({});
    Triangles all;
    for (uint32_t j = 0; j < kSide; ++j)
      for (uint32_t i = 0; i < kSide; ++i) {
        const uint32_t v = j * (kSide + 1) + i;
        all.push_back({v, v + 1, v + kSide + 1});
        all.push_back({v + 1, v + kSide + 2, v + kSide + 1});
      }
    for (size_t k = all.size(); k > 1; --k) std::swap(all[k - 1], all[rng.below(uint32_t(k))]);
    for (size_t k = 0; k < all.size(); ++k) parts[k % 3 == 2 ? 1 : 0].push_back(all[k]);
  }
  CompactMesh compacted() const {
    return compact({.positions = positions, .normals = normals, .tangents = tangents, .uv = uv, .parts = parts});
  }
};

TEST(CompactMesh, HasTheSameTrianglesRounded) {
  const Sheet sheet;
  const CompactMesh m = sheet.compacted();
  ASSERT_EQ(m.vertex_count(), sheet.positions.size() - 1) << "the vertex of no triangle is gone, and with it its place";
  EXPECT_NEAR(m.side, 4, 1e-5);
  ASSERT_EQ(m.parts.size(), 3u);
  EXPECT_TRUE(m.parts[2].empty());
  // Which vertex was which: by the texture coordinates, which are all different.
  std::map<std::pair<long, long>, uint32_t> by_uv;
  for (uint32_t v = 0; v + 1 < sheet.uv.size(); ++v)
    by_uv[{std::lround(kSide * sheet.uv[v].x), std::lround(kSide * sheet.uv[v].y)}] = v;
  std::vector<uint32_t> before;
  for (size_t v = 0; v < m.vertex_count(); ++v) {
    const float x = float(m.uv[2 * v]) / 65535, y = float(m.uv[2 * v + 1]) / 65535;
    const uint32_t b = before.emplace_back(by_uv.at({std::lround(kSide * x), std::lround(kSide * y)}));
    EXPECT_NEAR(x, sheet.uv[b].x, 8e-6);
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(m.origin[c] + m.side * float(m.positions[3 * v + c]) / 65535, sheet.positions[b][c], 8e-6f * m.side);
      EXPECT_NEAR(float(m.normals[3 * v + c]) / 32767, sheet.normals[b][c], 2e-5);
      EXPECT_NEAR(float(m.tangents[4 * v + c]) / 127, sheet.tangents[b][c], 0.5 / 127 + 1e-6);
    }
    EXPECT_EQ(m.tangents[4 * v + 3], 127);
  }
  for (size_t part = 0; part < 2; ++part) {
    // Corners in their order, from the smallest on.
    const auto turned = [](std::array<uint32_t, 3> t) {
      std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
      return t;
    };
    std::multiset<std::array<uint32_t, 3>> was, is;
    for (const auto& t : sheet.parts[part]) was.insert(turned(t));
    for (const auto& t : m.parts[part]) is.insert(turned({before[t[0]], before[t[1]], before[t[2]]}));
    EXPECT_EQ(is, was);
  }
}

TEST(CompactMesh, IsDrawnWithFewVerticesComputedTwice) {
  const Sheet sheet;
  const auto misses = [](const Triangles& t, size_t vertices) {
    return meshopt_analyzeVertexCache(t.data()->data(), 3 * t.size(), vertices, 16, 0, 0).acmr;
  };
  const CompactMesh m = sheet.compacted();
  EXPECT_GT(misses(sheet.parts[0], sheet.positions.size()), 2.5);
  EXPECT_LT(misses(m.parts[0], m.vertex_count()), 1.1);  // seen: 0.99; a third of the triangles are of the other part
  EXPECT_EQ(m.parts[0][0], (std::array<uint32_t, 3>{0, 1, 2})) << "vertices in the order of their use";
}

TEST(CompactMesh, IsTheSameTwiceAndTakesAMeshOfNothing) {
  const CompactMesh a = Sheet().compacted(), b = Sheet().compacted();
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.parts, b.parts);
  const std::vector<Triangles> none(3);
  const CompactMesh empty = compact({.positions = {}, .normals = {}, .tangents = {}, .uv = {}, .parts = none});
  EXPECT_EQ(empty.vertex_count(), 0u);
  EXPECT_EQ(empty.side, 1);
}

}  // namespace
}  // namespace vitrine
