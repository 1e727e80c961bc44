// Where the scenes of a comparison come from.
#include "tests/bench/optics/scenes.h"

#include <gtest/gtest.h>

#include "tests/support/error_of.h"

namespace vitrine {
namespace {

void write_scene(const fs::path& folder) {
  make_folders(folder / "photos");
  make_folders(folder / "truth");
  write_file(folder / "photos/a.png", "a photo");
  write_file(folder / "truth/transforms.json", "{}");
}

class OpticsScenes : public testing::Test {
 protected:
  std::vector<OpticsScene> scenes(const std::vector<int>& seeds, const std::vector<fs::path>& places) {
    return optics_scenes(seeds, places, root.path() / "made", [this](int seed, const fs::path& folder) {
      made.push_back(seed);
      write_scene(folder);
      if (seed == broken) throw Error(ErrorKind::Input, "the generator stopped half way");
    });
  }
  TemporaryFolder root;
  std::vector<int> made;
  int broken = -1;
};

TEST_F(OpticsScenes, AreGeneratedOnceAndTakenFromAFolderThatHasThem) {
  write_scene(root.path() / "given/seed_2");
  EXPECT_EQ(scenes({1, 2}, {root.path() / "given"})[1].folder, root.path() / "given/seed_2");
  EXPECT_EQ(made, std::vector{1});
  const auto again = scenes({1, 3}, {});
  EXPECT_EQ(made, (std::vector{1, 3}));
  EXPECT_EQ(again[0].name, "seed_1");
  EXPECT_EQ(again[0].folder, root.path() / "made/seed_1");
}

TEST_F(OpticsScenes, AGeneratorThatStopsLeavesNoScene) {
  broken = 4;
  error_of([&] { scenes({4}, {}); });
  EXPECT_FALSE(fs::exists(root.path() / "made/seed_4"));
  broken = -1;
  scenes({4}, {});
  EXPECT_EQ(made, (std::vector{4, 4}));
}

TEST_F(OpticsScenes, CapturesJoinTheSeedsUnderTheirOwnNames) {
  write_scene(root.path() / "hall");
  const auto found = scenes({1}, {root.path() / "hall/"});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[1].name, "hall");
  EXPECT_EQ(error_of([&] { scenes({}, {root.path() / "hall", root.path() / "hall"}); }).kind(), ErrorKind::Usage);
}

TEST_F(OpticsScenes, WithoutPhotosPosesOrAnySceneAreErrors) {
  write_scene(root.path() / "hall");
  fs::remove(root.path() / "hall/truth/transforms.json");
  const Error e = error_of([&] { scenes({}, {root.path() / "hall"}); });
  EXPECT_EQ(e.detail().code, "BAD_SCENE");
  EXPECT_NE(e.detail().where.find("transforms.json"), std::string::npos);
  EXPECT_EQ(error_of([&] { scenes({}, {}); }).kind(), ErrorKind::Usage);
  EXPECT_EQ(error_of([&] { scenes({}, {root.path() / "nowhere"}); }).kind(), ErrorKind::Input);
}

TEST_F(OpticsScenes, DigestOfTheTrainingSeesPhotosPosesAndMasksAlone) {
  const fs::path scene = root.path() / "hall";
  write_scene(scene);
  const std::string training = digest_of_training_inputs(scene), truth = digest_of_truth(scene);
  make_folders(scene / "truth/normal");
  write_file(scene / "truth/normal/a.exr", "normals");
  EXPECT_EQ(digest_of_training_inputs(scene), training);
  EXPECT_NE(digest_of_truth(scene), truth);
  for (const char* file : {"photos/a.png", "truth/transforms.json", "truth/mask/specular/a.png"}) {
    const std::string before = digest_of_training_inputs(scene);
    make_folders((scene / file).parent_path());
    write_file(scene / file, std::string("other ") + file);
    EXPECT_NE(digest_of_training_inputs(scene), before) << file;
  }
}

}  // namespace
}  // namespace vitrine
