// A grey card on, in or beside what was trained: the scale of albedo and the gains of photos.
#include "stages/decompose/decompose.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "core/foundation/base/hash.h"
#include "core/scene/camera/scene_info.h"

#include "core/scene/camera/view_masks.h"
#include "core/scene/image/ldr.h"
#include "core/scene/light/environment.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/surfel_colors.h"
#include "stages/decompose/grey_card.h"
#include "tests/stages/decompose/shared_room.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

using test::room, test::quick;

TEST(Decompose, GreyCardSetsTheScale) {
  test::RecordingContext context(room().inputs());
  DecomposeConfig config = quick();
  config.solver_rounds = 1;
  config.grey_card = "view_0.png:50,60,6,6";
  config.grey_albedo = 0.3;
  run_decompose(config, context);
  const auto report = nlohmann::json::parse(read_file(context.output() / "decompose" / "report.json"));
  EXPECT_EQ(report.at("scale").at("by"), "grey_card");
  const SplatLayer layer = read_layer(room().folder() / "gaussians/diffuse.ply");
  const std::vector<Vec3f> albedo = read_decomposed_materials(context.output()).albedo;
  const GreyCard card = card_box(config.grey_card, room().views);
  const Vec3f found = median_in(card, room().views[0], SurfelColors(layer, albedo, 0.01f).picture(room().views[0]));
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(found[c], 0.3, 0.005);
  // Surfels that the convention makes brighter than white keep what tells them apart once the card has made them darker.
  DecomposeConfig bright = config;
  bright.grey_card.clear();
  bright.white_albedo = 0.95;
  bright.grey_albedo = 0.18;
  test::RecordingContext by_convention(room().inputs());
  run_decompose(bright, by_convention);
  const std::vector<Vec3f> white = read_decomposed_materials(by_convention.output()).albedo;
  bright.grey_card = config.grey_card;
  test::RecordingContext by_card(room().inputs());
  run_decompose(bright, by_card);
  const std::vector<Vec3f> grey = read_decomposed_materials(by_card.output()).albedo;
  for (size_t c = 0; c < 3; ++c) {
    float gain = 0, darkest = 1, brightest = 0;
    size_t limited = 0;
    for (size_t i = 0; i < white.size(); ++i) {
      if (white[i][c] < 0.5f) gain = grey[i][c] / white[i][c];  // the same for all
      if (white[i][c] < 0.979f) continue;
      ++limited;
      darkest = std::min(darkest, grey[i][c]);
      brightest = std::max(brightest, grey[i][c]);
    }
    ASSERT_LT(gain, 0.9f) << "the card must make the scene darker for this test";
    ASSERT_GT(limited, 10u) << "channel " << c;
    EXPECT_GT(brightest, 1.05f * darkest) << limited << " surfels of channel " << c;
  }
  for (const char* wrong :
       {"view_0.png", "view_0.png:1,2,3", "view_9.png:1,2,3,4", "view_0.png:100,60,50,6", "view_0.png:1,2,0,4"}) {
    config.grey_card = wrong;
    const Error e = error_of([&] { run_decompose(config, context); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << wrong;
    EXPECT_EQ(e.detail().code, "GREY_CARD");
  }
}

// The room with a card that photos show and the scene does not.
class CardBeside {
 public:
  CardBeside() {
    fs::copy(room().folder(), folder(), fs::copy_options::recursive);
    object_alone(true);
  }
  const fs::path& folder() const { return copy_.path(); }
  void object_alone(bool yes) const {
    auto split = nlohmann::json::parse(read_file(folder() / "optimize/views.json"));
    split["object_alone"] = yes;
    write_file(folder() / "optimize/views.json", split.dump());
  }
  // `of(x, y)`: linear colour of the pixel.
  void photo(const std::function<Vec3f(int, int)>& of) const {
    const Intrinsics& k = room().views[0].intrinsics;
    ImageF image(k.width, k.height, 3);
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x)
        for (size_t c = 0; c < 3; ++c) image.at(x, y, int(c)) = of(x, y)[c];
    write_exr_rgb(linear_image_path(folder(), room().views[0]), image, ExrPrecision::Float);
  }
  // The gain that sfm found for view_0; the others keep 1.
  void gain(const Vec3d& solved) const {
    Gains gains;
    for (const View& v : room().views) gains[v.name] = {1, 1, 1};
    gains["view_0.png"] = solved;
    write_gains(folder() / "sfm/gains.json", gains);
  }
  // Photo view_0 of the room, as bright as that, with a card in a box of 6 pixels.
  void photo_of_room(const Vec3f& gain, int card_x, int card_y, const Vec3f& card) const {
    const View view = load_view_set(folder()).views[0];
    const ImageF shown = SurfelColors(read_layer(folder() / "gaussians/diffuse.ply"), room().radiance, 0.01f).picture(view);
    photo([&](int x, int y) {
      const bool on_card = x >= card_x && x < card_x + 6 && y >= card_y && y < card_y + 6;
      const float* p = shown.pixel(x, y);
      return hadamard(gain, on_card ? card : p[0] > 0 ? Vec3f{p[0], p[1], p[2]} : Vec3f{0.6f, 0.6f, 0.6f});
    });
  }
  // The cameras with a bright view from above, turned upside down: the second pass.
  void turn_over() const {
    ColmapModel model = read_colmap_model(folder() / "sparse/0");
    Passes passes(2);
    for (ColmapImage& image : model.images) {
      const bool second = (image.name[5] - '0') % 2 == 0;
      passes[second].push_back(image.name);
      if (!second) continue;
      const Rigid upside_down{Mat3d{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}, {}};
      const Rigid pose = upside_down * image.cam_from_world();
      image.rotation = quaternion(pose.rotation), image.translation = pose.translation;
    }
    write_colmap_model(folder() / "sparse/0", model, ColmapFormat::Binary);
    write_passes(folder(), passes, PosesOf::Object);
  }
  test::RecordingContext context() const {
    return test::RecordingContext({{"sfm", folder()}, {"optimize", folder()}, {"mesh", folder()}});
  }

 private:
  TemporaryFolder copy_;
};

constexpr const char* kSkyBox = "view_0.png:50,2,6,6";  // beyond the table

// Of a horizontal patch, by an integration that is not the stage's.
double irradiance_of(const std::function<double(const Vec3f&)>& radiance, float up) {
  double sum = 0;
  constexpr int kHeight = 90, kAround = 180;
  for (int i = 0; i < kHeight; ++i)
    for (int j = 0; j < kAround; ++j) {
      const float z = (float(i) + 0.5f) / kHeight, a = 2 * std::numbers::pi_v<float> * (float(j) + 0.5f) / kAround;
      const float s = std::sqrt(1 - z * z);
      sum += double(z) * radiance({s * std::cos(a), s * std::sin(a), up * z});
    }
  return sum * 2 * std::numbers::pi / (kHeight * kAround);
}

double irradiance_of(const Environment& light, size_t channel, float up) {
  return irradiance_of([&](const Vec3f& d) { return double(light.radiance(d)[channel]); }, up);
}

TEST(Decompose, AGreyCardBesideTheObjectIsMeasuredInThePhoto) {
  const CardBeside scene;
  const Vec3f gain{1.2f, 1, 0.5f};
  scene.gain(cast<double>(gain));
  DecomposeConfig config = quick();
  config.sheet_rows = 0;
  config.grey_card = kSkyBox;
  config.grey_albedo = 0.3;
  const double radiance =
      0.3 / std::numbers::pi * irradiance_of([](const Vec3f& d) { return double(test::LitRoom::sky(d).x); }, 1);
  const auto r = float(radiance);
  scene.photo_of_room(gain, 50, 2, {r, r, r});
  test::RecordingContext context = scene.context();
  run_decompose(config, context);
  EXPECT_NE(context.summary_text.find("albedo by grey card in the photo"), std::string::npos);
  EXPECT_FALSE(context.warnings.contains("PHOTO_GAIN")) << context.warnings["PHOTO_GAIN"];
  const auto report = nlohmann::json::parse(read_file(context.output() / "decompose" / "report.json"));
  EXPECT_EQ(report.at("scale").at("card"), "in the photo, beside the trained scene");
  // Under the light that was written, the card has its albedo; and so have all paints, nearly.
  const Environment light = read_environment(decomposed_environment_path(context.output()));
  const std::vector<Vec3f> albedo = read_decomposed_materials(context.output()).albedo;
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(std::numbers::pi * radiance / irradiance_of(light, c, 1), 0.3, 0.006) << c;
    double mean = 0;
    for (size_t i = 0; i < albedo.size(); ++i)
      mean += std::log(double(albedo[i][c]) / double(room().albedo[i][c])) / double(albedo.size());
    EXPECT_NEAR(mean, 0, 0.1) << c;
  }
  // Nor does the scene have to be of the object alone: what counts there is whether anything covers the box.
  scene.object_alone(false);
  test::RecordingContext again = scene.context();
  run_decompose(config, again);
  EXPECT_EQ(read_decomposed_materials(again.output()).albedo, albedo);
  // Gains that sfm got wrong do not reach the albedo: the object in the photo knows better.
  scene.gain({0.4, 1, 2});
  test::RecordingContext drifted = scene.context();
  run_decompose(config, drifted);
  EXPECT_EQ(read_decomposed_materials(drifted.output()).albedo, albedo);
  EXPECT_TRUE(drifted.warnings.contains("PHOTO_GAIN"));
}

TEST(Decompose, APhotoWithoutTheObjectKeepsItsGain) {
  ImageF photo(40, 30, 3, 0.4f), rendered(20, 15, 3);
  EXPECT_FALSE(gain_by_scene(photo, rendered));
  rendered = ImageF(20, 15, 3, 0.2f);
  const auto gain = gain_by_scene(photo, rendered);
  ASSERT_TRUE(gain);
  for (size_t c = 0; c < 3; ++c) EXPECT_FLOAT_EQ((*gain)[c], 2);
  EXPECT_FALSE(gain_by_scene(ImageF(40, 30, 3, 0.99f), rendered)) << "clipped";
  EXPECT_FALSE(gain_by_scene(ImageF(40, 30, 3, 0.001f), rendered)) << "black";
}

TEST(Decompose, AGreyCardThatTheObjectAloneShowsIsThatOfItsSurfels) {
  DecomposeConfig config = quick();
  config.sheet_rows = 0;
  config.solver_rounds = 1;
  config.grey_card = "view_0.png:50,60,6,6";
  const CardBeside scene;
  scene.photo([](int, int) { return Vec3f{0.1f, 0.2f, 0.4f}; });  // is not asked
  std::vector<std::string> bytes;
  for (const bool alone : {false, true}) {
    scene.object_alone(alone);
    test::RecordingContext context = scene.context();
    run_decompose(config, context);
    bytes.push_back(read_file(context.output() / "decompose/materials.ply") +
                    read_file(context.output() / "decompose/report.json"));
  }
  EXPECT_TRUE(bytes[0] == bytes[1]);
}

TEST(Decompose, AGreyCardOfTheSecondPassLiesOnTheOtherSideOfTheObject) {
  const CardBeside scene;
  scene.turn_over();
  const Vec3f card{0.2f, 0.15f, 0.1f};
  scene.photo_of_room({2, 1, 1}, 56, 76, card);
  DecomposeConfig config = quick();
  config.sheet_rows = 0;
  config.solver_rounds = 2;
  config.grey_card = "view_0.png:56,76,6,6";  // the same place in the photo that is upside down
  config.grey_albedo = 0.5;
  test::RecordingContext context = scene.context();
  run_decompose(config, context);
  const Environment light = read_environment(decomposed_environment_path(context.output()));
  for (size_t c = 0; c < 3; ++c) {
    const double below = irradiance_of(light, c, -1), above = irradiance_of(light, c, 1);
    ASSERT_GT(std::abs(std::log(above / below)), 0.2) << "for this test, light must tell the two sides apart";
    EXPECT_NEAR(std::numbers::pi * double(card[c]) / below, 0.5, 0.01) << c;
  }
}

TEST(Decompose, UpOfAPassIsThatOfItsCameras) {
  const CardBeside scene;
  scene.turn_over();
  const std::vector<View> views = load_view_set(scene.folder()).views;
  const Passes passes = read_passes(scene.folder());
  EXPECT_EQ(up_in_photo(views[0], views, {}), (Vec3f{0, 0, 1}));
  EXPECT_EQ(up_in_photo(views[1], views, passes), (Vec3f{0, 0, 1}));
  EXPECT_LT(length(up_in_photo(views[2], views, passes) - Vec3f{0, 0, -1}), 1e-6f);
  std::vector<View> nadir = views;
  for (size_t i = 0; i < nadir.size(); ++i) {
    const double a = std::numbers::pi / 4 * double(i), c = std::cos(a), s = std::sin(a);
    nadir[i].cam_from_world = inverse(Rigid{Mat3d{{c, s, 0}, {s, -c, 0}, {0, 0, -1}}, {0, 0, 1}});
  }
  const Error e = error_of([&] { up_in_photo(nadir[0], nadir, passes); });
  EXPECT_EQ(e.detail().code, "GREY_CARD");
  EXPECT_EQ(e.kind(), ErrorKind::Input);
}

TEST(Decompose, APhotoOfAGreyCardThatIsClippedOrBlackIsAnError) {
  const View view{"a.png", {20, 10, 20, 20, 10, 5}, {}, {}};
  const GreyCard card = card_box("a:10,2,4,5", {view});
  ImageF photo(20, 10, 3, 0.4f);
  const auto fill = [&](int rows, const Vec3f& color) {
    photo = ImageF(20, 10, 3, 0.4f);
    for (int y = 2; y < 2 + rows; ++y)
      for (int x = 10; x < 14; ++x)
        for (size_t c = 0; c < 3; ++c) photo.at(x, y, int(c)) = color[c];
  };
  EXPECT_LT(length(photographed(card, view, photo) - Vec3f{0.4f, 0.4f, 0.4f}), 1e-6f);
  for (const Vec3f& useless : {Vec3f{0.99f, 0.3f, 0.3f}, Vec3f{1, 1, 1}, Vec3f{0, 0, 0}}) {
    fill(2, useless);  // of five rows: the others decide
    EXPECT_LT(length(photographed(card, view, photo) - Vec3f{0.4f, 0.4f, 0.4f}), 1e-6f);
  }
  const auto why = [&](int rows, const Vec3f& color) {
    fill(rows, color);
    const Error e = error_of([&] { photographed(card, view, photo); });
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_EQ(e.detail().code, "GREY_CARD");
    EXPECT_EQ(e.detail().where, "a.png");
    return e.detail().why;
  };
  EXPECT_EQ(why(3, {0.3f, 0.3f, 0.97f}), "60 % of the box are overexposed");
  EXPECT_EQ(why(5, {1, 1, 1}), "100 % of the box are overexposed");
  EXPECT_EQ(why(5, {0, 0, 0}), "100 % of the box are black");
  EXPECT_EQ(why(5, {0.2f, 0.1f, 0.001f}), "its colour is 0.2000 0.1000 0.0010 of white: too dark");
  // The stage says it, too.
  const CardBeside scene;
  scene.photo([](int, int) { return Vec3f{1, 1, 1}; });
  DecomposeConfig config = quick();
  config.solver_rounds = 1;
  config.grey_card = kSkyBox;
  test::RecordingContext context = scene.context();
  EXPECT_EQ(error_of([&] { run_decompose(config, context); }).detail().why, "100 % of the box are overexposed");
}

}  // namespace
}  // namespace vitrine
