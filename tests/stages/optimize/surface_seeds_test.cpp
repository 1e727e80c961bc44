// Where surfels of glass are put.
#include "stages/optimize/initialise.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/learn/trainer/frozen_surfels.h"
#include "core/scene/surfels/activation.h"
#include "stages/optimize/layer_init.h"
#include "tests/core/observe/stereo/silhouettes_of_rays.h"

namespace vitrine {
namespace {

// Photos with masks, and nothing that the diffuse layer shows in front of them.
struct Marked {
  Capture capture;
  Targets targets;
  std::vector<std::vector<float>> depths;
  Marked(const std::vector<Silhouette>& masks, MaskClass of) {
    for (const Silhouette& m : masks) {
      capture.train.push_back(uint32_t(capture.photos.size()));
      capture.photos.emplace_back().levels[0].view = m.view;
      auto& inside = targets.photos.emplace_back()[0].masks[size_t(of)];
      for (float value : m.value.data()) inside.push_back(value > 0 ? 255 : 0);
      depths.emplace_back(inside.size(), 0.f);
    }
  }
};

TEST(SurfaceSeeds, LieOnTheFacesOfABox) {
  const Box box{rotation_matrix(normalized(Quatd{0.98, 0, 0, 0.17})), {-0.2, -0.14, -0.28}, {0.2, 0.14, 0.28}};
  const SurfaceSeeds seeds = surface_seeds({.entries = {{box, ShapeRole::Sheet, 0.02, -1, {}}}});
  ASSERT_GT(seeds.points.size(), 500u);
  for (const SurfaceSeed& p : seeds.points) {
    EXPECT_TRUE(p.known);
    EXPECT_NEAR(box.distance(cast<double>(p.position)), 0, 1e-6);
  }
}

// Photos look through the sides to a wall, and down to a floor that the case stands on; something stands in its middle.
TEST(ClearPanes, StandsOnAFloorThatIsNoPane) {
  const Box box{Mat3d::identity(), {-0.2, -0.14, -0.28}, {0.2, 0.14, 0.28}};
  const auto masks = silhouettes_of_rays(24, 2 * std::numbers::pi,
                                         [&](const Vec3d& eye, const Vec3d& d) { return box.crossing(eye, d).has_value(); });
  Marked photos(masks, MaskClass::Transparent);
  for (size_t photo = 0; photo < masks.size(); ++photo) {
    const View& view = masks[photo].view;
    const Vec3d eye = view.centre_in_world();
    const int width = view.intrinsics.width;
    for (size_t i = 0; i < photos.depths[photo].size(); ++i) {
      const Vec3d per_z = view.ray(int(i) % width + 0.5, int(i) / width + 0.5);
      const auto c = box.crossing(eye, per_z);
      const double to_floor = (-0.29 - eye.z) / per_z.z;
      double z = c && c->left == Box::Face{2, false} ? to_floor : 4;
      if (c && i % 5 == 0) z = 0.5 * (c->in + c->out);
      photos.depths[photo][i] = i % 7 == 0 ? 0.f : float(z);
    }
  }
  const ShapeSet::Entry sheet{box, ShapeRole::Sheet, 0.02, -1, {}};
  const ShapeSet::Entry found = with_clear_panes(sheet, photos.capture, photos.targets, photos.depths, 0);
  for (size_t f = 0; f < Box::kFaces; ++f) EXPECT_EQ(found.is_clear(f), f != (Box::Face{2, false}.index())) << f;
  ShapeSet::Entry given = sheet;  // by a person
  given.clear = {1, 1, 1, 1, 1, 1};
  EXPECT_EQ(with_clear_panes(given, photos.capture, photos.targets, photos.depths, 0).clear, given.clear);
}

TEST(SurfaceSeeds, OfAVisualHullAreNotKnown) {
  const Box box{Mat3d::identity(), {-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2}};
  const SurfaceSeeds seeds =
      surface_seeds({.entries = {{box, ShapeRole::Mirror, 0.02, -1, {}},
                                 {TriangleShape(box.tessellated(1)), ShapeRole::Mirror, 0.02, -1, {}, false}}});
  const auto known = std::ranges::count(seeds.points, true, &SurfaceSeed::known);
  EXPECT_NEAR(double(known) / double(seeds.points.size()), 0.5, 0.01);
  EXPECT_TRUE(surface_seeds({}).points.empty());
}

// Surfels stand closer together on an appendage than on what it stands out of.
TEST(SurfaceSeeds, AppendagesAreCrowded) {
  const Box body{Mat3d::identity(), {-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2}};
  const Box handle{Mat3d::identity(), {0.1, -0.05, -0.05}, {0.4, 0.05, 0.05}};
  const ShapeSet shapes{.entries = {{body, ShapeRole::Mirror, 0.02, -1, {}},
                                    {TriangleShape(handle.tessellated(1)), ShapeRole::Mirror, 0.01, 0, {}}}};
  size_t on_body = 0, on_handle = 0;
  for (const SurfaceSeed& p : surface_seeds(shapes).points) {
    EXPECT_TRUE(p.known);
    (p.apart < 1 ? on_handle : on_body) += 1;
    const bool inside = body.distance(cast<double>(p.position)) < -1e-6;
    EXPECT_FALSE(p.apart < 1 && inside) << "the root of the handle";
  }
  const double per_body = double(on_body) / (6 * 0.4 * 0.4), per_handle = double(on_handle) / (4 * 0.2 * 0.1 + 0.1 * 0.1);
  EXPECT_NEAR(per_handle / per_body, 6, 0.5);
}

TEST(SurfaceSeeds, WhatReflectsKeepsItsShapeAsFarAsItDoes) {
  SplatLayer layer(LayerKind::Diffuse, 0, 3);
  const float weights[] = {0.02f, 0.5f, 0.9f};
  for (size_t i = 0; i < 3; ++i) *layer.at(Attribute::SpecularWeight, i) = logit(weights[i]);
  std::vector<float> damping;
  const KnownSurface known({{0, 0, 0}, {0.05f, 0, 0}}, 0.1f);
  freeze_mirrors(layer, known, 0.02f, damping);
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(damping[i], 1 - 0.98f * weights[i], 1e-5);
  damping = {0.5f, 0.5f, 0.5f};  // of glass
  freeze_mirrors(layer, known, 0.02f, damping);
  EXPECT_NEAR(damping[2], 0.5f * (1 - 0.98f * 0.9f), 1e-5);
  damping.clear();
  layer.at(Attribute::Mean, 1)[0] = 0.2f;  // another thing that reflects, whose shape nobody knows
  layer.at(Attribute::Mean, 2)[0] = std::numeric_limits<float>::quiet_NaN();
  freeze_mirrors(layer, known, 0.02f, damping);
  EXPECT_NEAR(damping[0], 1 - 0.98f * weights[0], 1e-5);
  EXPECT_EQ(damping[1], 1) << "one known shape holds nothing but its own surfels";
  EXPECT_EQ(damping[2], 1);
}

TEST(Glass, ReflectsAlikeEverywhere) {
  SplatLayer layer(LayerKind::Diffuse, 0, 3);
  const float tau[] = {0.9f, 0.1f, 0.8f}, k_s[] = {1, 5, 2};
  for (size_t i = 0; i < 3; ++i) {
    *layer.at(Attribute::Transmission, i) = logit(tau[i]);
    *layer.at(Attribute::SpecularWeight, i) = k_s[i];
    for (size_t c = 0; c < 3; ++c) layer.at(Attribute::F0, i)[c] = k_s[i] + float(c);
  }
  share_glass(layer);
  for (const size_t glass : {0, 2}) {
    EXPECT_EQ(*layer.at(Attribute::SpecularWeight, glass), 1.5f);
    for (size_t c = 0; c < 3; ++c) EXPECT_EQ(layer.at(Attribute::F0, glass)[c], 1.5f + float(c));
  }
  EXPECT_EQ(*layer.at(Attribute::SpecularWeight, 1), 5);
  EXPECT_EQ(layer.at(Attribute::F0, 1)[2], 7);
  SplatLayer none(LayerKind::Diffuse, 0, 1);
  *none.at(Attribute::Transmission, 0) = -3;
  *none.at(Attribute::F0, 0) = 0.25f;
  share_glass(none);
  EXPECT_EQ(*none.at(Attribute::F0, 0), 0.25f);
}

}  // namespace
}  // namespace vitrine
