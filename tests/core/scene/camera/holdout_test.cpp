#include "core/scene/camera/holdout.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"

namespace vitrine {
namespace {

TEST(Holdout, PhotosFollowTheRuleOfTheirIndex) {
  std::vector<View> views;
  for (int i = 0; i < 20; ++i) views.push_back({.name = fmt::format("{:02}.jpg", i)});
  for (int every : {0, 1, 3, 8}) {
    const std::vector<uint8_t> heldout = heldout_views(views, {}, every);
    for (size_t i = 0; i < views.size(); ++i) EXPECT_EQ(heldout[i] != 0, is_heldout(i, every)) << i << " " << every;
  }
}

TEST(Holdout, AllViewsOfAPanoramaAreHeldOutOrNone) {
  std::vector<View> views;
  Rigs rigs;
  for (const char* panorama : {"a", "b", "c", "d", "e"})
    for (int v = 0; v < 10; ++v) {
      views.push_back({.name = fmt::format("{}/view_{:02}.jpg", panorama, v)});
      rigs[views.back().name] = std::string(panorama) + ".jpg";
    }
  views.insert(views.begin() + 20, {.name = "between.jpg"});  // numbers: a 0, b 1, this photo 2, c 3
  const std::vector<uint8_t> heldout = heldout_views(views, rigs, 3);
  for (size_t i = 0; i < views.size(); ++i) {
    const char first = views[i].name[0];
    EXPECT_EQ(heldout[i] != 0, first == 'a' || first == 'c') << views[i].name;
  }
}

TEST(Holdout, RigsAreReadAsWrittenAndDamagedOnesRefused) {
  const TemporaryFolder folder;
  EXPECT_TRUE(read_rigs(folder.path()).empty());
  make_folders(folder.path() / "sfm");
  const Rigs rigs{{"a/view_00.jpg", "a.jpg"}, {"a/view_01.jpg", "a.jpg"}};
  write_rigs(folder.path(), rigs);
  EXPECT_EQ(read_rigs(folder.path()), rigs);
  write_file(folder.path() / "sfm/rigs.json", "{\"panorama_of\": {\"a\": 3}}");
  EXPECT_THROW(read_rigs(folder.path()), Error);
}

}  // namespace
}  // namespace vitrine
