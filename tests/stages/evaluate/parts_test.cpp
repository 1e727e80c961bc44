// The parts of the stage against values worked out by hand.
#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/math/color.h"
#include "core/scene/camera/view_set.h"
#include "stages/evaluate/albedo_error.h"
#include "stages/evaluate/mesh_error.h"
#include "stages/evaluate/report.h"
#include "stages/evaluate/truth.h"
#include "stages/evaluate/view_error.h"
#include "tests/support/tiny_capture.h"

namespace vitrine {
namespace {

using test::looking_at;
using test::sphere_mesh;

TEST(SampledByDirection, FollowsFocalLengthAndPrincipalPoint) {
  // The map's camera sees twice as wide and is shifted by 3 pixels: our pixel x has the direction (x + .5 - 8) / 16.
  ImageF map(32, 8, 1);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 32; ++x) map.at(x, y) = float(x);
  const Intrinsics map_k{32, 8, 16, 16, 19, 4}, ours{16, 8, 16, 16, 8, 4};
  const ImageF out = sampled_by_direction(map, map_k, ours);
  for (int x = 0; x < 16; ++x) EXPECT_EQ(out.at(x, 4), float(x + 11));
  // Rays that leave the map read 0.
  EXPECT_EQ(sampled_by_direction(map, {32, 8, 16, 16, -20, 4}, ours).at(0, 4), 0);
}

// A camera that looks the other way: its picture would show our rays at the mirrored pixel, were they lines.
TEST(TruthOfATurnedCamera, DirectionsBehindItHaveNoPixel) {
  const Intrinsics k{16, 12, 16, 16, 8, 6};
  const Mat3d around{{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
  const ImageF grey(16, 12, 3, 0.5f), everywhere(16, 12, 1, 1.f);
  for (const bool behind : {false, true}) {
    const TruthPicture truth{grey, k, behind ? around : Mat3d::identity()};
    EXPECT_EQ(sampled_by_direction(grey, k, k, truth.truth_from_ours).at(8, 6), behind ? 0.f : 0.5f);
    AlbedoError albedo;
    albedo.add({k, grey, grey, nullptr, nullptr}, truth);
    EXPECT_NE(albedo.scores().everywhere.has_value(), behind);
    EXPECT_NE(radiance_psnr({k, grey, {1, 1, 1}, everywhere}, truth, 1).has_value(), behind);
  }
}

TEST(TruthZdepth, IsAlongOurAxisWhereTheTruthsCameraIsTurned) {
  // A wall across the truth camera's axis, 2 units away; our camera stands there too and looks 2 degrees to the side and up.
  const Intrinsics k{32, 24, 24, 24, 16, 12};
  View truth_camera, ours;
  truth_camera.name = ours.name = "a.png";
  truth_camera.intrinsics = ours.intrinsics = k;
  truth_camera.cam_from_world = looking_at({1, 0.2, 0.3}, {0, 0, 0});
  ours.cam_from_world = truth_camera.cam_from_world;
  const Mat3d turn = rotation_matrix(normalized(Quatd{1, -0.009, 0.0145, 0}));
  ours.cam_from_world = Rigid{turn * truth_camera.cam_from_world.rotation, turn * truth_camera.cam_from_world.translation};
  const TemporaryFolder folder;
  make_folders(folder.path() / "depth");
  write_transforms_json(folder.path() / "transforms.json", {truth_camera}, ".");
  write_exr(folder.path() / "depth/a.exr", ExrImage{ImageF(32, 24, 1, 2.f), {"Z"}, {}}, ExrPrecision::Float);
  Truth truth(folder.path(), {ours});
  truth.align({}, {ours});
  const ImageF z = truth.zdepth(0, k).value();
  const Rigid world_from_ours = inverse(ours.cam_from_world);
  float nearest = 10, farthest = 0;
  for (int y = 2; y < 22; y += 3)
    for (int x = 2; x < 30; x += 3) {
      // The place that z and the pixel name lies on the wall.
      const Vec3d place = world_from_ours * (double(z.at(x, y)) * k.ray(x + 0.5, y + 0.5));
      EXPECT_NEAR((truth_camera.cam_from_world * place).z, 2, 1e-5) << x << ' ' << y;
      nearest = std::min(nearest, z.at(x, y)), farthest = std::max(farthest, z.at(x, y));
    }
  EXPECT_GT(farthest, 1.02f * nearest);
  // In the truth's own frame nothing is turned.
  EXPECT_EQ(truth.zdepth(0, k, LookupFrame::Truths).value().at(3, 3), 2);
}

TEST(MeshZdepth, IsTheExactDepthOfASlantedPlane) {
  // z = 2 + x, seen from the origin along +z: at pixel direction d, z = 2 / (1 - d).
  TriMesh m;
  for (const auto& [x, y] : {std::pair{-1.5f, -3.f}, {3.f, -3.f}, {3.f, 3.f}, {-1.5f, 3.f}}) m.positions.push_back({x, y, 2 + x});
  m.faces = {{0, 1, 2}, {0, 2, 3}};
  const Intrinsics k{40, 40, 50, 50, 20, 20};
  const ImageF z = mesh_zdepth(m, k, {});
  for (int y = 0; y < 40; y += 3)
    for (int x = 0; x < 40; x += 3) EXPECT_NEAR(z.at(x, y), 2 / (1 - k.ray(x + 0.5, 0).x), 1e-5);
}

TEST(MeshZdepth, ClipsTrianglesThatReachBehindTheCamera) {
  // The floor y = 1 from z = -10 to z = 10, seen from the origin: depth 1 / d.y below the horizon, nothing above.
  TriMesh m;
  m.positions = {{-50, 1, -10}, {50, 1, -10}, {50, 1, 10}, {-50, 1, 10}};
  m.faces = {{0, 1, 2}, {0, 2, 3}};
  const Intrinsics k{20, 40, 20, 20, 10, 20};
  const ImageF z = mesh_zdepth(m, k, {});
  EXPECT_EQ(z.at(10, 5), 0);
  EXPECT_EQ(z.at(10, 21), 0);  // 1 / 0.075 lies beyond the floor's end
  EXPECT_NEAR(z.at(10, 30), 1 / k.ray(0, 30.5).y, 1e-5);
  EXPECT_NEAR(z.at(3, 39), 1 / k.ray(0, 39.5).y, 1e-5);
}

std::vector<MeshView> views_around(size_t n) {
  std::vector<MeshView> views;
  for (size_t i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * double(i) / double(n), h = i % 2 ? 1.2 : -1.2;
    views.push_back({{160, 120, 160, 160, 80, 60}, looking_at({3 * std::cos(a), 3 * std::sin(a), h}, {0, 0, 0}), {}, {}});
  }
  return views;
}
MeshError error_of(const TriMesh& ours, const TriMesh& truth, const std::vector<MeshView>& views) {
  return mesh_error(ours, truth, truth, views.size(), [&](size_t i) { return views[i]; }, {.samples = 20'000});
}

TEST(MeshErrorTest, IdenticalMeshesArePerfect) {
  const TriMesh ball = sphere_mesh(0.5);
  const MeshError e = error_of(ball, ball, views_around(12));
  EXPECT_EQ(e.fscore, 1);
  EXPECT_LT(e.chamfer_rel, 1e-6);
  EXPECT_NEAR(e.diagonal, std::sqrt(3.0), 1e-6);
  EXPECT_GT(e.truth_samples, 19'000u);  // seen from all around
}

TEST(MeshErrorTest, DisplacementBelowTheThresholdKeepsTheScoreAboveItLosesIt) {
  const TriMesh truth = sphere_mesh(0.5);
  const double d = std::sqrt(3.0);
  const MeshError near = error_of(sphere_mesh(0.5 + 0.008 * d), truth, views_around(12));
  EXPECT_EQ(near.fscore, 1);
  EXPECT_NEAR(near.accuracy_rel, 0.008, 1e-4);
  const MeshError far = error_of(sphere_mesh(0.5 + 0.012 * d), truth, views_around(12));
  EXPECT_EQ(far.fscore, 0);
  EXPECT_NEAR(far.completeness_rel, 0.012, 1e-4);
}

TEST(MeshErrorTest, MissingHalfCostsRecallNotPrecision) {
  const TriMesh truth = sphere_mesh(0.5);
  TriMesh half = truth;
  std::erase_if(half.faces,
                [&](const auto& f) { return truth.positions[f[0]].z + truth.positions[f[1]].z + truth.positions[f[2]].z < 0; });
  const MeshError e = error_of(half, truth, views_around(12));
  EXPECT_GT(e.precision, 0.99);
  EXPECT_NEAR(e.recall, 0.52, 0.03);
  EXPECT_NEAR(e.fscore, 2 * e.precision * e.recall / (e.precision + e.recall), 1e-12);
}

TEST(MeshErrorTest, ARoomThatTheTruthMeshLeavesOutIsNeitherPraisedNorBlamed) {
  const TriMesh truth = sphere_mesh(0.5);
  TriMesh ours = truth, wall = sphere_mesh(8);  // around everything, cameras included
  const uint32_t offset = uint32_t(ours.positions.size());
  ours.positions.insert(ours.positions.end(), wall.positions.begin(), wall.positions.end());
  for (const auto& f : wall.faces) ours.faces.push_back({f[0] + offset, f[2] + offset, f[1] + offset});
  std::vector<MeshView> views = views_around(12);
  for (MeshView& v : views) v.zdepth = mesh_zdepth(ours, v.intrinsics, v.cam_from_world);  // the depth maps know the wall
  const MeshError e = error_of(ours, truth, views);
  EXPECT_EQ(e.precision, 1);
  EXPECT_EQ(e.recall, 1);
  EXPECT_GT(e.our_samples, 20u);  // few: most samples fell on the large wall
}

TEST(MeshErrorTest, AFloaterInFrontOfTheTruthCostsPrecision) {
  const TriMesh truth = sphere_mesh(0.5);
  TriMesh ours = truth, floater = sphere_mesh(0.2, {0.9, 0, 0});
  const uint32_t offset = uint32_t(ours.positions.size());
  ours.positions.insert(ours.positions.end(), floater.positions.begin(), floater.positions.end());
  for (const auto& f : floater.faces) ours.faces.push_back({f[0] + offset, f[1] + offset, f[2] + offset});
  std::vector<MeshView> views;
  for (double dy : {-0.2, -0.1, 0.0, 0.1, 0.2})
    views.push_back({{160, 120, 160, 160, 80, 60}, looking_at({4, dy, 0.1}, {0, 0, 0}), {}, {}});
  const MeshError e = error_of(ours, truth, views);
  EXPECT_LT(e.precision, 0.9);
  EXPECT_GT(e.precision, 0.3);
}

TEST(MeshErrorTest, WhatIsSeenOnlyThroughGlassDoesNotCount) {
  const TriMesh truth = sphere_mesh(0.5);
  std::vector<MeshView> views = views_around(12);
  for (MeshView& v : views) v.transparent = ImageF(160, 120, 1, 1.f);
  const MeshError e = error_of(truth, truth, views);
  EXPECT_EQ(e.truth_samples, 0u);
  EXPECT_EQ(e.our_samples, 0u);
  EXPECT_EQ(e.fscore, 0);
}

TEST(SurfaceErrorTest, AnglesAndDepthAreThoseThatWerePutIn) {
  ViewPicture ours{{2, 2, 1, 1, 1, 1}, ImageF(2, 2, 3), ImageF(2, 2, 1, 2.f), ImageF(2, 2, 3), {}};
  ours.zdepth.at(1, 1) = 0;  // not opaque: does not count
  SurfaceTruth truth{ImageF(2, 2, 3), ImageF(2, 2, 1, 4.4f)};
  ImageF counts(2, 2, 1, 1.f);
  counts.at(0, 1) = 0;                                    // outside the region
  const Mat3d quarter{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}};  // x -> y
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 2; ++x) {
      ours.normal_in_world.at(x, y, 0) = 1;
      truth.normal.at(x, y, 1) = 1;
    }
  truth.normal.at(1, 0, 1) = float(std::cos(0.1)), truth.normal.at(1, 0, 2) = float(std::sin(0.1));
  SurfaceError e;
  add_surface_error(ours, truth, {2, quarter, {}}, &counts, e);
  ASSERT_EQ(e.normal_deg.size(), 2u);
  EXPECT_NEAR(e.normal_deg[0], 0, 1e-9);
  EXPECT_NEAR(e.normal_deg[1], 0.1 * 180 / std::numbers::pi, 1e-5);
  ASSERT_EQ(e.zdepth_rel.size(), 2u);
  EXPECT_NEAR(e.zdepth_rel[0], 0.4 / 4.4, 1e-6);
}

TEST(ViewSplitTest, RefusesNamesThatTheCaptureDoesNotHave) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "views.json";
  std::vector<View> views(2);
  views[0].name = "a.png", views[1].name = "b.png";
  write_file(path, R"({"holdout_every":8,"max_side":320,"train":["b.png"],"heldout":["a.png"]})");
  const ViewSplit split = read_view_split(path, views);
  EXPECT_EQ(split.max_side, 320);
  EXPECT_EQ(split.heldout, std::vector<size_t>{0});
  EXPECT_FALSE(split.object_alone);
  write_file(path, R"({"holdout_every":8,"max_side":320,"object_alone":true,"train":["b.png"],"heldout":["a.png"]})");
  EXPECT_TRUE(read_view_split(path, views).object_alone);
  for (const char* bad : {R"({"holdout_every":8,"max_side":320,"object_alone":"yes","train":["b.png"],"heldout":[]})",
                          R"({"holdout_every":8,"max_side":320,"train":["c.png"],"heldout":[]})", R"({"max_side":1})", "[]", "{",
                          R"({"holdout_every":8,"max_side":-3,"train":["a.png"],"heldout":[]})",
                          R"({"holdout_every":8,"max_side":"x","train":["a.png"],"heldout":[]})",
                          R"({"holdout_every":8,"max_side":0,"train":[7],"heldout":[]})",
                          R"({"holdout_every":8,"max_side":0,"train":[],"heldout":[]})"}) {
    write_file(path, bad);
    try {
      read_view_split(path, views);
      FAIL() << bad;
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::Input) << bad;
      EXPECT_EQ(e.detail().where, path.string());
    }
  }
}

TEST(ErrorPicture, IsBlackWithoutErrorAndBrightestFromTheLimitOn) {
  ImageF a(2, 1, 3, 0.5f), b = a;
  for (int c = 0; c < 3; ++c) b.at(1, 0, c) = 0.9f;
  const Image8 e = error_picture(a, b);
  EXPECT_EQ(e.at(0, 0, 0), 0);
  EXPECT_EQ(e.at(1, 0, 0), 255);
}

TEST(DepthPicture, GrowsDarkerWithDistanceAndLeavesRoomForTheSceneBeforeASky) {
  ImageF depth(100, 1, 1, 0.f);  // nothing; a scene from 1 to 3; a sky
  for (int x = 10; x < 70; ++x) depth.at(x, 0) = 1 + 2 * float(x - 10) / 59;
  for (int x = 70; x < 100; ++x) depth.at(x, 0) = 100;
  const Image8 picture = depth_picture(depth);
  const auto brightness = [&](int x) { return int(picture.at(x, 0, 0)) + picture.at(x, 0, 1) + picture.at(x, 0, 2); };
  EXPECT_EQ(brightness(0), 0);
  for (int x = 11; x < 70; ++x) EXPECT_LE(brightness(x), brightness(x - 1)) << x;
  EXPECT_GT(brightness(70), 0) << "a sky is something";
  // By depth itself all of the scene would take a fiftieth of the ramp.
  EXPECT_GT(brightness(10) - brightness(69), brightness(69) - brightness(70));
}

// A photo of a grey backdrop, with a texture, a coloured and a dark strip, and its render.
struct Backdrop {
  ImageF photo{64, 32, 3}, render{64, 32, 3}, counts{64, 32, 1, 1.f};
};
Backdrop backdrop(const Vec3f& gain) {
  Backdrop b;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c) {
        float grey = 0.7f;
        if (y < 8) grey = (x + y) % 4 == 0 ? 0.6f : 0.7f;    // texture
        if (y >= 8 && y < 16) grey = c == 2 ? 0.62f : 0.7f;  // colour
        if (y >= 28) grey = 0.2f;                            // dark
        b.photo.at(x, y, c) = grey;
        b.render.at(x, y, c) =
            srgb_from_linear(linear_from_srgb(grey) * (y >= 16 && y < 28 ? gain[size_t(c)] : 0.3f + 0.2f * float(c)));
      }
  return b;
}

TEST(NeutralShift, IsTheRatioOfTheChannelsInPlainNeutralPixelsAlone) {
  Backdrop b = backdrop({1.06f, 0.93f, 0.54f});
  EXPECT_NEAR(neutral_shift(b.render, b.photo, b.counts, 100).value(), 1.06 / 0.54 - 1, 1e-3);
  for (int x = 0; x < 64; ++x) b.render.at(x, 20, 1) = 0;  // few wrong pixels do not matter, black ones have a logarithm
  EXPECT_NEAR(neutral_shift(b.render, b.photo, b.counts, 100).value(), 1.06 / 0.54 - 1, 1e-3);
  const Backdrop darker = backdrop({0.5f, 0.5f, 0.5f});
  EXPECT_NEAR(neutral_shift(darker.render, darker.photo, darker.counts, 100).value(), 0, 1e-3) << "brightness is no colour";
}

TEST(NeutralShift, OfTooFewPixelsIsNotKnown) {
  Backdrop b = backdrop({1, 1, 0.5f});
  EXPECT_EQ(neutral_shift(b.render, b.photo, b.counts, 60 * 8 + 1), std::nullopt) << "rows 18 to 25 of 60 pixels";
  EXPECT_TRUE(neutral_shift(b.render, b.photo, b.counts, 60 * 8));
  for (int y = 0; y < 32; ++y) b.counts.at(32, y) = 0;  // and two pixels to each side
  EXPECT_EQ(neutral_shift(b.render, b.photo, b.counts, 55 * 8 + 1), std::nullopt);
  EXPECT_TRUE(neutral_shift(b.render, b.photo, b.counts, 55 * 8));
  b.counts = ImageF(64, 32, 1);
  EXPECT_EQ(neutral_shift(b.render, b.photo, b.counts, 0), std::nullopt);
}

TEST(RankCorrelation, IsOfTheOrderAlone) {
  const std::vector<float> a{1, 2, 3, 4, 5}, squares{1, 4, 9, 16, 25}, falling{5, 4, 3, 2, 1}, ties{1, 1, 2, 2, 3};
  EXPECT_NEAR(rank_correlation(a, squares).value(), 1, 1e-12);
  EXPECT_NEAR(rank_correlation(a, falling).value(), -1, 1e-12);
  // Ranks 0.5 0.5 2.5 2.5 4: covariance 9, variances 10 and 9.
  EXPECT_NEAR(rank_correlation(a, ties).value(), 9 / std::sqrt(90.0), 1e-12);
  EXPECT_FALSE(rank_correlation(a, std::vector<float>(5, 2.f)));
  EXPECT_FALSE(rank_correlation(std::span<const float>(), std::span<const float>()));
}

}  // namespace
}  // namespace vitrine
