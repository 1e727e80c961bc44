// Paint under a clear coat is told from metal by how it changes with the view.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/json.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/math/rigid.h"
#include "core/scene/objects/object_set.h"
#include "stages/objects/objects.h"
#include "stages/objects/roles.h"
#include "tests/core/observe/stereo/silhouettes_of_rays.h"
#include "tests/stages/objects/written_capture.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using test::RecordingContext;

constexpr double kRadius = 0.2;
const Vec3d kLeft{-0.35, 0, 0}, kRight{0.3, 0, 0};

struct Seen {
  double t = 1e9;
  Vec3d normal{};
};

Seen ball_hit(const Vec3d& centre, const Vec3d& eye, const Vec3d& d) {
  const double along = dot(centre - eye, d), off = length(centre - eye - along * d);
  if (off >= kRadius) return {};
  const double t = along - std::sqrt(kRadius * kRadius - off * off);
  return {t, normalized(eye + t * d - centre)};
}

// Three bars at right angles: neither a box nor a surface of revolution.
const Box kBars[]{{Mat3d::identity(), {-0.25, -0.08, -0.25}, {-0.1, 0.07, 0.2}},
                  {Mat3d::identity(), {-0.25, -0.08, -0.25}, {0.25, 0.07, -0.1}},
                  {Mat3d::identity(), {0.1, -0.08, -0.25}, {0.25, 0.35, -0.1}}};

Seen bars_hit(const Vec3d& eye, const Vec3d& d) {
  Seen out;
  for (const Box& box : kBars)
    if (const auto hit = box.intersect({eye, d}); hit && hit->t < out.t) out = {hit->t, hit->normal};
  return out;
}

// The room: bright and dark patches, some of them a lamp.
double room(const Vec3d& d) {
  const double azimuth = std::atan2(d.y, d.x);
  const double patches = std::sin(3 * azimuth + 0.4) * std::sin(4 * d.z + 0.3);
  return patches > 0.75 ? 1.5 : patches > 0 ? 0.6 : 0.05;
}

double painted(const Vec3d& p) { return 0.25 + 0.2 * std::sin(20 * p.x) * std::sin(17 * p.y + 11 * p.z); }

double glazed(const Seen& seen, const Vec3d& eye, const Vec3d& d) {
  const double cosine = -dot(d, seen.normal), fresnel = 0.04 + 0.96 * std::pow(1 - cosine, 5);
  return (1 - fresnel) * painted(eye + seen.t * d) + fresnel * room(d + 2 * cosine * seen.normal);
}

double polished(const Seen& seen, const Vec3d& d) { return 0.85 * room(d - 2 * dot(d, seen.normal) * seen.normal); }

struct GlossyScene {
  TemporaryFolder folder;
  template <class Meets, class Radiance>
  GlossyScene(const Meets& meets, const Radiance& radiance) {
    const auto marks = silhouettes_of_rays(24, 2 * std::numbers::pi, meets);
    const auto views =
        test::write_sfm(folder.path() / "sfm", marks, [&](const View& view) { return test::photo_of(view, radiance); });
    test::write_masks(folder.path() / "masks", MaskClass::Specular, views, marks);
  }
  std::unique_ptr<RecordingContext> run(double coat_below = 0.25) const {
    auto context = std::make_unique<RecordingContext>(
        std::map<std::string, fs::path>{{"sfm", folder.path() / "sfm"}, {"masks", folder.path() / "masks"}});
    run_objects({.hull_voxels = 64, .coat_below = coat_below}, *context);
    return context;
  }
};

const GlossyScene& two_balls() {
  static const GlossyScene scene(
      [](const Vec3d& eye, const Vec3d& d) { return meets_ball(kLeft, kRadius, eye, d) || meets_ball(kRight, kRadius, eye, d); },
      [](const Vec3d& eye, const Vec3d& d) {
        const Seen left = ball_hit(kLeft, eye, d), right = ball_hit(kRight, eye, d);
        return left.t < right.t ? glazed(left, eye, d) : right.t < 1e9 ? polished(right, d) : room(d);
      });
  return scene;
}

TEST(Coats, AGlazedBallKeepsItsPaintAndAPolishedOneMirrors) {
  const auto context = two_balls().run();
  const ObjectSet set = read_objects(context->output());
  size_t balls = 0;
  for (size_t i = 0; i < set.shapes.entries.size(); ++i) {
    const auto* ball = std::get_if<SurfaceOfRevolution>(&set.shapes.entries[i].shape);
    if (!ball) continue;
    ++balls;
    const bool glazed_one = ball->origin.x < 0;
    EXPECT_EQ(set.shapes.entries[i].role, glazed_one ? ShapeRole::Coat : ShapeRole::Mirror);
    EXPECT_TRUE(set.shapes.entries[i].exact);
    const Object& object = *set.of_shape(i);
    EXPECT_EQ(object.role, glazed_one ? ObjectRole::Coat : ObjectRole::Mirror);
    EXPECT_EQ(object.name, glazed_one ? "coat-1" : "mirror-1");
    const double figure = object.evidence.view_dependence.value();
    EXPECT_TRUE(glazed_one ? figure < 0.2 : figure > 0.4) << figure;
  }
  EXPECT_EQ(balls, 2u);
  EXPECT_EQ(set.objects.size(), 2u);
  EXPECT_EQ(context->metrics.at("coats"), 1);
  const auto none = two_balls().run(0);
  EXPECT_FALSE(read_objects(none->output()).shapes.has(ShapeRole::Coat));
}

TEST(Coats, AreTheSameForAnyNumberOfThreads) {
  const auto text = [](int threads) {
    set_thread_limit(threads);
    const auto context = two_balls().run();
    set_thread_limit(0);
    return read_file(context->output() / "objects/objects.json");
  };
  EXPECT_EQ(text(1), text(4));
}

TEST(Coats, FreeFormsAreToldApartToo) {
  const auto meets = [](const Vec3d& eye, const Vec3d& d) { return bars_hit(eye, d).t < 1e9; };
  for (const bool metal : {false, true}) {
    const GlossyScene scene(meets, [&](const Vec3d& eye, const Vec3d& d) {
      const Seen seen = bars_hit(eye, d);
      return seen.t > 1e8 ? room(d) : metal ? polished(seen, d) : glazed(seen, eye, d);
    });
    const ObjectSet set = read_objects(scene.run()->output());
    ASSERT_EQ(set.objects.size(), 1u);
    EXPECT_EQ(set.objects[0].role, metal ? ObjectRole::Mirror : ObjectRole::Coat);
    ASSERT_EQ(set.shapes.entries.size(), 1u);
    EXPECT_TRUE(std::holds_alternative<TriangleShape>(set.shapes.entries[0].shape));
  }
}

// Too few photos see it to measure: metal if its shape is known, else paint, whose surfels stay.
TEST(Roles, WithoutAFigureTheShapeDecides) {
  EXPECT_EQ(object_role_of(MaskClass::Specular, {}, true, 0.3), ObjectRole::Mirror);
  EXPECT_EQ(object_role_of(MaskClass::Specular, {}, false, 0.3), ObjectRole::Coat);
  EXPECT_EQ(object_role_of(MaskClass::Specular, 0.31, false, 0.3), ObjectRole::Mirror);
  EXPECT_EQ(object_role_of(MaskClass::Specular, 0.29, true, 0.3), ObjectRole::Coat);
  EXPECT_EQ(object_role_of(MaskClass::Transparent, 0.29, true, 0.3), ObjectRole::ThinGlass);
}

}  // namespace
}  // namespace vitrine
