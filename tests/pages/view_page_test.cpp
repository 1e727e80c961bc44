// view.html in headless Chromium, from file://: its pictures against those of the programs, and what a person does with it.
#include <gtest/gtest.h>

#include "core/foundation/config/chart.h"
#include "core/render/picture/view_picture.h"
#include "core/render/relight/relit_painter.h"
#include "core/scene/camera/transforms_file.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/metrics.h"
#include "core/scene/light/lighting.h"
#include "stages/page_text.h"
#include "stages/view/page_surfels.h"
#include "stages/view/view.h"
#include "tests/core/render/relight/relit_ball.h"
#include "tests/pages/in_chromium.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_capture.h"

namespace vitrine {
namespace {

using nlohmann::json;

// A ball beside which a case of clear panes stands, with a layer of reflections around both.
void add_case(const test::TinyCapture& capture) {
  ImageOptions image;
  image.transmission.glass = Glass::Thin;
  auto set = std::make_shared<ShapeSet>();
  set->entries.push_back({.shape = Box{Mat3d::identity(), {-0.45, -0.45, -0.45}, {0.45, 0.45, 0.45}},
                          .role = ShapeRole::Sheet,
                          .tolerance = 0.02,
                          .clear = {}});
  image.shape.set = set;
  write_image_options(capture.optimize() / "optimize/model.json", image);
  const SplatLayer around = test::sphere_layer(3, 800);
  SplatLayer mirrored(LayerKind::Reflection, 0, around.size());
  for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc})
    std::ranges::copy(around.values(a), mirrored.values(a).begin());
  write_layer(capture.optimize() / "gaussians/reflection.ply", mirrored);
  // Relit pictures look behind glass where there is a layer of what stands there: one surfel that shows nothing.
  SplatLayer inside(LayerKind::Transmittance, 0, 1);
  *inside.at(Attribute::Opacity, 0) = -20;
  inside.at(Attribute::Rotation, 0)[0] = 1;
  write_layer(capture.optimize() / "gaussians/transmittance.ply", inside);
}

double psnr_of(const ImageF& a, const fs::path& png) { return psnr(a, read_srgb(png)); }

// A page of a ball, an HDRI and a file that is none.
class ViewPage : public InChromium {
 protected:
  void SetUp() override {
    InChromium::SetUp();
    if (HasFatalFailure() || IsSkipped()) return;
    prepare();
    make_folders(decompose / "decompose");
    const RelitScene ball = test::relit_ball({0.8f, 0.4f, 0.2f});
    write_decomposed_materials(decompose, ball.materials);
    write_environment(decomposed_environment_path(decompose), Environment(ImageF(16, 8, 3, 1.f)));
    ImageF soft(64, 32, 3);
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 64; ++x) {
        const Vec3f d = lat_long_direction((float(x) + 0.5f) / 64, (float(y) + 0.5f) / 32);
        for (int c = 0; c < 3; ++c) soft.at(x, y, c) = 0.6f + 0.3f * d[size_t(c)];
      }
    write_environment(sky, Environment(soft));
    write_file(none, "\xff\xd8\xff\xe0 no light");
    context.emplace(std::map<std::string, fs::path>{
        {"sfm", capture.sfm()}, {"optimize", capture.optimize()}, {"mesh", capture.mesh()}, {"decompose", decompose}});
    write_view(read_file(empty_page_path("view")), {}, *context);
  }
  virtual void prepare() {}
  // What a script found that used the page; pictures are in `out`.
  json used(const char* script, const fs::path& out) const {
    return answer(run_script({script, (context->output() / "view.html").string(), sky.string(), none.string(), out.string()}));
  }

  const test::TinyCapture capture;
  const TemporaryFolder folder;
  const fs::path decompose = folder.path() / "artifact", sky = folder.path() / "sky.exr", none = folder.path() / "none.hdr";
  std::optional<test::RecordingContext> context;
};

class ViewPageOfACase : public ViewPage {
 protected:
  void prepare() override { add_case(capture); }
};

TEST_F(ViewPageOfACase, ShowsWhatTheProgramsShowAndDoesWhatAPersonAsks) {
  EXPECT_LT(fs::file_size(context->output() / "view.html"), 3u << 20);
  const fs::path out = pictures("view");
  const json r = used("view_page.mjs", out);
  ASSERT_FALSE(r.empty());
  EXPECT_TRUE(r["messages"].empty()) << r["messages"];
  RecordProperty("first_ms", r["first_ms"].get<int>());

  // As photographed, and under the other light.
  ScenePainter painter(read_trained_scene(capture.optimize()), {});
  EXPECT_GT(psnr_of(painter.picture(capture.views[0]).srgb, out / "photo.png"), 35);
  RelitPainter relit(read_relit_scene({.optimize = capture.optimize(), .mesh = capture.mesh(), .decompose = decompose}));
  Lighting lighting;
  lighting.environment = read_environment(sky);
  relit.set_lighting(lighting);
  EXPECT_GT(psnr_of(srgb_from_linear_image(relit.picture(capture.views[0]).radiance), out / "relit.png"), 28);

  EXPECT_NE(r["keys"][0], r["keys"][1]);
  EXPECT_NE(r["keys"][1], r["keys"][2]);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(r["keys"][0][c].get<double>(), r["keys"][3][c].get<double>(), 1e-6);
  EXPECT_NE(r["dragged"], r["keys"][3]);
  EXPECT_NE(r["wheel"], r["dragged"]);
  EXPECT_EQ(r["refused"], "none.hdr is no HDRI: it begins like a JPEG picture. Drop a .hdr or .exr file.");
  EXPECT_EQ(r["light"], "sky.exr");
  EXPECT_LE(r["turned"], 3);
  EXPECT_NEAR(r["furnace"][0].get<double>(), 1, 0.03);
  EXPECT_LT(r["furnace"][1].get<double>(), 0.03);
  EXPECT_GT(r["glass"], 1);
  EXPECT_NE(r["distance"].get<std::string>().find("scale unknown"), std::string::npos) << r["distance"];
  const std::string option = r["scale_points"], before = "--scale-points \"";
  ASSERT_TRUE(option.starts_with(before) && option.ends_with("\"")) << option;
  const ScalePoints points = parse_scale_points(option.substr(before.size(), option.size() - before.size() - 1));
  EXPECT_DOUBLE_EQ(points.length_m, 0.24);
  EXPECT_NEAR(points.scene_units(), std::stod(r["distance"].get<std::string>()), 1e-3);
  EXPECT_EQ(r["photo"][0], "50%");
  const std::string split = r["photo"][1];
  EXPECT_NEAR(std::stod(split), 80, 4) << split;
  EXPECT_EQ(r["photo"][2], true);
  EXPECT_NE(r["address"].get<std::string>().find("mode=photo"), std::string::npos);
  EXPECT_NEAR(r["reopened"][0].get<double>(), 0.5, 1e-3);
  EXPECT_EQ(r["plain"][0], true);
  EXPECT_EQ(r["plain"][1], "This browser has no WebGL2: the mesh alone is shown, in its plain colours.");

  // What it saved is a camera path for the programs.
  const std::vector<View> one = read_camera_path({.file = out / "view.json", .size = {}, .usual_size = {}});
  ASSERT_EQ(one.size(), 1u);
  const Vec3d eye = one[0].centre_in_world(), first = capture.views[0].centre_in_world();
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(eye[c], first[c], 1e-4);
  EXPECT_EQ(read_camera_path({.file = out / "path.json", .size = {}, .usual_size = {}}).size(), 2u);
  EXPECT_FALSE(read_srgb(out / "view.png").empty());
}

TEST_F(ViewPage, FollowsFingersAndTakesDroppedFiles) {
  const json r = used("view_touch.mjs", pictures("view_touch"));
  ASSERT_FALSE(r.empty());
  EXPECT_TRUE(r["messages"].empty()) << r["messages"];
  struct Stand {
    Vec3d eye, target;
    double distance() const { return length(eye - target); }
  };
  const auto stand = [&](const char* when) {
    const json& s = r[when];
    return Stand{{s[0][0], s[0][1], s[0][2]}, {s[1][0], s[1][1], s[1][2]}};
  };
  const Stand start = stand("start"), orbit = stand("orbit"), pinch = stand("pinch"), moved = stand("moved");
  EXPECT_GT(length(orbit.eye - start.eye), 0.1) << "one finger turns";
  EXPECT_LT(length(orbit.target - start.target), 1e-6);
  EXPECT_NEAR(orbit.distance(), start.distance(), 1e-6);
  EXPECT_NEAR(pinch.distance() / orbit.distance(), 0.5, 0.1) << "twice as far apart is twice as near";
  EXPECT_GT(length(moved.target - pinch.target), 0.02) << "two fingers move";
  EXPECT_NEAR(moved.distance(), pinch.distance(), 0.05 * pinch.distance());
  EXPECT_EQ(r["page"], json::array({1, 0})) << "the window itself was neither zoomed nor scrolled";
  EXPECT_EQ(r["tapped"], "albedo");
  EXPECT_LE(r["overflow"], 0);
  EXPECT_TRUE(r["small"].empty()) << r["small"];
  EXPECT_EQ(r["dropping"], json::array({true, false}));
  EXPECT_EQ(r["refused"][0], "none.hdr is no HDRI: it begins like a JPEG picture. Drop a .hdr or .exr file.");
  EXPECT_EQ(r["refused"][1], "photo") << "what is shown stays";
  EXPECT_EQ(r["dropped"], json::array({"sky.exr", "relit", ""}));
  EXPECT_EQ(r["several"], "sky.exr");
}

TEST_F(ViewPage, ClipsAnnotatesShowsConfidenceAndTwoRuns) {
  const fs::path out = pictures("view_tools");
  const json r = used("view_tools.mjs", out);
  ASSERT_FALSE(r.empty());
  EXPECT_TRUE(r["messages"].empty()) << r["messages"];

  // The camera stands at x = 1 and looks at a ball of radius 0.4; the clip plane hides its near half.
  EXPECT_NEAR(r["clip"]["before"].get<double>(), test::TinyCapture::kRadius, 0.03) << "x of the surface in the middle";
  EXPECT_LT(r["clip"]["across"].get<double>(), 0) << "behind the plane";
  EXPECT_EQ(r["clip"]["beyond"], 0) << "all is hidden";
  EXPECT_GT(r["clip"]["flipped"].get<double>(), 0.3);
  EXPECT_EQ(r["clip"]["off"], 0) << "as before";
  EXPECT_GT(r["clip"]["mesh"][1].get<double>(), 1.5 * r["clip"]["mesh"][0].get<double>()) << "half a mesh, and all of it";

  const TrainedScene scene = read_trained_scene(capture.optimize());
  std::vector<Vec3d> eyes;
  for (const View& v : capture.views) eyes.push_back(v.centre_in_world());
  const std::vector<View> trained_on(capture.views.begin() + 1, capture.views.end());
  const PageSurfels surfels = page_surfels(scene, eyes, 100000);
  std::vector<uint8_t> seen;
  for (const PhotoCoverage& c : page_coverage(surfels, trained_on, scene.image.diffuse.near_z)) seen.push_back(coverage_byte(c));
  EXPECT_EQ(r["confidence"]["seen"].get<std::vector<uint8_t>>(), seen);
  EXPECT_EQ(r["confidence"]["legend"], json::array({false, true})) << "there with the mode alone";
  EXPECT_LE(r["confidence"]["off_scale"], 3) << "colours of the legend";

  const json& note = r["note"];
  EXPECT_NEAR(std::hypot(note["place"][0].get<double>(), note["place"][1].get<double>(), note["place"][2].get<double>()),
              test::TinyCapture::kRadius, 0.02);
  EXPECT_LT(note["off_px"], 1.5);
  EXPECT_EQ(note["markup"], 0);
  EXPECT_EQ(note["deleted"], 0);
  EXPECT_EQ(note["opened"], json::array({"<b>one</b>", note["place"]}));
  EXPECT_EQ(note["refused"], "wrong.json holds no annotations: it is no JSON. Open a file that this page saved.");
  EXPECT_EQ(note["from_behind"], json::array({"<b>one</b>", "note covered"})) << "the address has it, the ball hides it";

  EXPECT_EQ(r["two"]["refused"],
            "other.html cannot be shown beside this page: it holds no scene: `vitrine view` puts one in, into view.html.");
  EXPECT_EQ(r["two"]["differ"], 0) << "a page beside itself";
  EXPECT_GT(r["two"]["bright"], 1000) << "it shows something";
  EXPECT_LT(r["two"]["camera"], 1e-6) << "the camera of the same photo in the other frame";
  EXPECT_NE(r["two"]["told"].get<std::string>().find("aligned by the places of 8 photos of the same names, 1.700 times as large"),
            std::string::npos)
      << r["two"]["told"];
  EXPECT_EQ(r["two"]["ended"], 1) << "one canvas is left";
}

}  // namespace
}  // namespace vitrine
