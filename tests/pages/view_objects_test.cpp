// The objects of a scene in the page of `vitrine view`, in headless Chromium: the list, hidden objects, and edits of an object
// against what `vitrine edit` finds by the file that the page saved.
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

constexpr const char* kName = "kettle: <b>\"1\"</b>";

using ViewObjects = InChromium;

// Two balls, of which one is an object, and a mirror of known shape that no surfel shows.
TEST_F(ViewObjects, AreListedHiddenAndEdited) {
  const test::TwoBalls balls;
  write_objects(balls.masks() / "objects",
                {.objects = {{.id = 1, .name = kName, .role = ObjectRole::Coat},
                             {.id = 2, .name = "mirror-1", .role = ObjectRole::Mirror, .trust = ObjectTrust::Detected},
                             {.id = 3, .name = "mirror-2", .role = ObjectRole::Mirror, .trust = ObjectTrust::Guessed}},
                 .shapes = {}});
  auto set = std::make_shared<ShapeSet>();
  for (const uint16_t object : {uint16_t(1), uint16_t(2)})
    set->entries.push_back({.shape = Box{Mat3d::identity(), {-0.05, -0.05, -0.4 - object}, {0.05, 0.05, -0.3 - object}},
                            .role = object == 1 ? ShapeRole::Coat : ShapeRole::Mirror,
                            .tolerance = 0.01,
                            .clear = {},
                            .object = object});
  ImageOptions image;
  image.shape.set = set;
  write_image_options(balls.capture.optimize() / "optimize/model.json", image);
  test::RecordingContext context(balls.artifacts());
  write_view(read_file(fs::path(VITRINE_BIN_DIR) / empty_page_path("view").filename()), {}, context);
  json places = json::array();
  constexpr size_t kPhoto = 6;  // at -y: the second ball stands beside the first
  for (const Vec3d& p : {balls.kA, balls.kB}) {
    const auto at = image_point(p, balls.capture.views[kPhoto]);
    ASSERT_TRUE(at);
    places.push_back({at->x, at->y});
  }
  const fs::path out = pictures("view_objects");
  const json r = answer(run_script(
      {"view_objects.mjs", (context.output() / "view.html").string(), std::to_string(kPhoto), places.dump(), out.string()}));
  ASSERT_FALSE(r.empty());
  EXPECT_TRUE(r["messages"].empty()) << r["messages"];

  EXPECT_EQ(r["list"], json::array({json::array({kName, "coat, given", "edit " + std::string(kName)}),
                                    json::array({"mirror-1", "mirror, detected", "edit mirror-1"})}));
  const json &whole = r["whole"], &hidden = r["hidden"];
  EXPECT_NE(hidden["pixels"][0], whole["pixels"][0]) << "the object is hidden";
  EXPECT_EQ(hidden["pixels"][1], whole["pixels"][1]) << "the other ball is there";
  EXPECT_EQ(hidden["shapes"], json::array({0})) << "its known shape is hidden with it";
  EXPECT_EQ(r["linked"], hidden) << "another visit to the address";
  EXPECT_EQ(r["both"]["shapes"], json::array({0, 1}));
  EXPECT_EQ(r["shown"], whole);

  EXPECT_EQ(r["focused"], "edit_name");
  EXPECT_EQ(r["deleted"]["pixels"], hidden["pixels"]);
  EXPECT_EQ(r["deleted_and_hidden"]["pixels"], hidden["pixels"]);
  EXPECT_EQ(r["deleted_and_shown"]["pixels"], hidden["pixels"]) << "shown, and deleted by the edit";
  std::map<std::string, fs::path> inputs = balls.artifacts();
  inputs["edits"] = out / "edits.yaml";
  test::RecordingContext edited(inputs);
  run_edit({}, edited);
  const json report = json::parse(read_file(edited.output() / "edited/report.json"));
  ASSERT_EQ(report["edits"].size(), 2u);
  EXPECT_EQ(report["edits"][0]["name"], kName);
  EXPECT_EQ(report["edits"][0]["select"], std::string("object ") + kName);
  EXPECT_EQ(report["edits"][0]["delete"], true);
  for (size_t i = 0; i < 2; ++i) EXPECT_EQ(r["counts"][i], report["edits"][i]["surfels"]) << report["edits"][i];
  EXPECT_GT(r["counts"][0], 800);
  EXPECT_GT(r["counts"][1], 500);
  EXPECT_EQ(r["opened"], r["counts"]) << "the page reads what it saved";
  EXPECT_NE(r["unknown"].get<std::string>().find("there is no object \u201cvase\u201d"), std::string::npos) << r["unknown"];

  EXPECT_LT(r["mesh"][1], 0.85 * r["mesh"][0].get<double>()) << "the mesh without WebGL2: the rear ball of two is hidden";
  EXPECT_GT(r["mesh"][1], 0.5 * r["mesh"][0].get<double>());
  EXPECT_EQ(r["mesh"][2], r["mesh"][0]);
}

}  // namespace
}  // namespace vitrine
