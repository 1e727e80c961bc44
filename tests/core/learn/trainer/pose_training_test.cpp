// Gradient of a camera's pose from the gradients of the surfels, against differences of pictures.
#include "core/learn/trainer/pose_training.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/render/raster/renderer.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

constexpr int kDegree = 2;

SplatLayer some_surfels() {
  SplatLayer layer(LayerKind::Diffuse, kDegree, 8);
  Rng rng(5);
  for (size_t i = 0; i < layer.size(); ++i) {
    for (size_t c = 0; c < 2; ++c) layer.at(Attribute::Mean, i)[c] = 0.5f * rng.normal();
    layer.at(Attribute::Mean, i)[2] = 0.5f * float(i);  // crossing surfels would change their order
    layer.at(Attribute::Rotation, i)[0] = 1;
    for (size_t c = 1; c < 4; ++c) layer.at(Attribute::Rotation, i)[c] = 0.2f * rng.normal();
    for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = std::log(0.2f + 0.1f * rng.uniform());
    *layer.at(Attribute::Opacity, i) = rng.normal();
    for (size_t c = 0; c < 3; ++c) layer.at(Attribute::ShDc, i)[c] = 2 + 0.3f * rng.normal();
    for (size_t c = 0; c < layer.width(Attribute::ShRest); ++c) layer.at(Attribute::ShRest, i)[c] = 0.4f * rng.normal();
  }
  return layer;
}

SplatLayer moved(SplatLayer layer, const Rigid& motion) {
  for (size_t i = 0; i < layer.size(); ++i) {
    float *mean = layer.at(Attribute::Mean, i), *rotation = layer.at(Attribute::Rotation, i);
    const Vec3d to = motion * Vec3d{mean[0], mean[1], mean[2]};
    const Quatd q = normalized(Quatd{rotation[0], rotation[1], rotation[2], rotation[3]});
    const Quatd turned = quaternion(motion.rotation * rotation_matrix(q));
    for (size_t c = 0; c < 3; ++c) mean[c] = float(to[c]);
    const double values[] = {turned.w, turned.x, turned.y, turned.z};
    for (size_t c = 0; c < 4; ++c) rotation[c] = float(values[c]);
  }
  return layer;
}

TEST(PoseGradient, AgreesWithDifferencesOfPictures) {
  const SplatLayer layer = some_surfels();
  const Rigid pose = moved_pose({.rotation = Mat3d::identity(), .translation = {0, 0, 3}}, {0.1, -0.1, 0.3}, {0.1, 0.05, 0});
  RasterDesc desc{.intrinsics = {24, 20, 26, 25, 12.3, 9.8}, .cam_from_world = pose, .sh_degree = kDegree};
  const auto renderer = make_renderer(Backend::Reference);
  RasterImages images, weights;
  weights.resize(desc);
  Rng rng(7);
  for (float& w : weights.plane(Aov::Color)) w = rng.normal();
  for (float& w : weights.plane(Aov::ZDepth)) w = rng.normal();
  for (Aov unused : {Aov::Normal, Aov::Alpha, Aov::MedianZ}) weights.planes[static_cast<size_t>(unused)].clear();
  const auto sum_of = [&](const RasterImages& shown) {
    double sum = 0;
    for (Aov a : {Aov::Color, Aov::ZDepth})
      for (size_t i = 0; i < shown.plane(a).size(); ++i) sum += double(shown.plane(a)[i]) * double(weights.plane(a)[i]);
    return sum;
  };
  const auto loss = [&](const Rigid& cam_from_world) {
    desc.cam_from_world = cam_from_world;
    renderer->forward(layer, desc, images);
    return sum_of(images);
  };
  std::vector<double> twist(6, 0.0);
  const std::vector<double> expected = finite_differences(
      twist,
      [&] {
        return loss(moved_pose(pose, {twist[0], twist[1], twist[2]}, {twist[3], twist[4], twist[5]}));
      },
      1e-3);
  loss(pose);
  SplatLayer grad = layer.zeros_like();
  grad.fill(0.f);
  renderer->backward({.gradients = &weights}, grad, nullptr);
  const PoseGradient g = pose_gradient(layer, grad, pose, kDegree);
  const std::vector<double> found{g.turn.x, g.turn.y, g.turn.z, g.shift.x, g.shift.y, g.shift.z};
  expect_grad_close(found, expected, {.relative_l2 = 1e-2, .bias = 1e-2});

  // A scene that moves before a fixed camera differs from a camera that moves in its colours alone: they turn with the camera.
  const std::vector<double> scene_moves = finite_differences(
      twist,
      [&] {
        const Rigid motion = inverse(pose) * moved_pose(pose, {twist[0], twist[1], twist[2]}, {twist[3], twist[4], twist[5]});
        desc.cam_from_world = pose;
        renderer->forward(moved(layer, motion), desc, images);
        return sum_of(images);
      },
      1e-3);
  const PoseGradient fixed_colours = pose_gradient(layer, grad, pose, 0);
  std::vector<double> of_colours, expected_of_colours;
  for (size_t i = 0; i < 3; ++i) {
    of_colours.push_back(g.turn[i] - fixed_colours.turn[i]);
    expected_of_colours.push_back(expected[i] - scene_moves[i]);
  }
  expect_grad_close(of_colours, expected_of_colours, {.relative_l2 = 2e-2, .bias = 2e-2});
}

View camera_at(const Rigid& pose) { return {.name = "photo", .cam_from_world = pose}; }

TEST(PoseTraining, DescendsToTheTruePoses) {
  const Rigid truth =
      moved_pose({.rotation = Mat3d::identity(), .translation = {0, 0, 3}}, {0.01, -0.02, 0.015}, {0.02, 0, 0.01});
  PoseTraining training({camera_at({.rotation = Mat3d::identity(), .translation = {0, 0, 3}})});
  for (int step = 0; step < 400; ++step) {
    const Rigid off = training.pose(0) * inverse(truth);
    const Quatd q = quaternion(off.rotation);
    const double rate = 1e-3 * std::pow(0.01, step / 400.0);
    training.descend(0, {.turn = {q.x, q.y, q.z}, .shift = off.translation}, {.turn = rate, .shift = rate});
  }
  const Rigid off = training.pose(0) * inverse(truth);
  EXPECT_LT(length(off.translation), 1e-3);
  EXPECT_NEAR(off.rotation(0, 1), 0, 1e-3);
  const uint32_t photo = 0;
  EXPECT_NEAR(training.moved({&photo, 1}).turn_rad, std::sqrt(0.01 * 0.01 + 0.02 * 0.02 + 0.015 * 0.015), 2e-3);
}

TEST(PoseTraining, HoldsTheMeanPoseAndKeepsWhatIsBetweenThem) {
  std::vector<View> given;
  std::vector<uint32_t> photos;
  for (uint32_t i = 0; i < 6; ++i) {
    given.push_back(
        camera_at(moved_pose({.rotation = Mat3d::identity(), .translation = {0, 0, 2}}, {0.3 * i, 0.1, -0.2 * i}, {})));
    photos.push_back(i);
  }
  PoseTraining training(given);
  const Rigid drift{rotation_matrix(normalized(Quatd{1, 0.002, -0.001, 0.003})), {0.01, 0.02, -0.005}};
  for (uint32_t i = 0; i < 6; ++i) training.set(i, given[i].cam_from_world * drift);
  EXPECT_GT(training.moved(photos).turn_rad, 5e-3);
  training.hold_mean(photos);
  EXPECT_LT(training.moved(photos).turn_rad, 1e-4);
  EXPECT_LT(training.moved(photos).shift, 1e-3);
  training.set(0, moved_pose(given[0].cam_from_world, {0.012, 0, 0}, {}));
  const Mat3d between = training.pose(0).rotation * transposed(training.pose(1).rotation);
  training.hold_mean(photos);
  const Mat3d kept = training.pose(0).rotation * transposed(training.pose(1).rotation);
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(kept(i, i), between(i, i), 1e-12);
  EXPECT_NEAR(training.moved({photos.data() + 1, 1}).turn_rad, 0.002, 1e-4);
}

}  // namespace
}  // namespace vitrine
