// A black ball, placed over a floor, under a uniform sky: the shadow that a picture over a photo must show is known. A floor
// element at horizontal distance x from the axis of a ball of radius r, centre at height h > r, loses the form factor of a sphere
// of its irradiance:  r^2 h / (x^2 + h^2)^(3/2)  (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-42).
#include <cmath>

#include <gtest/gtest.h>

#include "core/render/edit/joined_scene.h"
#include "core/render/edit/placed_scene.h"
#include "stages/relight/relight.h"
#include "tests/support/error_of.h"
#include "tests/support/spheres.h"

namespace vitrine {
namespace {

constexpr double kRadius = 0.6, kHeight = 0.9, kHalf = 3;
constexpr size_t kSide = 41;  // of the floor, surfels and vertices
constexpr size_t kFloor = kSide * kSide, kBall = 700;

void add(TriMesh& mesh, const TriMesh& more) {
  const auto first = uint32_t(mesh.positions.size());
  for (const auto& f : more.faces) mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
  mesh.positions.insert(mesh.positions.end(), more.positions.begin(), more.positions.end());
}

ScenePart floor_part() {
  ScenePart part{.name = "floor", .where = "", .scene = {}, .objects = {}};
  SplatLayer& surfels = part.scene.trained.surfels.diffuse;
  surfels = SplatLayer(LayerKind::Diffuse, 0, kFloor);
  DecomposedMaterials& m = part.scene.materials.emplace();
  m.resize(kFloor);
  TriMesh& mesh = part.scene.mesh;
  const double step = 2 * kHalf / (kSide - 1);
  for (size_t i = 0; i < kFloor; ++i) {
    const Vec3f p{float(double(i % kSide) * step - kHalf), float(double(i / kSide) * step - kHalf), 0};
    for (size_t c = 0; c < 3; ++c) surfels.at(Attribute::Mean, i)[c] = p[c];
    surfels.at(Attribute::Rotation, i)[0] = 1;
    for (size_t c = 0; c < 2; ++c) surfels.at(Attribute::LogScale, i)[c] = float(std::log(step));
    *surfels.at(Attribute::Opacity, i) = 6;
    m.albedo[i] = {0.6f, 0.5f, 0.4f}, m.roughness[i] = 1;
    mesh.positions.push_back(p);
  }
  for (uint32_t y = 0; y + 1 < kSide; ++y)
    for (uint32_t x = 0; x + 1 < kSide; ++x) {
      const uint32_t a = y * kSide + x, b = a + 1, c = a + kSide, d = c + 1;
      mesh.faces.push_back({a, b, d}), mesh.faces.push_back({a, d, c});
    }
  // Rays start some mean edge lengths above a surface: a finely meshed pebble in a corner makes that little.
  add(mesh, test::sphere_mesh(0.02, {-2.8, 2.8, 0.02}, 96, 192));
  part.scene.keep_all();
  return part;
}

// A black ball of half the size, to be placed.
ScenePart ball_part() {
  ScenePart part{.name = "ball", .where = "", .scene = {}, .objects = {}};
  part.scene.trained.surfels.diffuse = test::sphere_layer(kRadius / 2, kBall);
  DecomposedMaterials& m = part.scene.materials.emplace();
  m.resize(kBall);
  std::ranges::fill(m.roughness, 1.f);
  std::ranges::fill(m.f0, Vec3f{1e-4f, 1e-4f, 1e-4f});  // no sky
  part.scene.mesh = test::sphere_mesh(kRadius / 2);
  part.scene.keep_all();
  part.scene = placed(part.scene, {2, rotation_matrix(normalized(Quatd{1, 0.2, 0.3, 0})), {0, 0, kHeight}});
  return part;
}

struct Rendered {
  View view;
  GuestPicture picture;
};
const Rendered& rendered() {
  static const Rendered made = [] {
    Rendered r;
    r.view.name = "photo.jpg", r.view.intrinsics = {80, 60, 80, 80, 40, 30};
    r.view.cam_from_world = test::looking_at({0, -4.4, 3.2}, {0, 0, 0.2});
    r.view.gain = {1, 1, 1};
    Lighting lighting;
    lighting.environment = Environment(ImageF(16, 8, 3, 1.f));
    const JoinedScene all = joined({floor_part(), ball_part()});
    r.picture = guest_over_photo(all.scene, all.ids[1], lighting,
                                 {.view = r.view, .photo = ImageF(80, 60, 3, 0.5f), .samples = 64, .seed = 1, .stops = 0.0});
    return r;
  }();
  return made;
}

TEST(GuestOverPhoto, TheShadowIsTheFormFactorOfTheBall) {
  const auto& [view, picture] = rendered();
  const Vec3d eye = view.centre_in_world();
  double error = 0, bias = 0, darkest = 1;
  size_t count = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x) {
      const Vec3d way = view.ray(x + 0.5, y + 0.5);
      if (!(way.z < 0)) continue;
      const Vec3d p = eye - (eye.z / way.z) * way;
      const double far = std::hypot(p.x, p.y);
      if (std::max(std::abs(p.x), std::abs(p.y)) > 0.8 * kHalf || picture.over.at(x, y, 0) > 1e-3f) continue;
      const double expected = 1 - kRadius * kRadius * kHeight / std::pow(far * far + kHeight * kHeight, 1.5);
      const double difference = double(picture.shadow.at(x, y, 1)) - expected;
      error += difference * difference, bias += difference, ++count;
      darkest = std::min(darkest, expected);
    }
  ASSERT_GT(count, 1000u);
  EXPECT_LT(darkest, 0.8) << "the picture shows the shadow";
  RecordProperty("rms_ppm", int(1e6 * std::sqrt(error / double(count))));
  RecordProperty("bias_ppm", int(1e6 * bias / double(count)));
  EXPECT_LT(std::sqrt(error / double(count)), 0.04);
  EXPECT_LT(std::abs(bias / double(count)), 0.01);
}

TEST(GuestOverPhoto, AlphaCoversThePhotoWithBallAndShadow) {
  const auto& [view, picture] = rendered();
  const Vec3d centre = view.cam_from_world * Vec3d{0, 0, kHeight};
  const int x = int(view.intrinsics.fx * centre.x / centre.z + view.intrinsics.cx),
            y = int(view.intrinsics.fy * centre.y / centre.z + view.intrinsics.cy);
  EXPECT_GT(picture.over.at(x, y, 3), 0.97f);
  EXPECT_LT(picture.composite.at(x, y, 1), 0.05f) << "the ball is black";
  for (int row : {58, 40})
    for (int column : {3, 40, 76}) {
      const float ratio = picture.shadow.at(column, row, 1), alpha = picture.over.at(column, row, 3);
      if (picture.over.at(column, row, 0) > 1e-3f) continue;
      EXPECT_NEAR(1 - alpha, std::min(ratio, 1.f), 0.03f);
      EXPECT_NEAR(picture.composite.at(column, row, 1), 0.5f * ratio, 0.02f);
    }
}

TEST(GuestOverPhoto, GuestsAreThePartsAfterTheFirst) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "compose/report.json";
  make_folders(file.parent_path());
  write_file(file, R"({"parts": [{"objects": [1, 2]}, {"objects": [3]}, {"objects": [4, 5]}]})");
  EXPECT_EQ(guest_ids(folder.path()), (std::vector<uint16_t>{3, 4, 5}));
  write_file(file, R"({"parts": [{"objects": [1, 2]}]})");
  EXPECT_EQ(error_of([&] { guest_ids(folder.path()); }).detail().code, "NO_GUEST");
}

}  // namespace
}  // namespace vitrine
