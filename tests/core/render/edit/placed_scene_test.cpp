// A placed scene is the same scene: each value under the identity, the same picture from the camera that moved with it, the same
// hits of rays that moved with its shapes.
#include "core/render/edit/placed_scene.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/spherical_harmonics.h"
#include "core/render/model/thick_glass.h"
#include "core/render/raster/renderer.h"
#include "tests/support/spheres.h"
#include "tests/support/turned_ball.h"

namespace vitrine {
namespace {

const Similarity kPlace{2.5, rotation_matrix(normalized(Quatd{0.8, 0.3, -0.4, 0.2})), {0.4, -1.2, 3}};

float noise(uint64_t i) { return float(double(mix64(7, i) >> 11) / double(1ull << 53) - 0.5); }

SplatLayer coloured_ball() {
  const SplatLayer plain = test::sphere_layer(0.4, 400);
  SplatLayer layer(LayerKind::Diffuse, 3, plain.size());
  for (size_t i = 0; i < layer.size(); ++i) {
    for (const AttributeRow& r : kAttributes) std::copy_n(plain.at(r.id, i), plain.width(r.id), layer.at(r.id, i));
    for (size_t k = 0; k < layer.width(Attribute::ShRest); ++k) layer.at(Attribute::ShRest, i)[k] = 0.2f * noise(45 * i + k);
  }
  return layer;
}

std::vector<float> picture(const SplatLayer& layer, const Rigid& cam_from_world, float near) {
  RasterDesc desc;
  desc.intrinsics = {64, 48, 70, 70, 32, 24};
  desc.cam_from_world = cam_from_world, desc.sh_degree = layer.sh_degree(), desc.near_z = near;
  RasterImages images;
  make_renderer(Backend::Reference)->forward(layer, desc, images);
  const auto color = images.plane(Aov::Color);
  return {color.begin(), color.end()};
}

TEST(PlacedScene, IdentityKeepsEveryByte) {
  SplatLayer layer = coloured_ball();
  layer.at(Attribute::Rotation, 0)[0] *= 3;  // not a unit quaternion
  EXPECT_EQ(placed(layer, {}), layer);
}

TEST(PlacedScene, HarmonicsFollowTheRotation) {
  const ShRotation rotation(kPlace.rotation);
  for (int degree = 1; degree <= 3; ++degree) {
    const size_t n = sh_coefficient_count(degree);
    std::vector<float> before(3 * (n - 1));
    for (size_t i = 0; i < before.size(); ++i) before[i] = noise(i);
    std::vector<float> after = before;
    rotation.apply(degree, after.data());
    for (uint64_t i = 0; i < 20; ++i) {
      const Vec3d d = normalized(Vec3d{noise(3 * i), noise(3 * i + 1), noise(3 * i + 2)});
      double here[16], there[16];
      sh_basis(degree, d, here);
      sh_basis(degree, kPlace.rotation * d, there);
      for (size_t c = 0; c < 3; ++c) {
        double a = 0, b = 0;
        for (size_t k = 1; k < n; ++k)
          a += here[k] * double(before[3 * (k - 1) + c]), b += there[k] * double(after[3 * (k - 1) + c]);
        EXPECT_NEAR(a, b, 2e-6) << "degree " << degree;
      }
    }
  }
}

TEST(PlacedScene, TheCameraThatMovesWithItSeesTheSamePicture) {
  const SplatLayer layer = coloured_ball();
  const Rigid camera = test::looking_at({1.1, 0.3, 0.4}, {0, 0, 0});
  const std::vector<float> before = picture(layer, camera, 0.01f),
                           after = picture(placed(layer, kPlace), transformed_world(camera, kPlace), 0.025f);
  double largest = 0, contrast = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    largest = std::max(largest, std::abs(double(before[i]) - double(after[i])));
    contrast = std::max(contrast, std::abs(double(before[i]) - double(before[0])));
  }
  EXPECT_LT(largest, 1e-3);
  EXPECT_GT(contrast, 0.2) << "the picture shows something";
}

TEST(PlacedScene, RaysThatMoveWithAShapeHitItAtTheSamePlace) {
  TriMesh ball = test::sphere_mesh(0.3, {0.1, 0, 0});
  const Shape shapes[] = {Plane{{0.1, 0, 0}, Mat3d{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, {0.4, 0.3}},
                          Box{Mat3d::identity(), {-0.2, -0.3, -0.1}, {0.3, 0.2, 0.4}}, test::turned_ball({0.1, 0, 0}, 0.3),
                          TriangleShape(ball)};
  for (const Shape& shape : shapes) {
    const Shape there = placed(shape, kPlace);
    const bool upright = std::holds_alternative<TriangleShape>(shape);  // its size is that of an upright box
    EXPECT_NEAR(size_of(there), kPlace.scale * size_of(shape), upright ? 0.5 : 1e-5);
    const Vec3d eye{2, 0.1, 0.2}, way = Vec3d{0.05, 0.02, 0.05} - eye;
    const auto hit = intersect(shape, {eye, way});
    const auto moved = intersect(there, {kPlace * eye, kPlace.scale * (kPlace.rotation * way)});
    ASSERT_TRUE(hit && moved) << shape.index();
    EXPECT_NEAR(hit->t, moved->t, 1e-5) << shape.index();
    EXPECT_LT(length(kPlace.rotation * hit->normal - moved->normal), 1e-4) << shape.index();
  }
}

TEST(PlacedScene, MeshesSolidGlassAndTolerancesTakeTheScale) {
  EditScene scene;
  scene.mesh = test::sphere_mesh(0.2);
  ImageOptions& image = scene.trained.image;
  ShapeSet set;
  set.entries.emplace_back(test::turned_ball({}, 0.2)).tolerance = 0.01;
  image.shape.set = std::make_shared<const ShapeSet>(set);
  image.transmission.thick = std::make_shared<const ThickGlass>(test::sphere_mesh(0.2), 1.5f, 0.02f);
  scene.materials.emplace().scatter = {{0.1f, 0.2f, 0}};
  scene.materials->marks = {{0, 0.7f, 0}};
  const EditScene there = placed(scene, kPlace);
  EXPECT_FLOAT_EQ(there.materials->scatter[0].y, 0.5f);
  EXPECT_LT(length(cast<double>(there.materials->marks[0]) - 0.7 * kPlace.rotation.c1), 1e-6);
  EXPECT_LT(length(cast<double>(there.mesh.positions[7]) - kPlace * cast<double>(scene.mesh.positions[7])), 1e-6);
  EXPECT_NEAR(there.trained.image.shape.set->entries[0].tolerance, 0.025, 1e-9);
  EXPECT_NEAR(there.trained.image.transmission.thick->tolerance(), 0.05, 1e-6);
  EXPECT_EQ(there.trained.image.transmission.thick->ior(), 1.5f);
}

}  // namespace
}  // namespace vitrine
