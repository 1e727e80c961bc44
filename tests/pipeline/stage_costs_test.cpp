// Estimates of all stages, as their programs give them: rows of a table whose values were taken when the formulas were fitted
// (pipeline/README.md, "What a run costs").
#include <set>

#include <gtest/gtest.h>

#include "core/foundation/base/process.h"
#include "core/foundation/base/timer.h"
#include "pipeline/cost_model.h"
#include "tests/pipeline/built_stages.h"

namespace vitrine {
namespace {

struct Row {
  const char *preset, *stage;
  bool masks;  // and a truth with pictures under other lights
  double cpu_s, parallel;
  size_t memory_bytes, disk_bytes;
};

// 36 photos of 4000 x 3000 pixels, 8 threads.
constexpr Row kRows[] = {
    {"preview", "ingest", false, 16.06744576, 0.86, 3237054151, 142496706},
    {"preview", "sfm", false, 94.21495880134127, 0.8129284922029909, 1861380105, 124684618},
    {"preview", "masks", false, 115.2, 0.9, 445576281, 1484340},
    {"preview", "objects", false, 13.396124159999999, 0.8, 188253785, 5242880},
    {"preview", "normals", false, 43.497215999999995, 0.95, 120463766, 7827577},
    {"preview", "optimize", false, 285.26399999999995, 0.92, 620522110, 27262976},
    {"preview", "mesh", false, 12.5, 0.5, 262144000, 9437184},
    {"preview", "refine", false, 0.1, 0.5, 94371840, 104857},
    {"preview", "decompose", false, 21.2, 0.77, 517996544, 6291456},
    {"preview", "evaluate", false, 11.89184, 0.65, 296443340, 8053063},
    {"preview", "export", false, 26.4, 0.7, 692060160, 130233139},
    {"standard", "ingest", false, 26.4736, 0.86, 3237054151, 347892350},
    {"standard", "sfm", false, 213.79095584536503, 0.8538297905239591, 4476370944, 304405807},
    {"standard", "masks", false, 115.2, 0.9, 573948559, 3623878},
    {"standard", "objects", false, 16.660800000000002, 0.8, 188253785, 5242880},
    {"standard", "normals", false, 55.81439999999999, 0.95, 120463766, 7827577},
    {"standard", "optimize", false, 1673.712, 0.92, 1790028283, 52428800},
    {"standard", "mesh", false, 18.125, 0.5, 458752000, 18874368},
    {"standard", "refine", false, 0.1, 0.5, 94371840, 104857},
    {"standard", "decompose", false, 21.2, 0.77, 517996544, 6291456},
    {"standard", "evaluate", false, 41.56736, 0.65, 713914161, 32212254},
    {"standard", "export", false, 43.8, 0.7, 796917760, 234251878},
    {"preview", "ingest", true, 16.06744576, 0.86, 3237054151, 142496706},
    {"preview", "sfm", true, 94.21495880134127, 0.8129284922029909, 1861380105, 124684618},
    {"preview", "masks", true, 9, 0.9, 234090615, 10390384},
    {"preview", "objects", true, 13.396124159999999, 0.8, 188253785, 5242880},
    {"preview", "normals", true, 43.497215999999995, 0.95, 120463766, 7827577},
    {"preview", "optimize", true, 830.778, 0.92, 1023861483, 54525952},
    {"preview", "mesh", true, 28.5, 0.5, 393216000, 9437184},
    {"preview", "refine", true, 73.5376, 0.92, 1075054557, 27262976},
    {"preview", "decompose", true, 21.2, 0.77, 517996544, 6291456},
    {"preview", "evaluate", true, 37.89184, 0.65, 936074700, 8053063},
    {"preview", "export", true, 26.4, 0.7, 692060160, 130233139},
    {"standard", "ingest", true, 26.4736, 0.86, 3237054151, 347892350},
    {"standard", "sfm", true, 213.79095584536503, 0.8538297905239591, 4476370944, 304405807},
    {"standard", "masks", true, 9, 0.9, 405253652, 25367150},
    {"standard", "objects", true, 16.660800000000002, 0.8, 188253785, 5242880},
    {"standard", "normals", true, 55.81439999999999, 0.95, 120463766, 7827577},
    {"standard", "optimize", true, 6237.5232, 0.92, 2953546668, 104857600},
    {"standard", "mesh", true, 34.125, 0.5, 688128000, 18874368},
    {"standard", "refine", true, 1411.4111999999998, 0.92, 3101224001, 52428800},
    {"standard", "decompose", true, 21.2, 0.77, 517996544, 6291456},
    {"standard", "evaluate", true, 67.56736000000001, 0.65, 1353545521, 32212254},
    {"standard", "export", true, 43.8, 0.7, 796917760, 234251878},
};

CostTerms terms_of(const std::string& preset, bool masks) {
  Settings settings(graph());
  SettingsDesc desc{.flags = {{"preset", preset, "--preset"}}};
  const fs::path truth = fs::path(VITRINE_SOURCE_DIR) / "sample_data/tiny_room/truth";
  if (masks) desc.flags.push_back({"input.truth", truth.string(), "--truth"});
  settings.load(desc);
  return cost_terms(settings, {36, 442.4, 0.75, 4000, 0.45, masks}, 8);
}

TEST(StageCosts, AreTheMeasuredSums) {
  std::set<std::string> asked;
  for (const bool masks : {false, true}) {
    const std::vector<CostTerms> terms = {terms_of("preview", masks), terms_of("standard", masks)};
    for (const StageNode& node : graph().nodes) {
      const CostAnswer answer = stage_costs(node, terms);
      ASSERT_EQ(answer.costs.size(), terms.size()) << node.name << ": " << answer.problem;
      for (const Row& row : kRows) {
        if (row.stage != node.name || row.masks != masks) continue;
        SCOPED_TRACE(fmt::format("{} {} {}", row.preset, row.stage, masks));
        const StageCost& cost = answer.costs[std::string_view(row.preset) == "standard"];
        EXPECT_NEAR(cost.cpu_s, row.cpu_s, 1e-9 * row.cpu_s);
        EXPECT_NEAR(cost.parallel, row.parallel, 1e-9);
        EXPECT_NEAR(double(cost.memory_bytes), double(row.memory_bytes), 1);
        EXPECT_NEAR(double(cost.disk_bytes), double(row.disk_bytes), 1);
        asked.insert(node.name);
      }
    }
  }
  EXPECT_EQ(asked.size(), graph().nodes.size()) << "a stage has no rows";
}

TEST(StageCosts, OfAllStagesAreAskedInASecond) {
  const std::vector<CostTerms> terms = {terms_of("standard", false)};
  const double before_s = cpu_seconds(RUSAGE_CHILDREN);  // CPU time: a busy machine must not decide
  for (const StageNode& node : graph().nodes) EXPECT_EQ(stage_costs(node, terms).costs.size(), 1u) << node.name;
  EXPECT_LT(cpu_seconds(RUSAGE_CHILDREN) - before_s, 1.0);
}

// "costs" or the reason why there are none.
std::string told(const StageNode& stage, const CostTerms& terms) {
  const CostAnswer answer = stage_costs(stage, {terms});
  return answer.costs.empty() ? answer.problem : "costs";
}

TEST(StageCosts, AreUnknownWithoutAFormulaAnOptionOrAnAnswer) {
  const StageNode mesh = graph().at("mesh");
  const CostTerms terms = terms_of("preview", false);
  ASSERT_EQ(told(mesh, terms), "costs");
  CostTerms fewer = terms;  // those of a pipeline without the stage that has the option
  fewer.options.erase("mesh.faces");
  EXPECT_EQ(told(mesh, fewer), "its program does not answer --cost");
  StageNode other = mesh;
  other.has_cost = false;
  EXPECT_EQ(told(other, terms), "it declares no estimate");
  other.has_cost = true;
  for (const char* program : {"/bin/echo", "/bin/false"}) {
    other.executable = program;
    EXPECT_EQ(told(other, terms), "its program does not answer --cost") << program;
  }
  other.executable = "/nowhere/vitrine-mesh";
  EXPECT_EQ(told(other, terms), "its program cannot be started");
}

TEST(StageCosts, ThatAreUnknownAreNamedBeforeTheLongStages) {
  Settings settings(graph());
  settings.load({});
  const Resources there{.memory_bytes = size_t(1) << 50, .disk_bytes = size_t(1) << 50};
  const CaptureSize capture{36, 442.4, 0.75, 4000, 0.45, false};
  StageNode gone = graph().at("mesh");
  gone.executable = "/nowhere/vitrine-mesh";
  const auto line = [&](const std::vector<const StageNode*>& stages) {
    return preflight_line(preflight(stages, settings, capture, 8, there), there);
  };
  const StageNode& decompose = graph().at("decompose");
  EXPECT_EQ(line({&decompose}).find("without an estimate"), std::string::npos) << line({&decompose});
  EXPECT_TRUE(
      line({&decompose, &gone}).ends_with("free); without an estimate, and not in the sum: mesh (its program cannot be started)"))
      << line({&decompose, &gone});
  EXPECT_EQ(line({&gone}), "to come: no stage has an estimate of its costs: mesh (its program cannot be started)");
}

TEST(StageCosts, OfAFileThatHoldsNoneAreAnError) {
  const TemporaryFolder folder;
  write_file(folder.path() / "terms.json", "[1]");
  std::string text;
  const ProcessResult r =
      run_process({.arguments = {graph().at("mesh").executable.string(), "--cost", (folder.path() / "terms.json").string()},
                   .on_line = [&](std::string_view line) { text += std::string(line) + "\n"; }});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(text.find("--cost is no list of photos and options"), std::string::npos) << text;
  EXPECT_NE(text.find("try    stages/README.md"), std::string::npos) << text;
}

}  // namespace
}  // namespace vitrine
