// Two photos look straight down at a floor, a red part and a blue one; between and around them nobody looks.
#include "stages/optimize/plane_inpainting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/learn/optim/adam.h"
#include "tests/stages/optimize/tiny_capture.h"

namespace vitrine {
namespace {

using testing::add_surfel;

constexpr Vec3f kRed{0.8f, 0.1f, 0.1f}, kBlue{0.1f, 0.1f, 0.8f};
constexpr double kHalfWidth = 0.4, kHalfHeight = 0.3, kAside = 0.8;  // what a photo sees of the floor, a unit below

struct TwoPhotos {
  Capture capture;
  SplatLayer trained{LayerKind::Diffuse, 0, 0};
  std::vector<ScenePlane> planes{{.normal = {0, 0, 1}, .offset = -1}};
  double background = 0;

  // `right_depth`: how far below the right camera the surface is that it sees; `right_opacity`: of its surfels;
  // `right_aside`: where it is.
  explicit TwoPhotos(double right_depth = 1, float right_opacity = 0.95f, double right_aside = kAside) {
    for (int side : {-1, 1}) {
      View view;
      view.name = side < 0 ? "left.png" : "right.png";
      view.intrinsics = {128, 96, 160, 160, 64, 48};
      const double x_eye = side < 0 ? -kAside : right_aside;
      const Vec3d eye{x_eye, 0, 0};
      view.cam_from_world = inverse(Rigid{Mat3d{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}, eye});
      view.gain = {1, 1, 1};
      ImageF photo(128, 96, 3);
      const Vec3f color = side < 0 ? kRed : kBlue;
      for (size_t i = 0; i < photo.data().size(); ++i) photo.data()[i] = color[i % 3];
      capture.view_set.views.push_back(view);
      capture.photos.push_back(make_photo(view, photo, 0));
      capture.train.push_back(uint32_t(capture.train.size()));
      const double depth = side < 0 ? 1 : right_depth;
      const size_t left = trained.size();
      for (double y = -0.5 * depth; y <= 0.5 * depth; y += 0.03)
        for (double x = -0.5 * depth; x <= 0.5 * depth; x += 0.03)
          add_surfel(trained, {x_eye + x, y, -depth}, {0, 0, 1}, 0.03, color);
      if (side > 0)
        for (size_t i = left; i < trained.size(); ++i) *trained.at(Attribute::Opacity, i) = logit(right_opacity);
    }
  }

  SplatLayer fill(size_t most = 100000) const { return inpainted_planes(trained, capture, planes, background, most); }
};

Vec3f position(const SplatLayer& layer, size_t i) {
  const float* p = layer.at(Attribute::Mean, i);
  return {p[0], p[1], p[2]};
}
// Of the surfels that cover a place, the one in its middle.
Vec3f color_at(const SplatLayer& layer, double x, double y) {
  Vec3f color{-1, -1, -1};
  double nearest = 1e30;
  for (size_t i = 0; i < layer.size(); ++i) {
    const Vec3f p = position(layer, i);
    const double scale = std::exp(double(layer.at(Attribute::LogScale, i)[0])), distance = std::hypot(p.x - x, p.y - y);
    if (distance > 2 * scale || distance / scale > nearest) continue;
    nearest = distance / scale;
    for (size_t c = 0; c < 3; ++c) color[c] = 0.5f + kShDc * layer.at(Attribute::ShDc, i)[c];
  }
  return color;
}

TEST(Unseen, TheFloorGoesOnBetweenThePhotosWithColoursBetweenTheirs) {
  const TwoPhotos scene;
  const SplatLayer fill = scene.fill();
  ASSERT_GT(fill.size(), 50u);
  for (size_t i = 0; i < fill.size(); ++i) {
    const Vec3f p = position(fill, i);
    EXPECT_NEAR(p.z, -1.02, 1e-3) << "a little behind the floor";
    const bool seen = std::abs(std::abs(p.x) - kAside) < kHalfWidth - 0.03 && std::abs(p.y) < kHalfHeight - 0.03;
    EXPECT_FALSE(seen) << p.x << ' ' << p.y;
    for (Attribute a : {Attribute::SpecularWeight, Attribute::Transmission})
      EXPECT_LT(sigmoid(*fill.at(a, i)), 0.01f) << "what is guessed is neither mirror nor glass";
    EXPECT_LT(std::abs(p.x), kAside + kHalfWidth + 0.55) << "too far from what was seen";
  }
  const Vec3f left = color_at(fill, -0.3, 0), middle = color_at(fill, 0, 0), right = color_at(fill, 0.3, 0);
  for (size_t c : {0, 2}) EXPECT_NEAR(middle[c], 0.45, 0.08);
  EXPECT_GT(left.x, middle.x + 0.1);
  EXPECT_LT(left.z, middle.z - 0.1);
  EXPECT_LT(right.x, middle.x - 0.1);
  EXPECT_NEAR(color_at(fill, -kAside, 0.45).x, kRed.x, 0.05) << "beside one photo alone";
}

TEST(Unseen, NothingIsPutWhereAPhotoLooksThrough) {
  const TwoPhotos scene(2);  // the right photo sees another floor, far below
  const SplatLayer fill = scene.fill();
  ASSERT_GT(fill.size(), 50u);
  for (size_t i = 0; i < fill.size(); ++i) {
    const Vec3f p = position(fill, i);
    EXPECT_FALSE(std::abs(p.x - kAside) < kHalfWidth && std::abs(p.y) < kHalfHeight) << p.x << ' ' << p.y;
  }
  EXPECT_NEAR(color_at(fill, -0.2, 0).x, kRed.x, 0.05) << "only red is seen of this floor";
}

// The floor goes on behind what the right photo sees in front of it, unless that is a veil.
TEST(Unseen, NothingIsPutBehindAVeilWhereItWouldShow) {
  constexpr double kNear = 0.1, kOnly = kNear - kHalfWidth;  // from where on the right photo looks, and the left one does not
  const auto behind = [](const SplatLayer& fill) {
    size_t count = 0;
    for (size_t i = 0; i < fill.size(); ++i) {
      const Vec3f p = position(fill, i);
      count += p.x > kOnly + 0.1 && p.x < kNear && std::abs(p.y) < 0.15;
    }
    return count;
  };
  const SplatLayer solid = TwoPhotos(0.9, 0.95f, kNear).fill(), veiled = TwoPhotos(0.9, 0.2f, kNear).fill();
  EXPECT_GT(behind(solid), 3u);
  EXPECT_EQ(behind(veiled), 0u);
  EXPECT_GT(veiled.size(), 50u) << "beside it the floor goes on";
}

// A pane before the right camera: guesses behind it would hide the blue floor, which the photo sees through it.
TEST(Unseen, GlassHidesNothing) {
  const TwoPhotos scene;
  SplatScene cased{.diffuse = scene.trained, .transmittance = SplatLayer(LayerKind::Transmittance, 0, 0)};
  for (double y = -0.4; y <= 0.4; y += 0.03)
    for (double x = -0.4; x <= 0.4; x += 0.03) {
      add_surfel(cased.diffuse, {kAside + x, y, -0.5}, {0, 0, 1}, 0.03, {});
      *cased.diffuse.at(Attribute::Transmission, cased.diffuse.size() - 1) = logit(0.98f);
    }
  const auto fill = [&](const SplatLayer& shown) { return inpainted_planes(shown, scene.capture, scene.planes, 0, 100000); };
  EXPECT_NE(fill(cased.diffuse), scene.fill()) << "or this is no test";
  EXPECT_EQ(fill(seen_through_glass(cased)), scene.fill());
  // The floor behind it in the other layer.
  std::vector<uint32_t> red, blue;
  for (uint32_t i = 0; i < scene.trained.size(); ++i) (scene.trained.at(Attribute::Mean, i)[0] < 0 ? red : blue).push_back(i);
  SplatLayer floor = scene.trained;
  keep_surfels(floor, blue);
  cased.transmittance.resize(floor.size());
  for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc})
    std::ranges::copy(floor.values(a), cased.transmittance.values(a).begin());
  cased.diffuse = scene.trained;
  keep_surfels(cased.diffuse, red);
  EXPECT_EQ(fill(seen_through_glass(cased)).size(), scene.fill().size());
}

// The blue floor stands behind the right camera's pane, in the layer behind glass: no photo sees it otherwise. A third of it is
// seen by a third camera beside the pane as well.
TEST(Unseen, AWallBehindGlassComesOutWhereNoPhotoSeesItOtherwise) {
  TwoPhotos scene;
  SplatScene cased{.diffuse = scene.trained, .transmittance = SplatLayer(LayerKind::Transmittance, 0, 0)};
  std::vector<uint32_t> red, blue;
  for (uint32_t i = 0; i < scene.trained.size(); ++i) (scene.trained.at(Attribute::Mean, i)[0] < 0 ? red : blue).push_back(i);
  cased.transmittance.resize(blue.size());
  for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc})
    for (size_t k = 0; k < blue.size(); ++k)
      std::copy_n(scene.trained.at(a, blue[k]), scene.trained.width(a), cased.transmittance.at(a, k));
  keep_surfels(cased.diffuse, red);
  const auto add_pane = [](SplatLayer& layer) {
    for (double y = -0.4; y <= 0.4; y += 0.03)
      for (double x = -0.4; x <= 0.4; x += 0.03) {
        add_surfel(layer, {kAside + x, y, -0.5}, {0, 0, 1}, 0.03, {});
        *layer.at(Attribute::Transmission, layer.size() - 1) = logit(0.98f);
      }
  };
  add_pane(cased.diffuse);
  add_surfel(cased.transmittance, {kAside, 0, -0.7}, {0, 0, 1}, 0.03, {1, 1, 1});  // in the case, on no plane
  const size_t diffuse = cased.diffuse.size(), behind = cased.transmittance.size();

  SplatScene out = cased;
  const std::vector<uint32_t> stay = bring_out_from_behind_glass(scene.capture, scene.planes, out);
  EXPECT_EQ(stay, std::vector<uint32_t>{uint32_t(behind - 1)}) << "what stands in the case";
  ASSERT_EQ(out.diffuse.size(), diffuse + behind - 1);
  EXPECT_EQ(seen_through_glass(out).size(), seen_through_glass(cased).size());
  for (size_t i = diffuse; i < out.diffuse.size(); ++i) {
    EXPECT_LT(sigmoid(*out.diffuse.at(Attribute::Transmission, i)), 0.01f) << "it is no glass";
    EXPECT_EQ(position(out.diffuse, i), position(cased.transmittance, i - diffuse));
  }

  View beside = scene.capture.view_set.views[1];
  const Vec3d eye{kAside + kHalfWidth, 0, -0.7};  // below the pane
  beside.cam_from_world = inverse(Rigid{Mat3d{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}, eye});
  scene.capture.photos.push_back(make_photo(beside, ImageF(128, 96, 3), 0));
  scene.capture.train.push_back(2);
  out = cased;
  const size_t left = bring_out_from_behind_glass(scene.capture, scene.planes, out).size();
  EXPECT_GT(left, behind / 30);
  EXPECT_LT(left, behind / 2);
  EXPECT_EQ(out.transmittance.size(), left);
  for (size_t i = diffuse; i < out.diffuse.size(); ++i)
    EXPECT_FALSE(std::abs(position(out.diffuse, i).x - eye.x) < 0.1 && std::abs(position(out.diffuse, i).y) < 0.07)
        << "seen beside";

  EXPECT_EQ(bring_out_from_behind_glass(scene.capture, {}, out).size(), left) << "no plane, no wall";
}

// The same with surfels that are no pixel of the half-size photos wide.
TEST(Unseen, SmallSurfelsBehindGlassComeOutToo) {
  TwoPhotos scene;
  SplatScene cased{.diffuse = SplatLayer(LayerKind::Diffuse, 0, 0), .transmittance = SplatLayer(LayerKind::Transmittance, 0, 0)};
  const auto cover = [](SplatLayer& layer, double x_middle, double half, double z, double size, const Vec3f& color) {
    const size_t first = layer.size();
    for (double y = -half; y <= half; y += size)
      for (double x = -half; x <= half; x += size) add_surfel(layer, {x_middle + x, y, z}, {0, 0, 1}, float(size), color);
    return first;
  };
  const size_t pane = cover(cased.diffuse, kAside, 0.4, -0.5, 0.03, {});
  for (size_t i = pane; i < cased.diffuse.size(); ++i) *cased.diffuse.at(Attribute::Transmission, i) = logit(0.98f);
  cover(cased.transmittance, kAside, 0.3, -1, 0.008, kBlue);
  SplatScene out = cased;
  EXPECT_EQ(bring_out_from_behind_glass(scene.capture, scene.planes, out).size(), 1u) << "all but one";
  EXPECT_EQ(out.diffuse.size() + 1, cased.diffuse.size() + cased.transmittance.size());
  // Without the pane both photos see them.
  keep_surfels(cased.diffuse, std::vector<uint32_t>{});
  out = cased;
  EXPECT_EQ(bring_out_from_behind_glass(scene.capture, scene.planes, out).size(), cased.transmittance.size());
  EXPECT_EQ(out.diffuse.size(), 0u);
}

TEST(Unseen, IsCoarserWhereFewSurfelsAreAllowed) {
  const TwoPhotos scene;
  const size_t fine = scene.fill().size(), few = scene.fill(fine / 3).size();
  EXPECT_GT(few, 10u);
  EXPECT_LE(few, fine / 3);
  EXPECT_EQ(scene.fill(0).size(), 0u);
}

TEST(Unseen, WithoutAPlaneThereIsNothingToContinue) {
  TwoPhotos scene;
  scene.planes = {{.normal = {0, 0, 1}, .offset = -0.5}};  // nobody sees anything there
  EXPECT_EQ(scene.fill().size(), 0u);
  scene.planes.clear();
  EXPECT_EQ(scene.fill().size(), 0u);
}

// Both look to the sides of one direction, into a red sky and a blue one; between their pictures it is a bit of both.
TEST(Unseen, TheSkyGoesOn) {
  constexpr double kFar = 100;
  TwoPhotos scene;
  scene.planes.clear();
  scene.background = kFar;
  EXPECT_EQ(scene.fill().size(), 0u) << "no photo shows the sky";
  scene.trained = SplatLayer(LayerKind::Diffuse, 0, 0);
  for (size_t side : {0, 1}) {
    const double turned = side == 0 ? -0.5 : 0.5;  // about y
    View& view = scene.capture.view_set.views[side];
    const Mat3d world_from_cam{{std::cos(turned), 0, -std::sin(turned)}, {0, 1, 0}, {std::sin(turned), 0, std::cos(turned)}};
    view.cam_from_world = inverse(Rigid{world_from_cam, {0, 0, 0}});
    for (PhotoLevel& level : scene.capture.photos[side].levels) level.view.cam_from_world = view.cam_from_world;
    for (double y = -50; y <= 50; y += 3)
      for (double x = -50; x <= 50; x += 3)
        add_surfel(scene.trained, world_from_cam * Vec3d{x, y, kFar}, {0, 0, -1}, 3, side == 0 ? kRed : kBlue);
  }
  const SplatLayer fill = scene.fill();
  ASSERT_GT(fill.size(), 20u);
  double middle_red = 0, middle = 0;
  for (size_t i = 0; i < fill.size(); ++i) {
    const Vec3d p = cast<double>(position(fill, i));
    EXPECT_GT(length(p), 1.1 * kFar) << "behind the sky that was trained";
    for (size_t side : {0, 1}) {
      const Vec3d q = scene.capture.view_set.views[side].cam_from_world * p;
      EXPECT_FALSE(q.z > 0 && std::abs(q.x) < 0.35 * q.z && std::abs(q.y) < 0.25 * q.z) << "a photo shows what is there";
    }
    if (std::abs(p.x) > 0.05 * kFar || std::abs(p.y) > 0.2 * kFar || p.z < 0) continue;
    middle += 1, middle_red += double(0.5f + kShDc * fill.at(Attribute::ShDc, i)[0]);
  }
  ASSERT_GT(middle, 0);
  EXPECT_NEAR(middle_red / middle, 0.45, 0.1);
}

}  // namespace
}  // namespace vitrine
