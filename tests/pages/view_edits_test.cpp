// Edits made in the page of `vitrine view`, in headless Chromium: what the page says that they select against what `vitrine edit`
// finds by the file that the page saved.
#include <gtest/gtest.h>

#include "core/foundation/base/json.h"
#include "core/scene/camera/projection.h"
#include "stages/edit/edit.h"
#include "stages/page_text.h"
#include "stages/view/view.h"
#include "tests/pages/in_chromium.h"
#include "tests/stages/edit/two_balls.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using nlohmann::json;

using ViewEdits = InChromium;

TEST_F(ViewEdits, AreWhatVitrineEditFindsByTheSavedFile) {
  const test::TwoBalls balls;
  test::RecordingContext context(balls.artifacts());
  write_view(read_file(fs::path(VITRINE_BIN_DIR) / empty_page_path("view").filename()), {}, context);
  json marks = json::array();
  for (const size_t photo : {6, 2}) {  // at -y and +y: the second ball stands beside the first
    const auto at = image_point(balls.kB, balls.capture.views[photo]);
    ASSERT_TRUE(at);
    marks.push_back({photo, at->x, at->y, 10});
  }
  const json point{balls.kB.x + balls.kRadiusB, balls.kB.y, balls.kB.z}, box{-0.5, -0.3, -0.05, 0, 0.3, 0.3};
  const fs::path out = pictures("view_edits");
  const Said said = run_script(
      {"view_edits.mjs", (context.output() / "view.html").string(), point.dump(), box.dump(), marks.dump(), out.string()});
  const json r = answer(said);
  ASSERT_FALSE(r.empty());
  EXPECT_TRUE(r["messages"].empty()) << r["messages"];

  std::map<std::string, fs::path> inputs = balls.artifacts();
  inputs["edits"] = out / "edits.yaml";
  test::RecordingContext edited(inputs);
  run_edit({}, edited);
  const json report = json::parse(read_file(edited.output() / "edited/report.json"));
  ASSERT_EQ(report["edits"].size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(r["counts"][i], report["edits"][i]["surfels"]) << report["edits"][i];
    EXPECT_GT(r["counts"][i], 100);
  }
  EXPECT_EQ(report["edits"][0]["name"], "rougher: \"all\" #1");
  EXPECT_EQ(report["edits"][0]["select"], "class specular");
  EXPECT_EQ(report["edits"][1]["name"], "no") << "a word that YAML may read as something else";
  EXPECT_EQ(report["edits"][1]["select"], "component 2") << "where it was clicked";
  EXPECT_NEAR(report["edits"][2]["set"]["tint"][0].get<double>(), 0.1, 0.005) << "#595959 in linear light";
  EXPECT_EQ(report["edits"][3]["select"], "2 marks");
  EXPECT_EQ(report["edits"][3]["delete"], true);
  EXPECT_EQ(r["counts"], r["opened"]) << "the page reads what it saved";

  EXPECT_EQ(r["nothing"], 0);
  EXPECT_EQ(r["held"], false);
  EXPECT_LT(r["tinted"][1].get<double>(), 0.97 * r["tinted"][0].get<double>());
  EXPECT_NE(r["pixels"][0], r["pixels"][1]) << "the ball is gone";
  EXPECT_EQ(r["pixels"][0], r["pixels"][2]) << "and there again";
  EXPECT_EQ(r["no_photo"], "Marks are drawn at the place of a photo: click one of the photos first.");
  EXPECT_EQ(r["refused"], "\u201cempty\u201d cannot be saved: it finds nothing.");
  EXPECT_NE(r["broken"].get<std::string>().find("\u201cclasss\u201d is not known here"), std::string::npos) << r["broken"];
}

}  // namespace
}  // namespace vitrine
