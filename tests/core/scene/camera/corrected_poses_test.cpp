// optimize/poses.json: what is written is read, names that it lacks keep their pose, damage is an error.
#include "core/scene/camera/corrected_poses.h"

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"

namespace vitrine {
namespace {

View camera(const char* name, double turn, const Vec3d& at) {
  return {.name = name, .cam_from_world = {rotation_matrix(normalized(Quatd{1, turn, 0.2, -turn})), at}};
}

TEST(CorrectedPoses, ComeBackAndLeaveOtherViewsAlone) {
  const TemporaryFolder folder;
  std::vector<View> views{camera("a.jpg", 0.1, {1, 2, 3}), camera("b.jpg", 0.2, {4, 5, 6})};
  correct_poses(folder.path(), views);  // no file
  EXPECT_EQ(views[0].cam_from_world.translation, (Vec3d{1, 2, 3}));
  EXPECT_FALSE(has_corrected_poses(folder.path()));
  const View moved = camera("b.jpg", 0.3, {4.5, 5, 6});
  write_corrected_poses(folder.path(), {moved});
  ASSERT_TRUE(has_corrected_poses(folder.path()));
  correct_poses(folder.path(), views);
  EXPECT_EQ(views[0].cam_from_world.translation, (Vec3d{1, 2, 3}));
  EXPECT_EQ(views[1].cam_from_world.translation, moved.cam_from_world.translation);
  for (size_t i = 0; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(views[1].cam_from_world.rotation(i, k), moved.cam_from_world.rotation(i, k), 1e-12);
}

TEST(CorrectedPoses, DamageIsAnError) {
  const TemporaryFolder folder;
  std::vector<View> views{camera("a.jpg", 0.1, {1, 2, 3})};
  for (const char* text : {"{", "{\"cam_from_world\": {\"a.jpg\": {\"rotation\": [2, 0, 0, 0], \"translation\": [0, 0, 0]}}}",
                           "{\"cam_from_world\": {\"a.jpg\": {\"rotation\": [1, 0, 0], \"translation\": [0, 0, 0]}}}",
                           "{\"cam_from_world\": {\"a.jpg\": {\"rotation\": [1, 0, 0, 0]}}}"}) {
    make_folders(folder.path() / "optimize");
    write_file(folder.path() / "optimize" / "poses.json", text);
    EXPECT_THROW(correct_poses(folder.path(), views), Error) << text;
    EXPECT_EQ(views[0].cam_from_world.translation, (Vec3d{1, 2, 3}));
  }
}

}  // namespace
}  // namespace vitrine
