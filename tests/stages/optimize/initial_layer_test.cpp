// The surfels that training starts from.
#include "stages/optimize/initialise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/foundation/base/rng.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"

namespace vitrine {
namespace {

struct Start {
  TemporaryFolder folder;
  Capture capture = load();
  DenseDepth dense = dense_depth(capture, 64, 2, 1);
  OptimizeConfig config;
  Start() { config.initial.frustum_points = 500; }

 private:
  Capture load() const {
    testing::write_tiny_sfm(folder.path(), 6);
    return load_capture(folder.path(), 0, 0);
  }
};

TEST(InitialLayer, FacesTheCamerasAndStaysBelowItsShare) {
  const Start start;
  const SplatLayer layer = initial_layer(start.config, start.capture, start.dense, 600);
  EXPECT_LE(layer.size(), 420u);  // its share; rays between two surfaces start nothing
  EXPECT_GT(layer.size(), 200u);
  size_t facing = 0;
  for (size_t i = 0; i < layer.size(); ++i) {
    const float* q = layer.at(Attribute::Rotation, i);
    const Vec3d normal = cast<double>(rotation_matrix(Quatf{q[0], q[1], q[2], q[3]}).c2);
    const float* mean = layer.at(Attribute::Mean, i);
    facing += std::any_of(start.capture.view_set.views.begin(), start.capture.view_set.views.end(), [&](const View& view) {
      return dot(normal, view.centre_in_world() - Vec3d{mean[0], mean[1], mean[2]}) > 0;
    });
  }
  EXPECT_EQ(facing, layer.size());
}

// Of the sky, pixels of one photo stand on a sphere around it, each as large as its share of the picture, whatever else is there.
TEST(InitialLayer, TheSkyIsASphereWithoutGaps) {
  const Start start;
  DenseDepth dense = start.dense;
  EXPECT_GE(dense.background, 100);
  for (size_t v = 0; v < dense.photos.size(); ++v) {
    EXPECT_EQ(dense.photos[v].background_z, dense.background);
    EXPECT_LE(2 * dense.photos[v].far_z, dense.background);
    DepthMap& map = dense.maps[v];
    std::ranges::fill(map.trusted, uint8_t(0));
    std::ranges::fill(map.zdepth, float(dense.background));
    std::ranges::fill(map.normal, Vec3f{0, 0, -1});
  }
  const SplatLayer layer = initial_layer(start.config, start.capture, dense, 600);
  double covered = 0;
  size_t sky = 0;
  for (size_t i = 0; i < layer.size(); ++i) {
    const float* p = layer.at(Attribute::Mean, i);
    const Vec3d mean{p[0], p[1], p[2]};
    if (length(mean) < 50) continue;  // a sparse point
    ++sky;
    EXPECT_NEAR(length(mean), dense.background, 3);
    const double scale = std::exp(double(layer.at(Attribute::LogScale, i)[0]));
    covered += scale * scale / (dense.background * dense.background);
  }
  ASSERT_GT(sky, 100u);
  EXPECT_GT(covered, 0.1) << "steradians; as small as the surfels of the room they would be dots";
}

TEST(Neighbours, SpacingMatchesAllPairs) {
  Rng rng(3);
  std::vector<Vec3f> points(700);
  for (Vec3f& p : points) p = {rng.normal(), rng.normal(), 0.01f * rng.normal()};
  points[5] = points[6] = points[7];
  const std::vector<float> spacing = neighbour_spacing(points);
  for (size_t i = 0; i < points.size(); ++i) {
    std::vector<double> squared;
    for (size_t j = 0; j < points.size(); ++j)
      if (j != i) squared.push_back(squared_length(points[j] - points[i]));
    std::partial_sort(squared.begin(), squared.begin() + 3, squared.end());
    EXPECT_NEAR(spacing[i], std::sqrt((squared[0] + squared[1] + squared[2]) / 3), 1e-5);
  }
  EXPECT_EQ(neighbour_spacing(std::vector<Vec3f>{{1, 2, 3}})[0], 0);
  EXPECT_TRUE(neighbour_spacing({}).empty());
}

}  // namespace
}  // namespace vitrine
