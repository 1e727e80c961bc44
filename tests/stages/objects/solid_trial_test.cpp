// A ball of solid glass is told from a hollow one by what photos show in it.
#include "stages/objects/roles.h"

#include <gtest/gtest.h>

#include "core/foundation/base/parallel.h"
#include "core/scene/objects/object_set.h"
#include "stages/objects/objects.h"
#include "tests/core/render/model/snell_ball.h"
#include "tests/core/observe/stereo/silhouettes_of_rays.h"
#include "tests/core/observe/stereo/textured_room.h"
#include "tests/stages/objects/written_capture.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

constexpr double kGlassBall = 0.22, kHalfRoom = 1.5, kFloorAt = -0.8;
constexpr int kCameras = 24;

// Four walls, a floor and a ceiling, all painted.
Vec3f painted_room(const Vec3d& from, const Vec3d& d) {
  double t = 1e9;
  size_t axis = 0;
  for (size_t a = 0; a < 3; ++a) {
    const double end = d[a] > 0 ? kHalfRoom : a == 2 ? kFloorAt : -kHalfRoom, at = (end - from[a]) / d[a];
    if (std::abs(d[a]) > 1e-9 && at < t) t = at, axis = a;
  }
  const Vec3d p = from + t * d;
  const double u = p[(axis + 1) % 3], v = p[(axis + 2) % 3];
  const uint64_t wall = 2 * axis + (d[axis] > 0);
  Vec3f colour;
  for (size_t c = 0; c < 3; ++c) colour[c] = 0.7f * float(textured_room::texture(0.5 * u, 0.5 * v, 20 + 3 * wall + c));
  return colour;
}

struct GlassBallCapture {
  TemporaryFolder folder;
  explicit GlassBallCapture(bool solid) {
    const auto meets = [](const Vec3d& eye, const Vec3d& d) { return meets_ball({}, kGlassBall, eye, d); };
    const auto marks = silhouettes_of_rays(kCameras, 2 * std::numbers::pi, meets);
    const auto radiance = [&](const Vec3d& eye, const Vec3d& d) {
      const auto way = test::through_ball(eye, d, {}, kGlassBall, 1.5);
      return (way ? 0.92f : 1.f) * (way && solid ? painted_room(way->exit, way->direction) : painted_room(eye, d));
    };
    const auto photo = [&](const View& view) { return test::photo_of(view, radiance); };
    const auto views = test::write_sfm(folder.path() / "sfm", marks, photo);
    test::write_masks(folder.path() / "masks", MaskClass::Transparent, views, marks);
  }
  ObjectSet found() const {
    test::RecordingContext context({{"sfm", folder.path() / "sfm"}, {"masks", folder.path() / "masks"}});
    run_objects({.hull_voxels = 48}, context);
    return read_objects(context.output());
  }
};

TEST(SolidTrial, ASolidBallShowsTheRoomUpsideDownAndAHollowOneDoesNot) {
  for (const bool solid : {true, false}) {
    SCOPED_TRACE(solid);
    const GlassBallCapture capture(solid);
    set_thread_limit(3);
    const ObjectSet set = capture.found();
    set_thread_limit(solid ? 1 : 0);
    if (solid) {
      EXPECT_EQ(set.objects.at(0).evidence.bent, capture.found().objects.at(0).evidence.bent);
    }
    set_thread_limit(0);
    ASSERT_EQ(set.objects.size(), 1u);
    EXPECT_EQ(set.objects[0].role, solid ? ObjectRole::SolidGlass : ObjectRole::ThinGlass);
    EXPECT_EQ(set.objects[0].name, "glass-1");
    ASSERT_TRUE(set.objects[0].evidence.bent);
    const double right = *(solid ? set.objects[0].evidence.bent : set.objects[0].evidence.straight),
                 wrong = *(solid ? set.objects[0].evidence.straight : set.objects[0].evidence.bent);
    EXPECT_GT(right, 0.5);
    EXPECT_LT(wrong, 0.15);
    EXPECT_EQ(set.shapes.entries.at(0).role, solid ? ShapeRole::Solid : ShapeRole::Sheet);
  }
}

}  // namespace
}  // namespace vitrine
