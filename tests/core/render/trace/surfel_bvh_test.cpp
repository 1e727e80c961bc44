// The tree of the surfels for rays on a GPU: whole, of bounded depth, the same for any number of threads.
#include "core/render/trace/blocks/surfel_bvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/foundation/base/parallel.h"
#include "tests/core/render/trace/ray_scenes.h"

namespace vitrine {
namespace {

using blocks::build_surfel_bvh, blocks::BvhNode, blocks::SurfelBvh;

// Every visible surfel is in one leaf, in the boxes of all nodes above it; the depth fits the stack.
void expect_whole(const SurfelBvh& bvh) {
  std::vector<int> seen(bvh.surfel_at.size());
  struct Visit {
    uint32_t node, depth;
  };
  std::vector<Visit> open;
  if (!bvh.nodes.empty()) open.push_back({0, 1});
  size_t nodes = 0;
  while (!open.empty()) {
    const Visit v = open.back();
    open.pop_back();
    ++nodes;
    ASSERT_LE(v.depth, BvhNode::kLevels);
    const BvhNode& node = bvh.nodes[v.node];
    for (size_t c = 0; c < BvhNode::kChildren; ++c) {
      if (node.planes[0][0].v[c] > node.planes[1][0].v[c]) continue;
      const uint32_t child = node.children[c];
      if (!BvhNode::is_leaf(child)) {
        open.push_back({child, v.depth + 1});
        for (size_t axis = 0; axis < 3; ++axis)
          for (size_t k = 0; k < BvhNode::kChildren; ++k) {
            if (bvh.nodes[child].planes[0][0].v[k] > bvh.nodes[child].planes[1][0].v[k]) continue;
            EXPECT_LE(node.planes[0][axis].v[c], bvh.nodes[child].planes[0][axis].v[k]);
            EXPECT_GE(node.planes[1][axis].v[c], bvh.nodes[child].planes[1][axis].v[k]);
          }
        continue;
      }
      for (uint32_t p = 0; p < BvhNode::leaf_size(child); ++p) {
        const uint32_t place = BvhNode::leaf_first(child) + p;
        ASSERT_LT(place, seen.size());
        ++seen[place];
        for (size_t axis = 0; axis < 3; ++axis) {
          EXPECT_LT(node.planes[0][axis].v[c], bvh.shapes[place].mean[axis].v);
          EXPECT_GT(node.planes[1][axis].v[c], bvh.shapes[place].mean[axis].v);
        }
      }
    }
  }
  EXPECT_EQ(nodes, bvh.nodes.size());
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), std::ptrdiff_t(seen.size()));
  for (size_t place = 0; place < seen.size(); ++place) EXPECT_EQ(bvh.place_of[bvh.surfel_at[place]], place);
}

TEST(SurfelBvh, HoldsEveryVisibleSurfelOnce) {
  for (const size_t count : {1, 2, 4, 5, 17, 300}) {
    SCOPED_TRACE(count);
    const SurfelBvh bvh = build_surfel_bvh(ray_cloud("cloud", count, 1, 0.2, 0.9, 41).layer);
    EXPECT_EQ(bvh.shapes.size(), count);
    expect_whole(bvh);
  }
  RayScene same;  // one place for all; sizes that double from surfel to surfel would make a chain of splits
  for (uint64_t i = 0; i < 3000; ++i) add_surfel(same, {.mean = {0, 0, 1}, .su = std::exp2(0.01 * double(i)), .sv = 0.1}, i);
  expect_whole(build_surfel_bvh(same.layer));
}

TEST(SurfelBvh, LeavesOutWhatNoRayCanHit) {
  RayScene s = ray_cloud("cloud", 20, 1, 0.2, 0.9, 42);
  *s.layer.at(Attribute::Opacity, 3) = -9;                                          // below 1/255
  s.layer.at(Attribute::Mean, 5)[2] = std::numeric_limits<float>::infinity();       // nowhere
  s.layer.at(Attribute::LogScale, 7)[0] = std::numeric_limits<float>::quiet_NaN();  // of no size
  const SurfelBvh bvh = build_surfel_bvh(s.layer);
  expect_whole(bvh);
  EXPECT_EQ(bvh.shapes.size(), 17u);
  for (const size_t i : {3, 5, 7}) EXPECT_EQ(bvh.place_of[i], SurfelBvh::kInvisible);
  EXPECT_TRUE(build_surfel_bvh(SplatLayer(LayerKind::Reflection, 3, 0)).nodes.empty());
}

TEST(SurfelBvh, IsTheSameForAnyNumberOfThreads) {
  const SplatLayer layer = ray_cloud("cloud", 5000, 1, 0.05, 0.9, 43).layer;
  std::vector<SurfelBvh> built;
  for (const int threads : {1, 2, 8}) {
    set_thread_limit(threads);
    built.push_back(build_surfel_bvh(layer));
  }
  set_thread_limit(0);
  for (size_t b = 1; b < built.size(); ++b) {
    EXPECT_EQ(built[b].surfel_at, built[0].surfel_at);
    ASSERT_EQ(built[b].nodes.size(), built[0].nodes.size());
    for (size_t i = 0; i < built[0].nodes.size(); ++i) {
      const BvhNode &x = built[b].nodes[i], &y = built[0].nodes[i];
      ASSERT_TRUE(std::equal(std::begin(x.children), std::end(x.children), y.children));
      ASSERT_EQ(std::memcmp(x.planes, y.planes, sizeof x.planes), 0);
    }
  }
}

}  // namespace
}  // namespace vitrine
