// Means over seeds and scenes, spread, regions that some scenes lack; the table and the file.
#include "tests/bench/optics/summary.h"

#include <gtest/gtest.h>

#include "tests/bench/optics/record.h"

namespace vitrine {
namespace {

// Two arms, three scenes, two seeds: `full` gains 1, 2 and 6 dB in the whole picture; two scenes have glass.
std::vector<OpticsResult> three_scenes() {
  std::vector<OpticsResult> results;
  const double gains[] = {1, 2, 6};
  for (int s = 0; s < 3; ++s)
    for (const int seed : {1, 2}) {
      const double noise = seed == 1 ? -0.5 : 0.5;
      Figures diffuse{{"all", 20.0 + s + seed}, {"normals", 10.0}},
          full{{"all", 20.0 + s + seed + gains[s] + noise}, {"normals", 8.0 + noise + s}};
      if (s < 2)
        for (const char* glass : {"glass", "glass_pooled"}) diffuse[glass] = 15, full[glass] = 15 - noise - s;
      results.push_back({"seed_" + std::to_string(s), "diffuse", seed, diffuse});
      results.push_back({"seed_" + std::to_string(s), "full", seed, full});
    }
  return results;
}

TEST(OpticsSummary, DifferencesAreMeansOverSeedsThenOverScenes) {
  const OpticsSummary summary = summary_of(three_scenes(), "diffuse");
  ASSERT_EQ(summary.gains.size(), 1u);
  const Gain all = summary.gains[0].gains.at("all");
  EXPECT_NEAR(all.mean, 3, 1e-12);
  EXPECT_NEAR(all.deviation, std::sqrt(7.0), 1e-12);  // of 1, 2, 6 around 3, divided by 2
  EXPECT_NEAR(all.worst, 1, 1e-12);
  EXPECT_EQ(all.scenes, 3);
  EXPECT_TRUE(all.counts);
  EXPECT_NEAR(summary.scenes[2].arms[1].figures.at("all"), 29.5, 1e-12);
}

TEST(OpticsSummary, ARegionCountsInTheScenesThatHaveIt) {
  const OpticsSummary summary = summary_of(three_scenes(), "diffuse");
  const Gain glass = summary.gains[0].gains.at("glass");
  EXPECT_EQ(glass.scenes, 2);
  EXPECT_NEAR(glass.mean, -0.5, 1e-12);
  EXPECT_NEAR(glass.worst, -1, 1e-12);
  EXPECT_FALSE(glass.counts);
  EXPECT_FALSE(summary.gains[0].gains.contains("mirror"));
  EXPECT_EQ(summary.scenes[0].kinds, "glass");
  EXPECT_EQ(summary.scenes[2].kinds, "none");
}

TEST(OpticsSummary, EveryObjectOfEverySceneHasARow) {
  auto results = three_scenes();
  const std::string object = std::string(kObjectFigure) + "mirror ball";
  for (OpticsResult& r : results)
    if (r.scene == "seed_1") r.figures[object] = r.arm == "full" ? 21.5 : 20;
  const std::string text = summary_text(summary_of(results, "diffuse"));
  EXPECT_NE(text.find("seed_1  mirror ball    20.00  +1.50"), std::string::npos) << text;
  EXPECT_EQ(text.find("seed_0  mirror ball"), std::string::npos);
  EXPECT_EQ(summary_text(summary_of(three_scenes(), "diffuse")).find("each object"), std::string::npos);
}

TEST(OpticsSummary, OfAnglesTheLargestIsTheWorstAndLessIsAGain) {
  auto results = three_scenes();
  Gain normals = summary_of(results, "diffuse").gains[0].gains.at("normals");
  EXPECT_NEAR(normals.mean, -1, 1e-12);  // of -2, -1, 0
  EXPECT_NEAR(normals.worst, 0, 1e-12);
  EXPECT_FALSE(normals.counts);  // as large as the deviation
  for (OpticsResult& r : results)
    if (r.arm == "full") r.figures["normals"] -= 1;
  EXPECT_TRUE(summary_of(results, "diffuse").gains[0].gains.at("normals").counts);
}

TEST(OpticsSummary, SeedsThatOneArmLacksDoNotShiftTheDifference) {
  auto results = three_scenes();
  std::erase_if(results, [](const OpticsResult& r) { return r.scene == "seed_0" && r.arm == "full" && r.training_seed == 2; });
  const Gain all = summary_of(results, "diffuse").gains[0].gains.at("all");
  EXPECT_NEAR(all.mean, (0.5 + 2 + 6) / 3, 1e-12);  // of seed_0 the first seed alone
}

TEST(OpticsSummary, OneSceneHasNoSpreadAndDecidesNothing) {
  auto results = three_scenes();
  std::erase_if(results, [](const OpticsResult& r) { return r.scene != "seed_2"; });
  const Gain all = summary_of(results, "diffuse").gains[0].gains.at("all");
  EXPECT_NEAR(all.mean, 6, 1e-12);
  EXPECT_EQ(all.deviation, 0);
  EXPECT_FALSE(all.counts);
}

TEST(OpticsSummary, TableAlignsAndShowsDashesForWhatASceneLacks) {
  const std::string text = summary_text(summary_of(three_scenes(), "diffuse"));
  EXPECT_NE(text.find("seed_2 (none)    diffuse  23.50      -     10.0\n"), std::string::npos) << text;
  EXPECT_NE(text.find("full  mean           +3.00  -0.50     -1.0\n"), std::string::npos) << text;
  EXPECT_NE(text.find("      counts           yes     no       no\n"), std::string::npos) << text;
}

TEST(OpticsRecord, HoldsLabelsFiguresAndGains) {
  const OpticsLabel label{.commit = std::string(40, 'a'),
                          .cpu = "a processor",
                          .date = "2031-02-03",
                          .cores = 2,
                          .seeds = {1, 2},
                          .training_seeds = {1},
                          .arms = {{"diffuse", {{"optimize.layers", "diffuse"}}}},
                          .steps = 1000,
                          .surfels = 30000,
                          .max_side = 320};
  const auto record = nlohmann::json::parse(optics_record(label, summary_of(three_scenes(), "diffuse")));
  EXPECT_EQ(record.at("format"), "vitrine-optics 1");
  EXPECT_EQ(record.at("commit"), label.commit);
  EXPECT_EQ(record.at("settings").at("steps"), 1000);
  EXPECT_EQ(record.at("seeds"), nlohmann::json({1, 2}));
  EXPECT_EQ(record.at("scenes").at(2).at("arms").at("full").at("all"), 29.5);
  EXPECT_EQ(record.at("gains").at(0).at("figures").at("all").at("scenes"), 3);
  EXPECT_EQ(record.at("gains").at(0).at("figures").at("all").at("deviation"), 2.64575);
}

TEST(OpticsFigures, TakeReflectiveForMirrorsOnlyWhereNoCoatIsKnown) {
  const auto metrics = nlohmann::json::parse(
      R"({"heldout": {"psnr": 21.5}, "regions": {"reflective": {"psnr": 17}, "masks": "truth"},
          "truth": {"regions": {"reflective": {"normal_mae_deg": 30}}}})");
  EXPECT_EQ(figures_of(metrics), (Figures{{"all", 21.5}, {"mirror", 17}, {"normals_mirror", 30}}));
  auto coats = metrics;
  coats["regions"]["coated"]["psnr"] = 19;
  EXPECT_EQ(figures_of(coats), (Figures{{"all", 21.5}, {"coated", 19}}));
}

TEST(OpticsFigures, HaveThePooledErrorOfEveryObject) {
  const auto metrics = nlohmann::json::parse(
      R"({"objects": [{"id": 3, "name": "ball", "role": "mirror", "psnr": 20, "pooled_psnr": 19.5}, {"id": 4, "name": "tray"}]})");
  EXPECT_EQ(figures_of(metrics), (Figures{{"object: mirror ball", 19.5}}));
}

}  // namespace
}  // namespace vitrine
