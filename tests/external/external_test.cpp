// What other people's programs say about exported files: the Khronos validator, three.js in headless Chromium, splat-transform.
// Label `external`: needs node, npm, chromium and the network (npm install, once per build folder).
#include <algorithm>

#include <gtest/gtest.h>

#include "core/base/json.h"
#include "stages/export/export.h"
#include "tests/export/pane_scene.h"
#include "tests/external/programs.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using nlohmann::json;

class External : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    installed_ = install();
    const TemporaryFolder root;
    test::PaneScene().write(root.path());
    context_ = new test::RecordingContext(
        {{"sfm", root.path() / "sfm"}, {"optimize", root.path() / "optimize"}, {"mesh", root.path() / "mesh"}});
    run_export({.formats = {"mesh-glb", "ply-3dgs"}, .texture_size = 512}, *context_);
  }
  static void TearDownTestSuite() { delete context_; }
  void SetUp() override { ASSERT_EQ(installed_.code, 0) << "npm install: " << installed_.out; }

  static std::string exported(const char* file) { return (context_->output() / "export" / file).string(); }

  static inline Said installed_;
  static inline test::RecordingContext* context_ = nullptr;
};

TEST_F(External, TheKhronosValidatorFindsNoErrorInTheGlb) {
  const Said said = run_external({"node", "validate.mjs", exported("mesh.glb")});
  EXPECT_EQ(said.code, 0) << said.out;
  const json report = json::parse(said.out.substr(0, said.out.find('\n')));
  EXPECT_EQ(report["errors"], 0);
  EXPECT_EQ(report["warnings"], 0) << said.out;
}

TEST_F(External, ThreeJsShowsTheFloorThroughThePane) {
  const Said said = run_external({"node", "render.mjs", exported("mesh.glb"), "pane.png", "-20", "15"});
  ASSERT_EQ(said.code, 0) << said.out;
  const json r = json::parse(said.out.substr(said.out.find('{')));
  EXPECT_GT(r["glass"], 0.03) << "the pane is in the picture";
  EXPECT_GT(r["inside"], 20) << "its pixels change when it stops transmitting";  // 73 on the cabinet
  EXPECT_LT(r["outside"], 0.5) << "and no others do";
  EXPECT_GT(r["spread"][0], 2 * r["spread"][1].get<double>()) << "tiles are seen through it, not a plain sheet";
}

TEST_F(External, SplatTransformReadsThe3dgsPly) {
  const Said said = run_external({"npx", "splat-transform", "-w", exported("gaussians_3dgs.ply"), "splats.csv"});
  ASSERT_EQ(said.code, 0) << said.out;
  const std::string csv = read_file(fs::path(EXTERNAL_DIR) / "splats.csv");
  const size_t lines = size_t(std::count(csv.begin(), csv.end(), '\n'));
  const size_t surfels = test::PaneScene().diffuse.size();
  EXPECT_GE(lines, surfels);
  EXPECT_LE(lines, surfels + 1);
  EXPECT_NE(csv.substr(0, csv.find('\n')).find("f_dc_0"), std::string::npos);
}

}  // namespace
}  // namespace vitrine
