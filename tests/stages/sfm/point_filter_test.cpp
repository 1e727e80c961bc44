#include "stages/sfm/point_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/intake/poses/synthetic_model.h"

namespace vitrine {
namespace {

TEST(PointFilter, TakesOutEachKindOfBadPointAndKeepsReferencesSound) {
  std::vector<Vec3d> points = cloud(600, 2);
  points.push_back({0, 0, 1.0});  // lonely, still seen
  ColmapModel model = synthetic_model(ring(12, 3, 1, {0, 0, 1}), points);
  const size_t n = model.points.size();
  ASSERT_EQ(model.points.back().position, (Vec3d{0, 0, 1.0}));
  model.points[3].error_px = 9;
  model.points[7].error_px = 2.5;
  // A point 1000 units away is seen under no angle.
  model.points[11].position = {0, 0, -4000};
  FilterCounts counts;
  ColmapModel out = filtered(model, counts);
  check_colmap_model(out, "test");
  EXPECT_EQ(counts.before, n);
  EXPECT_EQ(counts.large_error, 2u);
  EXPECT_EQ(counts.small_angle + counts.behind, 1u);
  EXPECT_GE(counts.lonely, 1u);
  EXPECT_LT(counts.lonely, n / 20);
  EXPECT_EQ(out.points.size(), counts.after);
  for (const ColmapPoint3D& p : out.points) {
    EXPECT_LT(p.position.z, 0.6);
    EXPECT_GT(p.position.z, -100);
    for (const ColmapTrackElement& t : p.track) {
      const ColmapImage& image = *out.find_image(t.image_id);
      ASSERT_LT(t.point2d_index, image.points.size());
      EXPECT_EQ(image.points[t.point2d_index].point3d_id, p.id);
      const Vec3d q = image.cam_from_world() * p.position;
      EXPECT_NEAR(600 * q.x / q.z + 320, image.points[t.point2d_index].x, 1e-6);
    }
  }
}

TEST(PointFilter, TakesOutPointsThatOnePhotoSees) {
  ColmapModel model = synthetic_model(ring(12, 3, 1, {0, 0, 1}), cloud(200, 2));
  for (size_t i : {5, 17}) model.points[i].track.resize(1);
  FilterCounts counts;
  const ColmapModel out = filtered(model, counts);
  EXPECT_EQ(counts.few_views, 2u);
  EXPECT_GT(out.points.size(), 100u);
  for (const ColmapPoint3D& p : out.points) EXPECT_GE(p.track.size(), 2u);
}

TEST(NeighbourDistances, AgreeWithTheExhaustiveSearch) {
  std::vector<Vec3d> points = cloud(300, 9);
  points.insert(points.end(), points.begin(), points.begin() + 20);  // equal points
  const std::vector<double> fast = neighbour_distances(points, 8);
  for (size_t i = 0; i < points.size(); ++i) {
    std::vector<double> all;
    for (size_t j = 0; j < points.size(); ++j)
      if (j != i) all.push_back(length(points[i] - points[j]));
    std::sort(all.begin(), all.end());
    double mean = 0;
    for (size_t k = 0; k < 8; ++k) mean += all[k] / 8;
    EXPECT_NEAR(fast[i], mean, 1e-12);
  }
}

TEST(TriangulationAngle, IsTheLargestOfAllPairs) {
  ColmapPoint3D p;
  p.position = {0, 0, 0};
  EXPECT_NEAR(triangulation_angle(p, {{1, 0, 0}, {1, 0.1, 0}, {0, 5, 0}}), std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(triangulation_angle(p, {{1, 0, 0}}), 0);
}

}  // namespace
}  // namespace vitrine
