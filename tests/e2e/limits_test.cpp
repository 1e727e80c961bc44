// Runs that come to a limit, of memory or of numbers: what is told, and that the next run is served neither too little nor ruins.
#include "tests/e2e/tiny_room.h"

namespace vitrine {
namespace {

const std::vector<std::string> kTraining = {"--to",  "optimize",
                                            "--set", "normals.source=none",
                                            "--set", "optimize.iterations=30",
                                            "--set", "optimize.max_gaussians=6000"};

std::vector<std::string> training(const std::vector<std::string>& more) {
  std::vector<std::string> words = kTraining;
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST_F(TinyRoom, ASceneMadeWithLittleMemoryIsNotServedToARunWithout) {
  const std::vector<std::string> little = training({"--max-memory", "158MiB"});
  const Outcome limited = room(true_poses(), little);
  ASSERT_EQ(limited.exit, 0) << limited.text;
  EXPECT_TRUE(limited.said("warning: the memory limit of 158 MiB allows ")) << limited.text;
  EXPECT_TRUE(limited.said(" surfels instead of 6000"));
  EXPECT_EQ(room(true_poses(), little).exit, 0);
  EXPECT_EQ(states().at("optimize"), "cached");
  const Outcome planned = room(true_poses(), training({"--dry-run"}));
  EXPECT_TRUE(planned.said("run optimize because option max_gaussians ")) << planned.text;
  ASSERT_EQ(room(true_poses(), kTraining).exit, 0);
  EXPECT_EQ(states(), (States{{"ingest", "cached"},
                              {"sfm", "cached"},
                              {"masks", "cached"},
                              {"objects", "cached"},
                              {"normals", "cached"},
                              {"optimize", "ran"}}));
  // A limit that is no hindrance is no other run.
  ASSERT_EQ(room(true_poses(), training({"--max-memory", "4GiB"})).exit, 0);
  EXPECT_EQ(states().at("optimize"), "cached");
}

TEST_F(TinyRoom, TrainingThatDivergesKeepsItsCheckpointAndAllBeforeIt) {
  ASSERT_EQ(room(true_poses(), kTraining).exit, 0);
  const auto sane = digests();
  fs::remove_all(out());
  const std::vector<std::string> wild = training({"--set", "optimize.iterations=150", "--set", "optimize.rate_factor=20", "--set",
                                                  "optimize.loss.opacity=1000", "--set", "optimize.checkpoint_every=1"});
  const Outcome first = room(true_poses(), wild);  // opacities fall until no surfel is left
  EXPECT_EQ(first.exit, 10) << first.text;
  EXPECT_TRUE(first.has("optimize   FAILED  GRADIENTS_NOT_FINITE")) << first.text;
  EXPECT_TRUE(first.has("\n  try    lower the rates (--set optimize.rate_factor=")) << first.text;
  EXPECT_FALSE(fs::exists(out() / "gaussians")) << "nothing looks finished";
  // The same again takes up the last good checkpoint, and comes to the same end.
  const Outcome again = room(true_poses(), wild);
  EXPECT_EQ(again.exit, 10);
  EXPECT_TRUE(again.said("continues at step")) << again.text;
  const auto message = [](const Outcome& o) { return o.text.substr(o.text.find("error: ")); };
  EXPECT_EQ(message(again), message(first));
  // Sane rates: what was finished is used, training begins anew, and nothing of the wild run is left in the result.
  ASSERT_EQ(room(true_poses(), kTraining).exit, 0);
  EXPECT_EQ(states(), (States{{"ingest", "cached"},
                              {"sfm", "cached"},
                              {"masks", "cached"},
                              {"objects", "cached"},
                              {"normals", "cached"},
                              {"optimize", "ran"}}));
  EXPECT_EQ(digests(), sane);
}

TEST_F(TinyRoom, TrainedInBlocksItIsOneSceneForAllStages) {
  const std::vector<std::string> blocks{"--blocks", "2", "--set", "optimize.holdout_every=12"};
  const std::string model = write_true_model();
  const Outcome o = room(model, blocks);
  ASSERT_EQ(o.exit, 0) << o.text;
  EXPECT_EQ(json("optimize/report.json")["blocks"].size(), 2u);
  EXPECT_TRUE(fs::exists(out() / "eval/metrics.json"));
  EXPECT_TRUE(fs::exists(out() / "mesh/mesh.ply"));
  EXPECT_TRUE(fs::exists(out() / "export/formats.json"));
  EXPECT_EQ(room(model, blocks).exit, 0);
  EXPECT_EQ(states().at("optimize"), "cached");
}

TEST_F(TinyRoom, MoreBlocksThanThePhotosAllowAreRefused) {
  EXPECT_EQ(room(true_poses(), training({"--blocks", "0"})).exit, 2);
  const Outcome many = room(write_true_model(), training({"--blocks", "9", "--set", "optimize.holdout_every=0"}));
  EXPECT_EQ(many.exit, 2) << many.text;
  EXPECT_TRUE(many.said("9 blocks are too many for 12 photos")) << many.text;
}

}  // namespace
}  // namespace vitrine
