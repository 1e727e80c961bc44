// A polished vase, whose shape was found in its silhouettes, or learnt by training.
#include "stages/mesh/fusion.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/scene/image/ldr.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/observe/stereo/revolution_fit.h"
#include "tests/core/scene/mesh/orbit.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

class PolishedVase : public testing::Test {
 protected:
  void SetUp() override {
    std::vector<double> radii;
    for (int i = 0; i <= 40; ++i) radii.push_back(0.16 + 0.04 * std::cos(9 * (-0.2 + 0.01 * i)));
    vase = revolved({0.02, 0, 0}, {0, 0, 1}, -0.2, 0.01, radii);
    views = orbit::views(12, {10, 40}, 1.4, 160);
    masks = folder.path() / "masks";
    make_folders(masks / "masks" / "specular");
    for (const View& view : views) {
      const Intrinsics& k = view.intrinsics;
      Image8 mask(k.width, k.height, 1);
      each_ray(view, [&](int x, int y, const Vec3d& eye, const Vec3d& ray) {
        if (entry(eye, ray)) mask.at(x, y) = 255;
      });
      write_ldr(masks / "masks" / "specular" / (view.stem() + ".png"), mask);
    }
  }
  std::optional<double> entry(const Vec3d& eye, const Vec3d& ray) const {
    const auto hit = vase.intersect({eye, ray});
    return hit ? std::optional(hit->t) : std::nullopt;
  }
  // The vase as an object of this role; `learnt`: by training.
  MirrorDepth depth_of(ObjectRole role, const ShapeSet* learnt = nullptr, bool has_shape = true) const {
    ObjectSet set = test::one_object(vase, role, 0.01);
    if (!has_shape) set.shapes = {};
    const fs::path artifact = folder.path() / name(role);
    fs::remove_all(artifact);
    return {LabelledObjects::trusted(test::write_objects_artifact(artifact, masks, views, set)), learnt, views};
  }
  ShapeSet as_learnt(const SurfaceOfRevolution& shape) const {
    return {{{.shape = shape, .role = ShapeRole::Mirror, .tolerance = 0.01, .clear = {}, .object = 1}}};
  }
  template <class F>
  static void each_ray(const View& view, const F& f) {
    const Vec3d eye = view.centre_in_world();
    for (int y = 0; y < view.intrinsics.height; ++y)
      for (int x = 0; x < view.intrinsics.width; ++x) f(x, y, eye, view.ray(x + 0.5, y + 0.5));
  }
  static RgbdFrame nothing_learnt(const View& view) {
    const size_t pixels = view.intrinsics.pixel_count();
    return {view.intrinsics, view.cam_from_world, std::vector<float>(pixels), std::vector<float>(pixels), {}};
  }

  TemporaryFolder folder;
  fs::path masks;
  SurfaceOfRevolution vase;
  std::vector<View> views;
};

TEST_F(PolishedVase, IsTheSolidThatWasFoundInItsSilhouettes) {
  const MirrorDepth shape = depth_of(ObjectRole::Mirror);
  std::vector<double> off;
  for (size_t v = 0; v < views.size(); ++v) {
    RgbdFrame frame = nothing_learnt(views[v]);
    shape.put(v, frame, 0.01);
    each_ray(views[v], [&](int x, int y, const Vec3d& eye, const Vec3d& ray) {
      const float z = frame.zdepth[size_t(y * frame.intrinsics.width + x)];
      const auto t = entry(eye, ray);
      if (!(z > 0) || !t) return;
      const ShapePoint truth = vase.nearest(eye + *t * ray);
      if (std::abs(truth.normal.z) < 0.5)
        off.push_back(length(vase.nearest(eye + double(z) * ray).position - (eye + double(z) * ray)));
    });
  }
  ASSERT_GT(off.size(), 10000u);
  std::ranges::sort(off);
  fmt::print("off by {:.4f} in the median, {:.4f} for nine tenths\n", off[off.size() / 2], off[off.size() * 9 / 10]);
  EXPECT_LT(off[off.size() / 2], 0.0015);
  EXPECT_LT(off[off.size() * 9 / 10], 0.004);
}

TEST_F(PolishedVase, KeepsItsOwnDepthUnderACoat) {
  const MirrorDepth shape = depth_of(ObjectRole::Coat);
  EXPECT_TRUE(shape.empty());
  RgbdFrame frame = nothing_learnt(views[0]);
  shape.put(0, frame, 0.01);
  EXPECT_TRUE(std::ranges::all_of(frame.zdepth, [](float z) { return z == 0; }));
}

// A guess takes no part.
TEST_F(PolishedVase, KeepsItsOwnDepthWhereItIsOnlyGuessed) {
  ObjectSet set = test::one_object(vase, ObjectRole::Mirror, 0.01);
  set.objects[0].trust = ObjectTrust::Guessed;
  const fs::path artifact = test::write_objects_artifact(folder.path() / "guess", masks, views, set);
  EXPECT_TRUE(MirrorDepth(LabelledObjects::trusted(artifact), nullptr, views).empty());
}

// Pixels of a mirror beside its shape show pictures in it: they are not fused; nor is what stands in front of it.
TEST_F(PolishedVase, DropsWhatItsShapeDoesNotExplain) {
  SurfaceOfRevolution narrow = vase;
  for (Vec2d& p : narrow.profile) p.x *= 0.5;
  const ShapeSet learnt = as_learnt(narrow);
  const MirrorDepth shape = depth_of(ObjectRole::Mirror, &learnt);
  RgbdFrame frame = nothing_learnt(views[0]);
  std::ranges::fill(frame.weight, 1.f), std::ranges::fill(frame.zdepth, 2.f);
  const size_t middle = size_t(frame.intrinsics.height / 2 * frame.intrinsics.width + frame.intrinsics.width / 2);
  frame.zdepth[middle] = 0.3f;  // a hand before it
  shape.put(0, frame, 0.01);
  EXPECT_EQ(frame.zdepth[middle], 0.3f);
  size_t dropped = 0;
  each_ray(views[0], [&](int x, int y, const Vec3d& eye, const Vec3d& ray) {
    const size_t p = size_t(y * frame.intrinsics.width + x);
    const bool beside = entry(eye, ray) && !narrow.intersect({eye, ray});
    if (!beside) return;
    EXPECT_EQ(frame.weight[p], 0);
    ++dropped;
  });
  EXPECT_GT(dropped, 300u);
}

// Silhouettes say little about level parts: what training learnt from mirrored pictures is taken as it is, lids included.
TEST_F(PolishedVase, IsTheSolidThatTrainingLearnt) {
  SurfaceOfRevolution learnt = vase;
  for (Vec2d& p : learnt.profile) p.x *= 1.02;
  const ShapeSet known = as_learnt(learnt);
  const MirrorDepth shape = depth_of(ObjectRole::Mirror, &known);
  size_t count = 0, level = 0;
  RgbdFrame frame = nothing_learnt(views[0]);
  shape.put(0, frame, 0.01);
  each_ray(views[0], [&](int x, int y, const Vec3d& eye, const Vec3d& ray) {
    const float z = frame.zdepth[size_t(y * frame.intrinsics.width + x)];
    if (!(z > 0)) return;
    const auto entry = learnt.intersect({eye, ray});
    ASSERT_TRUE(entry);
    EXPECT_NEAR(double(z), entry->t, 1e-6);
    ++count, level += std::abs(learnt.nearest(eye + entry->t * ray).normal.z) > 0.9;
  });
  EXPECT_GT(count, 500u);
  EXPECT_GT(level, 10u);

  // A ring around it: its upper half near enough to lie on it, its lower half not.
  TriMesh ring;
  constexpr uint32_t kAround = 24;
  const auto at = [&](uint32_t k, size_t corner, double away) {
    const double a = 2 * std::numbers::pi * k / kAround;
    const Vec3d out{std::cos(a), std::sin(a), 0};
    const ShapePoint on = learnt.nearest(vase.origin + Vec3d{0, 0, learnt.profile[corner].y} + learnt.profile[corner].x * out);
    return cast<float>(on.position + away * on.normal);
  };
  for (uint32_t k = 0; k < kAround; ++k) {
    ring.positions.push_back(at(k, 20, 0.002));
    ring.positions.push_back(at(k, 15, 0.02));
    const uint32_t next = (k + 1) % kAround;
    ring.faces.push_back({2 * k, 2 * k + 1, 2 * next});
    ring.faces.push_back({2 * k + 1, 2 * next + 1, 2 * next});
  }
  if (dot(vertex_normals(ring)[0], ring.positions[0] - cast<float>(vase.origin)) < 0)
    for (auto& f : ring.faces) std::swap(f[0], f[1]);
  ring.normals = vertex_normals(ring);
  const TriMesh before = ring;
  EXPECT_EQ(shape.put_vertices(ring, 0.005), kAround);
  for (size_t v = 0; v < ring.positions.size(); ++v) {
    const ShapePoint on = learnt.nearest(cast<double>(ring.positions[v]));
    if (v % 2 == 1) {
      EXPECT_EQ(ring.positions[v], before.positions[v]);
      continue;
    }
    EXPECT_LT(length(on.position - cast<double>(ring.positions[v])), 1e-6);
    EXPECT_GT(dot(on.normal, cast<double>(ring.normals[v])), 0.999999);
  }
}

// A fin that training learnt stands out of the vase: it has its depth where it is in front, and its normals.
TEST_F(PolishedVase, HasWhatTrainingLearntStandsOutOfIt) {
  const SurfaceOfRevolution learnt = vase;
  const View& view = views[0];
  const Vec3d towards = normalized(Vec3d{view.centre_in_world().x, view.centre_in_world().y, 0}),
              side = cross(Vec3d{0, 0, 1}, towards);
  TriMesh fin;  // upright, before the axis, facing the camera
  for (const auto& [u, h] : {std::pair{-0.04, -0.05}, {0.04, -0.05}, {0.04, 0.05}, {-0.04, 0.05}})
    fin.positions.push_back(cast<float>(vase.origin + 0.3 * towards + u * side + Vec3d{0, 0, h}));
  fin.faces = {{0, 1, 2}, {0, 2, 3}};
  ShapeSet known = as_learnt(learnt);
  known.entries.push_back(
      {.shape = TriangleShape(fin), .role = ShapeRole::Mirror, .tolerance = 0.05, .parent = 0, .clear = {}, .object = 1});
  const MirrorDepth shape = depth_of(ObjectRole::Mirror, &known);
  RgbdFrame frame = nothing_learnt(view);
  shape.put(0, frame, 0.01);
  size_t of_fin = 0, of_vase = 0;
  each_ray(view, [&](int x, int y, const Vec3d& eye, const Vec3d& ray) {
    const float z = frame.zdepth[size_t(y * frame.intrinsics.width + x)];
    if (!(z > 0)) return;
    const auto of_mesh = intersect(known.entries[1].shape, {eye, ray});
    const auto entry = learnt.intersect({eye, ray});
    EXPECT_NEAR(double(z), of_mesh ? of_mesh->t : entry->t, 1e-5);
    (of_mesh ? of_fin : of_vase) += 1;
  });
  EXPECT_GT(of_fin, 50u);
  EXPECT_GT(of_vase, 300u);
  TriMesh rough = fin;
  rough.normals.assign(4, normalized(cast<float>(towards + 0.5 * side)));
  EXPECT_EQ(shape.put_vertices(rough, 1e-4), 4u);
  for (const Vec3f& n : rough.normals) EXPECT_GT(dot(n, cast<float>(towards)), 0.9999f);
}

}  // namespace
}  // namespace vitrine
