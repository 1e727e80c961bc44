// ct/page.html of a phantom in headless Chromium, from file://: densities in slices and in the picture of the volume, the
// transfer function and its file.
#include "core/foundation/base/file.h"
#include "stages/tomography/page_volume.h"
#include "tests/pages/in_chromium.h"
#include "tests/stages/tomography/phantoms.h"

namespace vitrine {
namespace {

using nlohmann::json;

// A body with a dense ball near one corner and a hole: no two axes and no two sides are alike. The origin is negative.
const test::Phantom kBody = {
    {{9, 7, 5}, {1, -1, -2}, 15, .3}, {{2, 2, 2}, {5, 2, -1}, 0, 1}, {{2.2, 1.8, 2}, {-4, -2, -3}, 0, -.3}};
constexpr double kRadius = 10;

VoxelGrid<float> body() {
  VoxelGrid<float> grid = test::truth(kBody, {.origin = {-11, -10.4, -8}, .cell = .4, .size = {55, 52, 34}, .values = {}});
  grid.each([&](int x, int y, int z) {
    const Vec3d p = grid.centre(x, y, z);
    if (std::hypot(p.x, p.y) > kRadius) grid.values[grid.index(x, y, z)] = 0;
  });
  return grid;
}

class VolumePage : public InChromium {
 protected:
  void SetUp() override {
    InChromium::SetUp();
    if (HasFatalFailure() || IsSkipped()) return;
    const fs::path page = folder_.path() / "page.html", out = pictures("volume");
    write_volume_page(page, read_file(empty_page_path("tomography")), body(),
                      {.unit = "mm", .iso = .15, .seen = SeenCylinder{kRadius, 7}});
    json places = json::array();
    for (const Vec3d& p : places_) places.push_back({p.x, p.y, p.z});
    r = answer(run_script({"volume_page.mjs", page.string(), places.dump(), out.string()}));
    ASSERT_FALSE(r.empty());
  }
  // Body, ball, hole, air, outside of the scan.
  const std::vector<Vec3d> places_ = {{1, -4, -2}, {5, 2, -1}, {-4, -2, -3}, {-2, 2, 4}, {9, 9, 0}};
  TemporaryFolder folder_;
  json r;
};

TEST_F(VolumePage, ShowsDensitiesWhereTheyAre) {
  EXPECT_TRUE(r["messages"].empty()) << r["messages"];
  const double black = r["window"][0], white = r["window"][1];
  EXPECT_NEAR(white, 1.3, 1e-6) << "all densities";
  for (size_t i = 0; i < 4; ++i) {
    const double truth = test::density(kBody, places_[i]);
    EXPECT_NEAR(r["densities"][i].get<double>(), truth, 1.3 / kPageSteps);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(r["greys"][i][axis].get<double>(), (truth - black) / (white - black), 0.02)
          << "place " << i << ", slice " << axis;
  }
  EXPECT_TRUE(r["densities"][4].is_null());
  EXPECT_GT(r["greys"][4][2].get<double>(), 0.1) << "hatched, not the black of air";
  EXPECT_EQ(r["without"]["grey"], r["greys"][0]) << "slices need no WebGL";
  EXPECT_NE(r["without"]["sentence"].get<std::string>().find("no WebGL2"), std::string::npos);

  // Crosshair, slices and grey values follow the hand.
  const double cell = .4;
  EXPECT_NEAR(r["clicked"][0].get<double>(), 5, cell / 4);
  EXPECT_NEAR(r["clicked"][1].get<double>(), 2, cell / 4);
  EXPECT_NEAR(r["wheeled"][2].get<double>() - r["clicked"][2].get<double>(), 3 * cell, cell) << "120 pixels of the wheel";
  EXPECT_NEAR(r["keyed"][0].get<double>() - r["wheeled"][0].get<double>(), -cell, cell);
  EXPECT_GT(r["dragged"][1].get<double>() - r["dragged"][0].get<double>(), white - black);
  EXPECT_GT(r["dragged"][1].get<double>() + r["dragged"][0].get<double>(), white + black) << "down is darker";
  EXPECT_EQ(r["reset"], r["window"]);
  EXPECT_NE(r["readout"][0].get<std::string>().find("density 0.300 mm\u207b\u00b9"), std::string::npos) << r["readout"];
  EXPECT_NE(r["readout"][1].get<std::string>().find("not shown by the scan"), std::string::npos) << r["readout"];
  EXPECT_NEAR(std::stod(r["measured"].get<std::string>()), std::hypot(4, 6), cell / 2) << r["measured"];
  EXPECT_LE(r["narrow"].get<int>(), 390);
  EXPECT_EQ(r["alone"], json::array({"pane_volume"}));

  // The picture of the volume: where the ball is, at its surface, and what changes it.
  const json& p = r["pictures"];
  EXPECT_GT(p["inside"].get<int>(), 60) << "the ball, where it is projected";
  double far = 0;
  for (int c = 0; c < 3; ++c) far += std::pow(r["hit"][c].get<double>() - (&places_[1].x)[c], 2);
  EXPECT_NEAR(std::sqrt(far), 2, 1.5 * cell) << "a click finds the surface of the ball";
  EXPECT_GT(p["bright"].get<double>(), 0.05);
  EXPECT_EQ(p["same"], 0);
  EXPECT_EQ(p["bands"], 0) << "what slow browsers draw when the picture rests";
  EXPECT_EQ(p["surface"], 0) << "the first start again";
  EXPECT_EQ(p["uncut"], 0);
  for (const char* change : {"dense", "x-ray", "soft", "cut", "turned", "moved", "edited"})
    EXPECT_GT(p[change].get<double>(), 0.5) << change;

  // The transfer function: points come, move and go; its file; files that are none.
  EXPECT_EQ(r["points"], json::array({4, 5, 4, 3}));
  EXPECT_GT(r["moved"][1]["density"].get<double>(), r["moved"][0]["density"].get<double>());
  EXPECT_LT(r["moved"][1]["opacity"].get<double>(), r["moved"][0]["opacity"].get<double>());
  EXPECT_EQ(r["saved"]["format"], "vitrine transfer function 1");
  EXPECT_EQ(r["saved"]["density_unit"], "1/mm");
  ASSERT_EQ(r["edited"].size(), 5u);
  for (const char* again : {"opened", "dropped", "other_unit"}) {
    ASSERT_EQ(r[again].size(), 5u) << again;
    for (size_t i = 0; i < 5; ++i) {
      EXPECT_EQ(r[again][i]["color"], r["edited"][i]["color"]) << again;
      EXPECT_NEAR(r[again][i]["density"].get<double>(), r["edited"][i]["density"].get<double>(), 1e-6) << again;
      EXPECT_NEAR(r[again][i]["opacity"].get<double>(), r["edited"][i]["opacity"].get<double>(), 1e-4) << again;
    }
  }
  EXPECT_EQ(r["kept"], true) << "a refused file changes nothing";
  const std::pair<const char*, const char*> refusals[] = {
      {"cut.json", "it is not JSON"},         {"scene.json", "it is not a"},
      {"list.json", "it is not a"},           {"null.json", "it is not a"},
      {"unit.json", "density_unit"},          {"one.json", "2 to 64 points"},
      {"word.json", "point 1: density must"}, {"many.json", "point 1: opacity must"},
      {"colour.json", "point 1: color must"}, {"large.json", "too large"},
  };
  for (const auto& [file, why] : refusals) {
    const std::string sentence = r["refused"][file];
    EXPECT_NE(sentence.find(why), std::string::npos) << sentence;
    EXPECT_TRUE(sentence.ends_with("Nothing was changed.")) << sentence;
  }
}

}  // namespace
}  // namespace vitrine
