// Two balls with labels, seen from a ring of cameras: which object each surfel, vertex, place and pixel shows is known.
#include "core/render/picture/part_labels.h"

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/surfels/splat_scene.h"
#include "tests/support/spheres.h"

namespace vitrine {
namespace {

constexpr uint16_t kLeft = 3, kRight = 700;
constexpr double kRadius = 0.15;
const Vec3d kLeftPlace{-0.2, 0, 0}, kRightPlace{0.25, 0, 0};
constexpr float kNear = 0.01f;

bool meets(const Vec3d& eye, const Vec3d& ray, const Vec3d& centre, double& at) {
  const Vec3d d = normalized(ray), o = eye - centre;
  const double b = dot(o, d), root = b * b - dot(o, o) + kRadius * kRadius;
  at = root < 0 ? 1e9 : -b - std::sqrt(root);
  return root >= 0;
}

std::vector<LabelledView> photos() {
  std::vector<LabelledView> out;
  for (int i = 0; i < 9; ++i) {
    const double a = 0.3 + 2 * std::numbers::pi * i / 9;
    LabelledView v;
    v.view.name = "photo_" + std::to_string(i) + ".png";
    v.view.intrinsics = {96, 72, 100, 100, 48, 36};
    v.view.cam_from_world = test::looking_at({std::cos(a), std::sin(a), 0.3}, {0, 0, 0});
    v.labels = Image16(96, 72, 1);
    const Rigid world_from_cam = inverse(v.view.cam_from_world);
    for (int y = 0; y < 72; ++y)
      for (int x = 0; x < 96; ++x) {
        const Vec3d ray = world_from_cam.rotation * v.view.intrinsics.ray(x + 0.5, y + 0.5);
        double left = 0, right = 0;
        meets(world_from_cam.translation, ray, kLeftPlace, left), meets(world_from_cam.translation, ray, kRightPlace, right);
        if (std::min(left, right) < 1e8) v.labels.at(x, y) = left < right ? kLeft : kRight;
      }
    out.push_back(std::move(v));
  }
  return out;
}

void append(SplatLayer& to, const SplatLayer& more, const Vec3d& by) {
  const size_t first = to.size();
  to.resize(first + more.size());
  for (size_t i = 0; i < more.size(); ++i) {
    for (const AttributeRow& r : kAttributes)
      for (size_t c = 0; c < to.width(r.id); ++c) to.at(r.id, first + i)[c] = more.at(r.id, i)[c];
    for (size_t c = 0; c < 3; ++c) to.at(Attribute::Mean, first + i)[c] += float(by[c]);
  }
}

// The left ball, the right ball, a speck inside the left one, and a far shell around everything.
constexpr size_t kSurfels = 1200, kSpeck = 2 * kSurfels, kShell = 600;
SplatLayer scene() {
  SplatLayer layer(LayerKind::Diffuse, 0, 0);
  append(layer, test::sphere_layer(kRadius, kSurfels), kLeftPlace);
  append(layer, test::sphere_layer(kRadius, kSurfels), kRightPlace);
  append(layer, test::sphere_layer(0.001, 1), kLeftPlace);
  append(layer, test::sphere_layer(5, kShell), {});
  return layer;
}

double share_of(std::span<const uint16_t> ids, uint16_t id) { return double(std::ranges::count(ids, id)) / double(ids.size()); }

TEST(PartLabels, SurfelsBelongToWhatThePhotosShowThere) {
  const auto views = photos();
  const SurfelLabels found = labels_of_surfels(scene(), kNear, views);
  const std::span<const uint16_t> label(found.label);
  EXPECT_GT(share_of(label.subspan(0, kSurfels), kLeft), 0.95);
  EXPECT_GT(share_of(label.subspan(kSurfels, kSurfels), kRight), 0.95);
  EXPECT_GT(share_of(label.subspan(kSpeck + 1), 0), 0.99);
  EXPECT_FALSE(found.seen[kSpeck]);
  EXPECT_EQ(found.label[kSpeck], kLeft) << "hidden in the left ball: behind its label in all photos";
}

TEST(PartLabels, MoreThanThreeObjectsInOnePhoto) {
  auto views = photos();
  // The balls in bands: five labels in a photo.
  for (LabelledView& v : views)
    for (int y = 0; y < v.labels.height(); ++y)
      for (int x = 0; x < v.labels.width(); ++x)
        if (v.labels.at(x, y) == kRight) v.labels.at(x, y) = uint16_t(kRight + 1 + x % 4);
  const SurfelLabels found = labels_of_surfels(scene(), kNear, views);
  const std::span<const uint16_t> label(found.label);
  EXPECT_GT(share_of(label.subspan(0, kSurfels), kLeft), 0.95);
  for (size_t i = kSurfels; i < 2 * kSurfels; ++i)
    if (found.seen[i]) {
      EXPECT_TRUE(label[i] == 0 || (label[i] > kRight && label[i] <= kRight + 4)) << label[i];
    }
  EXPECT_LT(share_of(label.subspan(kSurfels, kSurfels), 0), 0.1) << "photos do not agree on what is hidden";
}

TEST(PartLabels, VerticesAndPlaces) {
  const auto views = photos();
  for (const auto& [place, id] : {std::pair{kLeftPlace, kLeft}, {kRightPlace, kRight}}) {
    const std::vector<uint16_t> vertices = labels_of_vertices(test::sphere_mesh(kRadius, place), views);
    EXPECT_GT(share_of(vertices, id), 0.9) << "all that some photo shows; none looks from below";
  }
  const std::vector<Vec3d> places{kLeftPlace, kRightPlace, {0, 0.6, 0}, {0, 0, 40}};
  EXPECT_EQ(labels_of_places(
                places.size(), [&](size_t i) { return places[i]; }, views),
            (std::vector<uint16_t>{kLeft, kRight, 0, 0}));
  EXPECT_EQ(labels_of_places(
                1, [&](size_t) { return kLeftPlace; }, std::span(views).first(2)),
            std::vector<uint16_t>{0})
      << "two photos make no hull";
}

TEST(PartLabels, AreRenderedAsTheyWereGiven) {
  const auto views = photos();
  SplatLayer diffuse = scene(), inside(LayerKind::Transmittance, 0, 0);
  append(inside, test::sphere_layer(0.02, 5), kRightPlace);
  assign_objects({}, std::span(views).first(8), kNear, diffuse, inside);
  EXPECT_EQ(share_of(inside.object_ids(), kRight), 1);
  const Image16 shown = rendered_objects(diffuse, kNear, views[8].view);
  size_t both = 0, either = 0;
  for (size_t p = 0; p < shown.pixel_count(); ++p) {
    const uint16_t a = shown.data()[p], b = views[8].labels.data()[p];
    either += a != 0 || b != 0, both += a != 0 && a == b;
  }
  EXPECT_GT(double(both), 0.85 * double(either)) << "a ball of 30 pixels, whose surfels reach half a pixel beyond it";
}

// A vase in a case: pixels of the case show the vase.
TEST(PartLabels, WhatStandsInThinGlassBelongsToNone) {
  const auto views = photos();
  SplatLayer diffuse = scene(), inside(LayerKind::Transmittance, 0, 0);
  append(inside, test::sphere_layer(0.02, 5), kRightPlace);
  append(inside, test::sphere_layer(0.02, 5), kLeftPlace);
  const size_t half = inside.size() / 2;
  for (size_t i = 0; i < diffuse.size(); ++i) *diffuse.at(Attribute::Transmission, i) = i % 2 == 0 ? 3.f : -3.f;
  for (const ObjectRole role : {ObjectRole::ThinGlass, ObjectRole::SolidGlass}) {
    const ObjectSet set{
        .objects = {{.id = kLeft, .name = "ball", .role = ObjectRole::Mirror}, {.id = kRight, .name = "case", .role = role}},
        .shapes = {}};
    const bool thin = role == ObjectRole::ThinGlass;
    assign_objects(set, views, kNear, diffuse, inside);
    EXPECT_EQ(share_of(inside.object_ids().first(half), kRight), thin ? 0 : 1);
    EXPECT_EQ(share_of(inside.object_ids().subspan(half), kLeft), 1);
    EXPECT_GT(share_of(diffuse.object_ids().first(kSurfels), kLeft), 0.95);
    for (size_t i = kSurfels; i < 2 * kSurfels; ++i)
      if (i % 2 != 0 && thin) {
        EXPECT_NE(diffuse.object_ids()[i], kRight) << "hides what is behind it";
      }
    EXPECT_NEAR(share_of(diffuse.object_ids().subspan(kSurfels, kSurfels), kRight), thin ? 0.5 : 1, 0.1);
  }
}

TEST(PartLabels, SameForAnyNumberOfThreads) {
  const auto views = photos();
  const SplatLayer layer = scene();
  set_thread_limit(1);
  const auto one = labels_of_surfels(layer, kNear, views).label;
  set_thread_limit(5);
  EXPECT_EQ(labels_of_surfels(layer, kNear, views).label, one);
  set_thread_limit(0);
}

TEST(PartLabels, GoIntoFilesAndSubsets) {
  const TemporaryFolder folder;
  const auto views = photos();
  SplatLayer layer = scene(), none(LayerKind::Transmittance, 0, 0);
  assign_objects({}, {}, kNear, layer, none);
  EXPECT_TRUE(layer.object_ids().empty()) << "no photo with labels: nothing is known";
  assign_objects({}, views, kNear, layer, none);
  write_layer(folder.path() / "diffuse.ply", layer);
  EXPECT_EQ(read_layer(folder.path() / "diffuse.ply"), layer);
  std::vector<uint8_t> keep(layer.size(), 0);
  for (size_t i = kSurfels - 1; i < kSurfels + 2; ++i) keep[i] = 1;
  const SplatLayer three = kept_surfels(layer, keep);
  ASSERT_EQ(three.object_ids().size(), 3u);
  EXPECT_EQ(three.object_ids()[0], layer.object_ids()[kSurfels - 1]);
  EXPECT_EQ(three.object_ids()[2], layer.object_ids()[kSurfels + 1]);

  TriMesh mesh = test::sphere_mesh(kRadius, kLeftPlace);
  mesh.object_ids = labels_of_vertices(mesh, views);
  mesh.object_ids[0] = 65535;
  write_mesh_ply(folder.path() / "mesh.ply", mesh);
  EXPECT_EQ(read_mesh_ply(folder.path() / "mesh.ply").object_ids, mesh.object_ids);
  EXPECT_EQ(mesh.object_of_face(mesh.faces.size() / 2), kLeft);
  std::vector<uint8_t> faces(mesh.faces.size(), 0);
  faces[mesh.faces.size() / 2] = 1;
  EXPECT_EQ(submesh(mesh, faces).object_ids, (std::vector<uint16_t>{kLeft, kLeft, kLeft}));
}

}  // namespace
}  // namespace vitrine
