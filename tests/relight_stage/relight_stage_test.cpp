#include "stages/relight/relight.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/light/environment.h"
#include "core/picture/relight_materials.h"
#include "core/picture/surfel_colors.h"
#include "stages/relight/affinity.h"
#include "stages/relight/grey_card.h"
#include "stages/relight/light_grid.h"
#include "stages/relight/light_solver.h"
#include "stages/relight/metals.h"
#include "stages/relight/point_grid.h"
#include "stages/relight/spread.h"
#include "stages/relight/transport.h"
#include "tests/evaluate/tiny_capture.h"
#include "tests/relight_stage/lit_room.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

const test::LitRoom& room() {
  static const test::LitRoom instance;
  return instance;
}

RelightConfig quick() {
  RelightConfig config;
  config.points = 2500;
  config.bands = 12;
  config.max_side = 112;
  config.panorama_height = 16;
  config.sheet_rows = 1;
  config.solver.points = 1200;
  config.solver.rounds = 10;
  return config;
}

// rms of log(scale ours / truth) after one factor per channel, their mean ratio.
double log_error(const std::vector<Vec3f>& ours, const std::vector<Vec3f>& truth) {
  double squares = 0;
  for (size_t c = 0; c < 3; ++c) {
    double mean = 0;
    for (size_t i = 0; i < ours.size(); ++i) mean += std::log(double(ours[i][c]) / double(truth[i][c])) / double(ours.size());
    for (size_t i = 0; i < ours.size(); ++i) {
      const double d = std::log(double(ours[i][c]) / double(truth[i][c])) - mean;
      squares += d * d;
    }
  }
  return std::sqrt(squares / (3 * double(ours.size())));
}

TEST(Relight, FindsAlbedoAndLightOfAKnownScene) {
  test::RecordingContext context(room().inputs());
  run_relight(quick(), context);
  const RelightMaterials materials = read_relight_materials(context.output());
  ASSERT_EQ(materials.size(), room().albedo.size());
  const double before = log_error(room().radiance, room().albedo), after = log_error(materials.albedo, room().albedo);
  RecordProperty("log_error", fmt::format("{} -> {}", before, after));
  EXPECT_LT(after, 0.17) << "undecomposed " << before;
  EXPECT_LT(after, 0.4 * before);
  for (const Vec3f& rho : materials.albedo)
    for (size_t c = 0; c < 3; ++c) ASSERT_TRUE(rho[c] >= 0 && rho[c] <= 1);
  EXPECT_NEAR(materials.f0[0].x, 0.04f, 1e-4f);
  EXPECT_EQ(materials.specular_weight[0], 0.f);  // there is no reflection layer that could have trained it
  // The light comes from where it does.
  const Environment light = read_environment(relight_environment_path(context.output()));
  const auto mean_around = [&](const Vec3f& axis) {
    float sum = 0;
    int count = 0;
    for (int k = 0; k < 400; ++k) {
      const float z = float(k % 20) / 20, a = float(k / 20) * 0.314159f, s = std::sqrt(1 - z * z);
      const Vec3f d{s * std::cos(a), s * std::sin(a), z};
      if (dot(d, axis) > 0.85f) sum += light.radiance(d).y, ++count;
    }
    return sum / float(count);
  };
  const Vec3f lamp = normalized(Vec3f{0.7f, 0.3f, 0.65f});
  EXPECT_GT(mean_around(lamp), 4 * mean_around(normalized(Vec3f{-0.7f, -0.3f, 0.65f})));
  for (const char* file : {"albedo.png", "baked.png", "report.json"})
    EXPECT_TRUE(fs::exists(context.output() / "relight" / file));
  EXPECT_TRUE(std::ranges::is_sorted(context.fractions));
  EXPECT_GT(context.metrics.at("light_known_share"), 0.01);
}

TEST(Relight, SameBytesForAnyNumberOfThreads) {
  std::vector<std::string> bytes;
  for (const int threads : {1, 3}) {
    set_thread_limit(threads);
    test::RecordingContext context(room().inputs());
    RelightConfig config = quick();
    config.solver.rounds = 2;
    run_relight(config, context);
    std::string all;
    for (const char* file : {"materials.ply", "environment.exr", "report.json", "albedo.png", "baked.png"})
      all += read_file(context.output() / "relight" / file);
    bytes.push_back(std::move(all));
  }
  set_thread_limit(0);
  EXPECT_TRUE(bytes[0] == bytes[1]);
}

TEST(Relight, GreyCardSetsTheScale) {
  test::RecordingContext context(room().inputs());
  RelightConfig config = quick();
  config.solver.rounds = 1;
  config.grey_card = "view_0.png:50,60,6,6";
  config.grey_albedo = 0.3;
  run_relight(config, context);
  const auto report = nlohmann::json::parse(read_file(context.output() / "relight" / "report.json"));
  EXPECT_EQ(report.at("scale").at("by"), "grey_card");
  const SplatLayer layer = read_layer(room().folder() / "gaussians/diffuse.ply");
  const std::vector<Vec3f> albedo = read_relight_materials(context.output()).albedo;
  const GreyCard card = parse_grey_card(config.grey_card, room().views);
  const Vec3f found = median_in(card, room().views[0], SurfelColors(layer, albedo, 0.01f).picture(room().views[0]));
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(found[c], 0.3, 0.005);
  // Surfels that the convention makes brighter than white keep what tells them apart once the card has made them darker.
  RelightConfig bright = config;
  bright.grey_card.clear();
  bright.white_albedo = 0.95;
  bright.grey_albedo = 0.18;
  test::RecordingContext by_convention(room().inputs());
  run_relight(bright, by_convention);
  const std::vector<Vec3f> white = read_relight_materials(by_convention.output()).albedo;
  bright.grey_card = config.grey_card;
  test::RecordingContext by_card(room().inputs());
  run_relight(bright, by_card);
  const std::vector<Vec3f> grey = read_relight_materials(by_card.output()).albedo;
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
    const Error e = error_of([&] { run_relight(config, context); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << wrong;
    EXPECT_EQ(e.detail().code, "GREY_CARD");
  }
}

TEST(Relight, RefusesScenesWithoutSurface) {
  const auto refused = [](const std::function<void(const fs::path&)>& damage) {
    const TemporaryFolder copy;
    fs::copy(room().folder(), copy.path(), fs::copy_options::recursive);
    damage(copy.path());
    test::RecordingContext context({{"sfm", copy.path()}, {"optimize", copy.path()}, {"mesh", copy.path()}});
    const Error e = error_of([&] { run_relight(quick(), context); });
    EXPECT_EQ(e.kind(), ErrorKind::Input) << e.what();
    return e.detail().code;
  };
  EXPECT_EQ(refused([](const fs::path& f) { write_mesh_ply(f / "mesh/mesh.ply", TriMesh{}); }), "NO_SURFACE");
  EXPECT_EQ(refused([](const fs::path& f) {
              TriMesh flat;
              flat.positions = {{0, 0, 0}, {0.1f, 0, 0}, {0.2f, 0, 0}};
              flat.colors.resize(3);
              flat.faces = {{0, 1, 2}};
              write_mesh_ply(f / "mesh/mesh.ply", flat);
            }),
            "NO_SURFACE");
  EXPECT_EQ(refused([](const fs::path& f) { write_layer(f / "gaussians/diffuse.ply", SplatLayer(LayerKind::Diffuse, 0, 0)); }),
            "NO_SURFACE");
}

TEST(Relight, OverexposedPhotosEndInAGuessAndAWarning) {
  const TemporaryFolder copy;
  fs::copy(room().folder(), copy.path(), fs::copy_options::recursive);
  SplatLayer layer = read_layer(copy.path() / "gaussians/diffuse.ply");
  std::ranges::fill(layer.values(Attribute::ShDc), 20.f);
  write_layer(copy.path() / "gaussians/diffuse.ply", layer);
  test::RecordingContext context({{"sfm", copy.path()}, {"optimize", copy.path()}, {"mesh", copy.path()}});
  run_relight(quick(), context);
  EXPECT_TRUE(context.warnings.contains("FEW_DULL_POINTS"));
  for (const Vec3f& rho : read_relight_materials(context.output()).albedo)
    for (size_t c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(rho[c]));
}

TEST(Relight, WithoutPicturesTheirErrorIsAbsentNotZero) {
  test::RecordingContext context(room().inputs());
  RelightConfig config = quick();
  config.solver.rounds = 1;
  config.sheet_rows = 0;
  run_relight(config, context);
  const auto report = nlohmann::json::parse(read_file(context.output() / "relight" / "report.json"));
  EXPECT_FALSE(report.contains("baked_log_rms")) << report;
  EXPECT_FALSE(context.metrics.contains("baked_log_rms"));
}

// What the dearest settings that pass the check would hold in memory at once.
TEST(RelightOptions, EvenTheDearestFitAnOrdinaryMachine) {
  RelightConfig config;
  const OptionTable table = options_of(config);
  const auto most = [&](const char* option) { return table.find(option)->high.value(); };
  const double cells = 2 * most("bands") * most("bands");
  const double both_sides = 2;
  EXPECT_LT(both_sides * most("points") * cells * sizeof(float), 2e9);          // transport
  EXPECT_LT((2 * most("solver.points") + cells) * cells * sizeof(float), 1e9);  // matrix, weighted copy, normal matrix
  EXPECT_LT(most("panorama_height") * most("panorama_height") * 2 * 100, 1e9);  // rays and their values
  const double cell_bytes = most("sheet_cell_width") * most("sheet_cell_width") * 3;
  EXPECT_LT(2 * 2 * 3 * most("sheet_rows") * cell_bytes, 2e9);  // two sheets of three columns, and their cells
}

TEST(RelightMaterials, RoundTripAndDamage) {
  const TemporaryFolder folder;
  RelightMaterials m;
  m.resize(2);
  m.albedo = {{0.1f, 0.2f, 0.3f}, {0.4f, 0.5f, 0.6f}};
  m.f0 = {{0.04f, 0.05f, 0.06f}, {1, 1, 1}};
  m.roughness = {0.3f, 0}, m.specular_weight = {0.5f, 0.25f}, m.transmission = {0, 1};
  write_relight_materials(folder.path(), m);
  const RelightMaterials back = read_relight_materials(folder.path());
  EXPECT_EQ(back.albedo, m.albedo);
  EXPECT_EQ(back.f0, m.f0);
  EXPECT_EQ(back.roughness, m.roughness);
  EXPECT_EQ(back.specular_weight, m.specular_weight);
  EXPECT_EQ(back.transmission, m.transmission);
  const fs::path path = relight_materials_path(folder.path());
  const std::string good = read_file(path);
  std::string not_a_number = good;
  for (size_t i = good.size() - 4; i < good.size(); ++i) not_a_number[i] = char(0xff);
  for (const std::string& bad :
       {good.substr(0, good.size() - 3), good + "x", std::string("ply\n"), std::string(), not_a_number}) {
    write_file(path, bad);
    EXPECT_EQ(error_of([&] { read_relight_materials(folder.path()); }).kind(), ErrorKind::Input);
  }
}

// A ball that shows the light around it times a copper's reflectance.
class Kettle {
 public:
  static constexpr Vec3f kCopper{0.9f, 0.6f, 0.45f};

  explicit Kettle(const Vec3f& light) : light_(light) {
    scene.surfels.diffuse = capture.layer;
    for (const View& v : capture.views) {
      ImageF photo(v.intrinsics.width, v.intrinsics.height, 3);
      for (size_t i = 0; i < photo.data().size(); ++i) photo.data()[i] = float(v.gain[i % 3]) * kCopper[i % 3] * light[i % 3];
      write_exr_rgb(linear_image_path(capture.sfm(), v), photo, ExrPrecision::Float);
    }
  }
  Metals metals(float masked = 1) const {
    ImageF map(16, 8, 3);
    for (size_t i = 0; i < map.data().size(); ++i) map.data()[i] = light_[i % 3];
    const Environment environment(map);
    return find_metals({.sfm_folder = capture.sfm(),
                        .scene = scene,
                        .views = capture.views,
                        .environment = environment,
                        .mirrors = [&](const View&, const Intrinsics& k) { return ImageF(k.width, k.height, 1, masked); },
                        .cell = 0.05f,
                        .reach = 0.05f});
  }

  test::TinyCapture capture;
  TrainedScene scene;

 private:
  Vec3f light_;
};

TEST(Metals, CopperIsCopperUnderAnyLight) {
  for (const Vec3f& light : {Vec3f{0.5f, 0.5f, 0.5f}, Vec3f{0.3f, 0.5f, 0.9f}}) {
    const Kettle kettle(light);
    const Metals found = kettle.metals();
    ASSERT_EQ(found.metals.size(), 1u);
    const Vec3f tint = found.metals[0].tint;
    EXPECT_NEAR(luminance(tint), 1, 1e-4);
    EXPECT_NEAR(tint.y / tint.x, 0.6 / 0.9, 0.01);
    EXPECT_NEAR(tint.z / tint.x, 0.45 / 0.9, 0.01);
    EXPECT_GT(std::ranges::count(found.of_surfel, 0), std::ptrdiff_t(found.of_surfel.size() / 2));
  }
}

TEST(Metals, WithoutEvidenceThereIsNone) {
  Kettle kettle({0.5f, 0.5f, 0.5f});
  EXPECT_TRUE(kettle.metals(0).metals.empty());
  EXPECT_TRUE(std::ranges::all_of(kettle.metals(0).of_surfel, [](int m) { return m < 0; }));
  // Marked, but it never learnt to reflect.
  std::ranges::fill(kettle.scene.surfels.diffuse.values(Attribute::SpecularWeight), -6.f);
  std::ranges::fill(kettle.scene.surfels.diffuse.values(Attribute::F0), -3.f);
  EXPECT_TRUE(kettle.metals().metals.empty());
  EXPECT_TRUE(std::ranges::all_of(kettle.metals().of_surfel, [](int m) { return m < 0; }));
}

TEST(Metals, ATintKeepsHowMuchIsReflected) {
  const Vec3f tint = Kettle::kCopper / luminance(Kettle::kCopper);
  for (const LayerBlend blend : {LayerBlend::RtrGs, LayerBlend::Layered}) {
    const auto reflection = [&](float k, const Vec3f& f0) {
      return layer_weights<float>(blend, {f0, k, 0, 1}, {.reflection = true}).reflection;
    };
    float k = 0.4f;
    Vec3f f0{0.3f, 0.35f, 0.4f};
    const float before = luminance(reflection(k, f0));
    tint_reflection(blend, tint, k, f0);
    const Vec3f after = reflection(k, f0);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(after[c], before * tint[c], 1e-5);
    float faint = 0.02f;
    f0 = {0.04f, 0.04f, 0.04f};
    tint_reflection(blend, tint, faint, f0);
    EXPECT_EQ(f0, (Vec3f{0.04f, 0.04f, 0.04f}));
    EXPECT_EQ(faint, 0.02f);
    // A bright mirror reflects no more than there is.
    k = 0.9f, f0 = {0.9f, 0.9f, 0.9f};
    tint_reflection(blend, tint, k, f0);
    for (size_t c = 0; c < 3; ++c) EXPECT_LE(reflection(k, f0)[c], 1);
  }
}

TEST(LightGrid, CellsHoldTheirDirectionsAndTileTheSphere) {
  const LightGrid grid{.bands = 6};
  EXPECT_NEAR(grid.solid_angle() * float(grid.cells()), 4 * std::numbers::pi, 1e-4);
  Rng rng(5);
  for (size_t j = 0; j < grid.cells(); ++j)
    for (int k = 0; k < 8; ++k)
      EXPECT_EQ(grid.cell_of(grid.direction(j, 0.01f + 0.98f * rng.uniform(), 0.01f + 0.98f * rng.uniform())), j);
}

// A sheet in the plane z with corners at +-1, vertices of one colour; its front looks up or down.
TriMesh sheet(float z, bool up, const Vec3f& color) {
  TriMesh m;
  m.positions = {{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}};
  m.colors.assign(4, color);
  m.faces = up ? std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}
               : std::vector<std::array<uint32_t, 3>>{{0, 2, 1}, {0, 3, 2}};
  return m;
}

Transport transport_over(const TriMesh& mesh, const std::vector<LitPoint>& points) {
  const Surroundings open{.centre = {},
                          .height = 4,
                          .distance = std::vector<float>(32, 0.f),
                          .radiance = std::vector<Vec3f>(32),
                          .wall = std::vector<bool>(32, false)};
  return transport({.mesh = mesh, .transmission = {}, .around = open, .shell = {}}, points, {.grid = {.bands = 24}},
                   [](double) {});
}

TEST(Transport, LightFromBehindASurfaceDoesNotReachIt) {
  const auto facing = [](const Vec3f& n) { return LitPoint{.normal = n, .inner = true}; };
  const Transport t = transport_over(sheet(0, true, {}), {facing({0, 0, 1}), facing({0, 0, -1})});
  std::vector<Vec3f> above(t.grid.cells()), below(t.grid.cells());
  for (size_t j = 0; j < t.grid.cells(); ++j) (t.grid.direction(j, 0.5f, 0.5f).z > 0 ? above : below)[j] = {1, 2, 3};
  EXPECT_NEAR(t.irradiance(0, above).x, std::numbers::pi, 0.02);
  EXPECT_NEAR(t.irradiance(0, above).z, 3 * std::numbers::pi, 0.06);
  EXPECT_EQ(t.irradiance(0, below), Vec3f{});
  EXPECT_EQ(t.irradiance(1, above), Vec3f{});
}

TEST(Transport, ASheetSendsOnTheLightOfItsFrontToItsFrontOnly) {
  const LitPoint below{.position = {0, 0, -0.05f}, .normal = {0, 0, 1}, .inner = true};
  const Transport lit_below = transport_over(sheet(0, false, {2, 1, 0.5f}), {below});
  EXPECT_NEAR(lit_below.known[0].x, 2 * std::numbers::pi, 0.05);
  EXPECT_EQ(lit_below.inside[0], 0);
  const Transport lit_above = transport_over(sheet(0, true, {2, 1, 0.5f}), {below});
  EXPECT_EQ(lit_above.known[0], Vec3f{});
  EXPECT_GT(lit_above.inside[0], 0.9f);
}

TEST(Spread, TheTwoSidesOfAThinThingKeepTheirOwnLight) {
  constexpr float kThick = 0.01f;
  constexpr int kSide = 12;
  std::vector<LitPoint> points;
  std::vector<Vec3f> light;
  SplatLayer layer(LayerKind::Diffuse, 0, 4 * kSide * kSide);
  for (int i = 0; i < kSide * kSide; ++i)
    for (const bool top : {true, false}) {
      const Vec3f p{0.01f * float(i % kSide), 0.01f * float(i / kSide), top ? kThick : 0.f};
      points.push_back({.position = p, .normal = {0, 0, top ? 1.f : -1.f}, .inner = true});
      light.push_back(top ? Vec3f{5, 5, 5} : Vec3f{1, 1, 1});
      for (const bool turned : {false, true}) {  // which way a surfel's own normal looks means nothing
        const size_t s = 4 * size_t(i) + 2 * top + turned;
        for (size_t c = 0; c < 3; ++c) layer.at(Attribute::Mean, s)[c] = p[c] + (c == 2 ? 0.001f : 0.003f);
        layer.at(Attribute::Rotation, s)[turned ? 1 : 0] = 1;  // half a turn about x
        if (turned) layer.at(Attribute::Rotation, s)[0] = 0;
      }
    }
  Bounds3 box;
  box.extend({-1, -1, -1});
  box.extend({1, 1, 1});
  const std::vector<Vec3f> spread = spread_irradiance(layer, box, points, light, std::vector<bool>(points.size(), true),
                                                      {.inner_radius = 0.01f, .outer_radius = 0.06f});
  for (size_t s = 0; s < spread.size(); ++s) ASSERT_NEAR(spread[s].x, s % 4 >= 2 ? 5 : 1, 1e-4) << s;
}

TEST(PointGrid, AgreesWithASearchThroughAll) {
  Rng rng(3);
  std::vector<Vec3f> points(500);
  for (Vec3f& p : points) p = {rng.uniform(), rng.uniform(), 0.2f * rng.uniform()};
  const PointGrid grid(points, 0.05f);
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3f q{1.2f * rng.uniform(), rng.uniform(), 0.3f * rng.uniform()};
    std::vector<std::pair<float, uint32_t>> all;
    for (size_t i = 0; i < points.size(); ++i)
      if (const float d = squared_length(points[i] - q); d <= 0.09f) all.emplace_back(d, uint32_t(i));
    std::ranges::sort(all);
    std::vector<PointGrid::Near> near;
    grid.nearest(q, 7, 0.3f, near);
    ASSERT_EQ(near.size(), std::min<size_t>(7, all.size()));
    for (size_t k = 0; k < near.size(); ++k) EXPECT_EQ(near[k].index, all[k].second);
  }
}

TEST(Affinity, PairsTheSamePaintAndNoOther) {
  std::vector<Vec3f> positions, radiance;
  Rng rng(9);
  for (int i = 0; i < 300; ++i) {
    positions.push_back({rng.uniform(), rng.uniform(), 0});
    const float light = 0.1f + rng.uniform();
    radiance.push_back(light * (i % 2 ? Vec3f{0.8f, 0.2f, 0.2f} : Vec3f{0.2f, 0.3f, 0.8f}));
  }
  const Affinity a = affinity(positions, radiance, {.radius = 0.2f, .clusters = 4});
  size_t partners = 0;
  for (size_t i = 0; i < positions.size(); ++i)
    for (const Affinity::Partner& p : a.of(i)) {
      EXPECT_EQ(p.point % 2, i % 2);
      ++partners;
    }
  EXPECT_GT(partners, 10 * positions.size());
}

}  // namespace
}  // namespace vitrine
