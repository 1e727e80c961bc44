#include "core/foundation/math/kd_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "core/foundation/base/rng.h"

namespace vitrine {
namespace {

template <class T>
void expect_the_nearest_of_all() {
  Rng rng(3);
  std::vector<Vec3<T>> points(500);
  for (Vec3<T>& p : points) p = {T(rng.uniform()), T(rng.uniform()), T(0.2f * rng.uniform())};
  points.insert(points.end(), points.begin(), points.begin() + 40);  // equal points: the smaller index comes first
  points.push_back({std::numeric_limits<T>::quiet_NaN(), 0, 0});
  const KdTree<T> tree(points);
  const auto all_within = [&](const Vec3<T>& q, T squared_radius) {
    std::vector<std::pair<T, uint32_t>> all;
    for (size_t i = 0; i < points.size(); ++i)
      if (const T d = squared_length(points[i] - q); d <= squared_radius) all.emplace_back(d, uint32_t(i));
    std::ranges::sort(all);
    return all;
  };
  std::vector<typename KdTree<T>::Near> near;
  for (uint32_t trial = 0; trial < 50; ++trial) {
    const Vec3<T> q{T(1.2f * rng.uniform()), T(rng.uniform()), T(0.3f * rng.uniform())};
    const auto all = all_within(q, T(0.3f) * T(0.3f));
    tree.nearest(q, 7, T(0.3f), near);
    ASSERT_EQ(near.size(), std::min<size_t>(7, all.size()));
    for (size_t k = 0; k < near.size(); ++k) EXPECT_EQ(near[k].index, all[k].second);
    EXPECT_EQ(tree.any(q, T(0.3f)), !all.empty());
    EXPECT_EQ(tree.any(q, T(0.02f)), !all.empty() && all.front().first <= T(0.02f) * T(0.02f));
    auto others = all_within(points[trial], std::numeric_limits<T>::infinity());
    std::erase_if(others, [&](const auto& o) { return o.second == trial; });
    tree.nearest_others(trial, 9, near);
    ASSERT_EQ(near.size(), 9u);
    for (size_t k = 0; k < near.size(); ++k) EXPECT_EQ(near[k].index, others[k].second);
  }
}

TEST(KdTree, AgreesWithASearchThroughAll) {
  expect_the_nearest_of_all<float>();
  expect_the_nearest_of_all<double>();
}

TEST(KdTree, HasNoPointNearWhatIsNoNumber) {
  const std::vector<Vec3f> points{{0, 0, 0}};
  const KdTreef tree(points);
  EXPECT_FALSE(tree.any({std::numeric_limits<float>::quiet_NaN(), 0, 0}, 1));
  EXPECT_FALSE(tree.any({std::numeric_limits<float>::infinity(), 0, 0}, 1));
  EXPECT_TRUE(tree.any({0, 1, 0}, 1));
  EXPECT_FALSE(KdTreef({}).any({0, 0, 0}, 1));
}

}  // namespace
}  // namespace vitrine
