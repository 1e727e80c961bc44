// What each selector finds and what each property does, on two balls whose parts are known.
#include "stages/edit/edit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/render/model/thick_glass.h"
#include "core/render/relight/relit_scene.h"
#include "core/scene/surfels/activation.h"
#include "tests/core/scene/mesh/shapes.h"
#include "tests/stages/edit/two_balls.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/turned_ball.h"

namespace vitrine {
namespace {

using test::RecordingContext;
using test::TwoBalls;

// The original is the same for all tests; each has its own copy on disk nowhere to spoil it.
const TwoBalls& balls() {
  static const TwoBalls scene;
  return scene;
}

class EditStage : public testing::Test {
 protected:
  EditStage() : context_(with_edits()) {}
  std::map<std::string, fs::path> with_edits() const {
    auto inputs = balls().artifacts();
    inputs["edits"] = folder_.path() / "edits.yaml";
    return inputs;
  }
  // `edits`: the list in YAML's flow style.
  RelitScene edited(const std::string& edits) {
    write_file(folder_.path() / "edits.yaml", "edits:\n" + edits);
    run_edit({}, context_);
    const fs::path out = context_.output() / "edited";
    return read_relit_scene({.optimize = out, .mesh = out, .decompose = out});
  }
  Error refused(const std::string& edits) {
    write_file(folder_.path() / "edits.yaml", "edits:\n" + edits);
    const Error e = error_of([&] { run_edit({}, context_); });
    EXPECT_FALSE(fs::exists(context_.output() / "edited")) << "nothing is written";
    return e;
  }
  // Without ball B, of a scene that the refine stage left with these surfels and options.
  TrainedScene without_b(const SplatLayer& refined, const ImageOptions& options) const {
    const fs::path refine = folder_.path() / "refined", decompose = folder_.path() / "decomposed";
    make_folders(refine / "refine/gaussians");
    write_layer(refine / "refine/gaussians/diffuse.ply", refined);
    write_image_options(refine / "refine/model.json", options);
    DecomposedMaterials materials = balls().materials;
    materials.albedo_behind_glass.clear();  // the refined scene has no such layer
    write_decomposed_materials(decompose, materials);
    write_environment(decomposed_environment_path(decompose), Environment(ImageF(8, 4, 3, 1.f)));
    write_file(folder_.path() / "edits.yaml", "edits:\n  - select: {component: 2}\n    delete: true\n");
    auto inputs = with_edits();
    inputs["refine"] = refine, inputs["decompose"] = decompose;
    RecordingContext context(inputs);
    run_edit({}, context);
    return read_trained_scene(context.output() / "edited");
  }
  nlohmann::json report() const { return nlohmann::json::parse(read_file(context_.output() / "edited/report.json")); }
  // Exactly the surfels that `wanted` says have another albedo.
  void expect_tinted(const RelitScene& scene, const std::function<bool(size_t)>& wanted) const {
    size_t wrong = 0;
    ASSERT_EQ(scene.materials.size(), balls().layer.size());
    for (size_t i = 0; i < scene.materials.size(); ++i)
      wrong += (scene.materials.albedo[i] != balls().materials.albedo[i]) != wanted(i);
    EXPECT_EQ(wrong, 0u);
  }

  TemporaryFolder folder_;
  RecordingContext context_;
};

const std::string kTint = "    set: {tint: [0.5, 1, 1]}\n";

TEST_F(EditStage, AClassSelectsWhatThePhotosShowInItsMasks) {
  const RelitScene scene = edited("  - select: {class: specular}\n" + kTint);
  expect_tinted(scene, [](size_t i) { return balls().in_a(i); });  // also the hidden surfel in its middle
  size_t wrong = 0;
  for (size_t v = 0; v < scene.mesh.colors.size(); ++v) wrong += (scene.mesh.colors[v].x < 0.4f) != (v < balls().vertices_a);
  EXPECT_LE(wrong, 4u) << "vertices at the poles of a ball";
}

TEST_F(EditStage, AnObjectIsSelectedByItsName) {
  const RelitScene by_name = edited("  - select: {object: reflecting}\n" + kTint);
  const std::vector<Vec3f> albedo = by_name.materials.albedo;
  expect_tinted(by_name, [](size_t i) { return balls().in_a(i); });
  EXPECT_EQ(edited("  - select: {class: specular}\n" + kTint).materials.albedo, albedo);
}

TEST_F(EditStage, AnObjectThatTheSceneLacksIsNamedWithThoseThatItHas) {
  const Error unknown = refused("  - select: {object: door}\n    delete: true\n");
  EXPECT_EQ(unknown.detail().code, "NO_OBJECT");
  EXPECT_NE(unknown.detail().why.find("its objects are: reflecting"), std::string::npos) << unknown.what();
}

TEST_F(EditStage, ABoxSelectsAPlace) {
  const RelitScene scene = edited("  - select: {box: [0.1, -0.2, 0, 0.4, 0.2, 0.2]}\n" + kTint);
  expect_tinted(scene, [](size_t i) { return balls().in_b(i) && balls().layer.at(Attribute::Mean, i)[2] >= 0; });
  size_t tinted = 0;
  for (size_t i = 0; i < 2 * TwoBalls::kInside; ++i) {
    const bool now =
        scene.trained.surfels.transmittance.at(Attribute::ShDc, i)[0] != balls().behind_glass.at(Attribute::ShDc, i)[0];
    tinted += now;
    EXPECT_EQ(scene.materials.albedo_behind_glass[i], (Vec3f{now ? 0.3f : 0.6f, 0.5f, 0.4f}));
  }
  EXPECT_GT(tinted, 0u) << "what glass shows at that place has a colour, too";
  EXPECT_LE(tinted, TwoBalls::kInside);
}

TEST_F(EditStage, MarksSelectWhereTheirConesMeet) {
  // Ball B as seen from the camera on +y and the one between; behind the first mark nothing else lies, behind the other ball A.
  const auto box_in = [](const View& v, const Vec3d& centre, double radius) {
    const Vec3d c = v.cam_from_world * centre;
    const double x = v.intrinsics.fx * c.x / c.z + v.intrinsics.cx, y = v.intrinsics.fy * c.y / c.z + v.intrinsics.cy;
    const double r = 1.25 * v.intrinsics.fx * radius / c.z;
    return fmt::format("{{photo: {}, box: [{}, {}, {}, {}]}}", v.name, std::max(0., x - r), std::max(0., y - r),
                       std::min(x + r, double(v.intrinsics.width)), std::min(y + r, double(v.intrinsics.height)));
  };
  const auto& views = balls().capture.views;
  const RelitScene scene =
      edited(fmt::format("  - select: {{marks: [{}, {}]}}\n", box_in(views[2], TwoBalls::kB, TwoBalls::kRadiusB),
                         box_in(views[1], TwoBalls::kB, TwoBalls::kRadiusB)) +
             kTint);
  expect_tinted(scene, [](size_t i) { return balls().in_b(i); });
}

TEST_F(EditStage, AComponentOfTheMeshTakesItsSurfelsAlong) {
  const RelitScene scene = edited("  - select: {component: 2}\n" + kTint);
  expect_tinted(scene, [](size_t i) { return balls().in_b(i); });
  for (size_t v = 0; v < scene.mesh.colors.size(); ++v) EXPECT_EQ(scene.mesh.colors[v].x < 0.4f, v >= balls().vertices_a) << v;
  const auto components = report()["components"];
  ASSERT_EQ(components.size(), 2u);
  EXPECT_EQ(components[0]["faces"], balls().faces_a);
  EXPECT_NEAR(components[1]["box"][0].get<double>(), 0.12, 1e-3);
}

TEST_F(EditStage, AllConditionsMustHoldAndExceptLeavesOut) {
  expect_tinted(edited("  - select: {class: specular, box: [-1, -1, 0, 1, 1, 1]}\n" + kTint),
                [](size_t i) { return balls().in_a(i) && balls().layer.at(Attribute::Mean, i)[2] >= 0; });
  expect_tinted(edited("  - select: {except: {class: specular}}\n" + kTint), [](size_t i) { return balls().in_b(i); });
  expect_tinted(edited("  - select: all\n" + kTint), [](size_t i) { return balls().in_a(i) || balls().in_b(i); });  // no sky
}

TEST_F(EditStage, EveryPropertyIsSetInTheMaterialsAndInTheTrainedLayer) {
  const RelitScene scene = edited(
      "  - select: {class: specular}\n"
      "    set: {tint: [0.5, 1, 3], f0: [1, 0.75, 0.25], roughness: 0.2, k_s: 0.7, tau: 0.4}\n");
  for (const size_t i : {size_t(0), TwoBalls::kSurfelsA - 1}) {
    const auto& m = scene.materials;
    EXPECT_EQ(m.albedo[i], (Vec3f{0.3f, 0.5f, 1})) << "no albedo above 1";
    EXPECT_EQ(m.f0[i], (Vec3f{1, 0.75f, 0.25f}));
    EXPECT_EQ(m.roughness[i], 0.2f);
    EXPECT_EQ(m.specular_weight[i], 0.7f);
    EXPECT_EQ(m.transmission[i], 0.4f);
    const SplatLayer& layer = scene.trained.surfels.diffuse;
    EXPECT_NEAR(sigmoid(layer.at(Attribute::F0, i)[0]), 1, 2e-4);
    EXPECT_NEAR(sigmoid(layer.at(Attribute::F0, i)[2]), 0.25, 1e-6);
    EXPECT_NEAR(sigmoid(*layer.at(Attribute::Roughness, i)), 0.2, 1e-6);
    EXPECT_NEAR(sigmoid(*layer.at(Attribute::SpecularWeight, i)), 0.7, 1e-6);
    EXPECT_NEAR(sigmoid(*layer.at(Attribute::Transmission, i)), 0.4, 1e-6);
    for (size_t c = 0; c < 3; ++c) {
      const Vec3f tint{0.5f, 1, 3};
      const float before = 0.5f + kShDc * balls().layer.at(Attribute::ShDc, i)[c];
      EXPECT_NEAR(0.5f + kShDc * layer.at(Attribute::ShDc, i)[c], before * tint[c], 1e-5);
    }
  }
  const size_t b = TwoBalls::kSurfelsA + 5;
  EXPECT_EQ(scene.materials.roughness[b], 0.5f);
  EXPECT_EQ(scene.materials.transmission[b], 0.f);
  EXPECT_EQ(*scene.trained.surfels.diffuse.at(Attribute::Roughness, b), *balls().layer.at(Attribute::Roughness, b));
}

TEST_F(EditStage, PartsScatterLightBelowTheirSurface) {
  const RelitScene scene = edited("  - select: {class: specular}\n    set: {scatter: 0.02, scatter_color: [1, 0.5, 0.25]}\n");
  const std::vector<Vec3f>& scatter = scene.materials.scatter;
  ASSERT_EQ(scatter.size(), scene.materials.size());
  EXPECT_EQ(scatter[0], (Vec3f{0.02f, 0.01f, 0.005f}));
  EXPECT_EQ(scatter[TwoBalls::kSurfelsA + 5], Vec3f{}) << "the other ball is opaque";
}

TEST_F(EditStage, MetalIsBrushedAlongADirectionOrTurnedAroundAnAxis) {
  const RelitScene scene = edited(
      "  - select: {class: specular}\n    set: {brushed: [0, 0, 2], anisotropy: 0.5}\n"
      "  - select: {component: 2}\n    set: {turned: [0, 0, 1]}\n");
  const std::vector<Vec3f>& marks = scene.materials.marks;
  ASSERT_EQ(marks.size(), scene.materials.size());
  EXPECT_EQ(marks[0], (Vec3f{0, 0, 0.5f}));
  for (size_t i = TwoBalls::kSurfelsA; i < TwoBalls::kSurfelsA + TwoBalls::kSurfelsB; i += 17) {
    const float* p = balls().layer.at(Attribute::Mean, i);
    EXPECT_NEAR(length(marks[i]), 0.7, 1e-5);
    EXPECT_NEAR(marks[i].z, 0, 1e-6);
    EXPECT_NEAR(dot(marks[i], Vec3f{p[0] - float(TwoBalls::kB.x), p[1], 0}), 0, 0.01) << "around the ball's axis";
  }
}

TEST_F(EditStage, ScatteringThatTheSceneCannotHaveIsRefused) {
  const auto says = [](const Error& e, const char* what) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_NE(std::string(e.what()).find(what), std::string::npos) << e.what();
  };
  says(refused("  - select: all\n    set: {scatter: 4 mm}\n"), "size of the scene in metres is not known");
  says(refused("  - select: all\n    set: {scatter: 2}\n"), "does not scatter that far");
}

TEST_F(EditStage, WhatIsPaintedBlackIsNoSky) {
  const RelitScene scene = edited("  - select: all\n    set: {tint: 0, f0: 0, k_s: 0}\n");
  for (size_t i = 0; i < scene.materials.size(); ++i)
    EXPECT_EQ(scene.materials.shows_sky(i), balls().materials.shows_sky(i)) << i;
}

TEST_F(EditStage, DeletedPartsAreGoneWithWhatIsInThem) {
  const RelitScene scene = edited("  - select: {class: specular}\n    delete: true\n");
  const size_t left = TwoBalls::kSurfelsB + TwoBalls::kSky;
  ASSERT_EQ(scene.trained.surfels.diffuse.size(), left);
  EXPECT_EQ(scene.materials.size(), left);
  for (size_t c = 0; c < 3; ++c)
    EXPECT_EQ(scene.trained.surfels.diffuse.at(Attribute::Mean, 0)[c], balls().layer.at(Attribute::Mean, TwoBalls::kSurfelsA)[c]);
  EXPECT_EQ(scene.trained.surfels.transmittance.size(), TwoBalls::kInside);
  EXPECT_EQ(scene.materials.albedo_behind_glass.size(), TwoBalls::kInside);
  EXPECT_NEAR(double(scene.mesh.faces.size()), double(balls().mesh.faces.size() - balls().faces_a), 8);
  EXPECT_EQ(report()["edits"][0]["surfels"], TwoBalls::kSurfelsA + TwoBalls::kHidden);
  EXPECT_EQ(report()["edits"][0]["surfels_behind_glass"], TwoBalls::kInside);

  const RelitScene by_component = edited("  - select: {component: 1}\n    delete: true\n");
  EXPECT_EQ(by_component.mesh.faces.size(), balls().mesh.faces.size() - balls().faces_a);
  EXPECT_EQ(by_component.trained.surfels.transmittance.size(), TwoBalls::kInside);
}

TEST_F(EditStage, EditsAreAppliedInTheirOrder) {
  const RelitScene scene = edited(
      "  - select: {class: specular}\n    set: {roughness: 0.9, k_s: 0.3}\n"
      "  - select: {component: 2}\n    delete: true\n"
      "  - select: all\n    set: {roughness: 0.1}\n");
  EXPECT_EQ(scene.materials.roughness[0], 0.1f);
  EXPECT_EQ(scene.materials.specular_weight[0], 0.3f);
  EXPECT_EQ(report()["edits"][2]["surfels"], TwoBalls::kSurfelsA + TwoBalls::kHidden);
}

TEST_F(EditStage, TheSameListGivesTheSameBytesFromUntouchedOriginals) {
  const auto bytes_of = [](const fs::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& e : fs::recursive_directory_iterator(folder))
      if (e.is_regular_file()) files[fs::relative(e.path(), folder).string()] = read_file(e.path());
    return files;
  };
  const auto artifacts = balls().artifacts();
  std::map<std::string, std::map<std::string, std::string>> before;
  for (const auto& [name, path] : artifacts) before[name] = bytes_of(path);
  std::vector<std::map<std::string, std::string>> runs;
  const int threads = thread_limit();
  for (const int limit : {1, 3}) {
    set_thread_limit(limit);
    edited("  - select: {class: specular}\n    set: {tint: 0.5}\n  - select: {component: 2}\n    delete: true\n");
    runs.push_back(bytes_of(context_.output()));
  }
  set_thread_limit(threads);
  EXPECT_EQ(runs[0].size(), 9u);
  EXPECT_TRUE(runs[0] == runs[1]);
  for (const auto& [name, path] : artifacts) EXPECT_TRUE(bytes_of(path) == before[name]) << name;
}

TEST_F(EditStage, ASelectionOfNothingIsAnErrorAtItsLine) {
  const Error far = refused(
      "  - select: all\n    set: {tint: 1}\n  - name: the door\n    select: {box: [5, 5, 5, 6, 6, 6]}\n    delete: true\n");
  EXPECT_EQ(far.kind(), ErrorKind::Input);
  EXPECT_EQ(far.detail().code, "EDIT_SELECTS_NOTHING");
  EXPECT_TRUE(far.detail().where.ends_with("edits.yaml:4:5")) << far.what();
  EXPECT_NE(far.message().find("the door"), std::string::npos);
  EXPECT_NE(far.detail().why.find("box [5, 5, 5]"), std::string::npos);
  EXPECT_NE(far.detail().hint.find("[-0.4, -0.18, -0.18]"), std::string::npos) << far.what();

  const Error gone = refused("  - select: {component: 2}\n    delete: true\n  - select: {component: 2}\n    delete: true\n");
  EXPECT_NE(gone.detail().why.find("still there"), std::string::npos) << gone.what();
  const Error third = refused("  - select: {component: 3}\n    delete: true\n");
  EXPECT_EQ(third.detail().code, "EDIT_SELECTS_NOTHING");
  EXPECT_NE(third.detail().hint.find(fmt::format("1: {} faces in [-0.4, -0.18, -0.18", balls().faces_a)), std::string::npos)
      << third.what();
  EXPECT_NE(third.detail().hint.find("2: "), std::string::npos) << "all there are, or the largest";
  EXPECT_EQ(refused("  - select: all\n    delete: true\n").detail().code, "EDIT_DELETES_ALL");
  const Error masks = refused("  - select: {class: ignore}\n    delete: true\n");
  EXPECT_EQ(masks.detail().code, "NO_MASKS");
  EXPECT_TRUE(masks.detail().where.ends_with("edits.yaml:2:5")) << masks.what();
}

TEST_F(EditStage, AKnownSheetGoesWithItsGlass) {
  SplatLayer glass = balls().layer;
  for (float& v : glass.values(Attribute::Transmission)) v = 2;
  ImageOptions options;
  ShapeSet known;
  for (const auto& [centre, radius] : {std::pair{TwoBalls::kA, TwoBalls::kRadiusA}, {TwoBalls::kB, TwoBalls::kRadiusB}})
    known.entries.push_back({test::turned_ball(centre, radius), ShapeRole::Sheet, 0.06 * double(radius), -1, {}});
  options.shape.set = std::make_shared<const ShapeSet>(known);
  const TrainedScene scene = without_b(glass, options);
  ASSERT_NE(scene.image.shape.set, nullptr);
  ASSERT_EQ(scene.image.shape.set->entries.size(), 1u);
  EXPECT_EQ(std::get<SurfaceOfRevolution>(scene.image.shape.set->entries[0].shape).origin, TwoBalls::kA);
}

TEST_F(EditStage, StartsFromWhatTheRefineStageFound) {
  SplatLayer better = balls().layer;
  for (float& v : better.values(Attribute::ShDc)) v = 0.1f;
  for (float& v : better.values(Attribute::SpecularWeight)) v = 2;
  ImageOptions options;
  options.composite.blend = LayerBlend::RtrGs;
  const size_t all = better.size();
  options.panes.mirrored = all - 3;
  ShapeSet known;
  for (const auto& [centre, radius] : {std::pair{TwoBalls::kA, TwoBalls::kRadiusA}, {TwoBalls::kB, TwoBalls::kRadiusB}}) {
    const auto whole = static_cast<int>(known.entries.size());
    known.entries.push_back({test::turned_ball(centre, radius), ShapeRole::Mirror, 0.06 * double(radius), -1, {}});
    known.entries.push_back(
        {TriangleShape(test::sphere_mesh(radius, centre, 6, 12)), ShapeRole::Mirror, 0.06 * double(radius), whole, {}});
  }
  known.entries.push_back({Box{Mat3d::identity(), {-1, -1, -1}, {1, 1, 1}}, ShapeRole::Sheet, 0.1, -1, {}});
  options.shape.set = std::make_shared<const ShapeSet>(known);
  const TrainedScene scene = without_b(better, options);
  EXPECT_EQ(scene.surfels.diffuse.at(Attribute::ShDc, 0)[0], 0.1f);
  ASSERT_NE(scene.image.shape.set, nullptr);
  ASSERT_EQ(scene.image.shape.set->entries.size(), 3u) << "a shape goes with its specular surfels, and so does its appendage";
  EXPECT_TRUE(scene.image.shape.set->has(ShapeRole::Sheet)) << "a case without a surfel of glass does not";
  EXPECT_EQ(std::get<SurfaceOfRevolution>(scene.image.shape.set->entries[0].shape).origin, TwoBalls::kA);
  EXPECT_EQ(scene.surfels.transmittance.size(), 0u) << "the refined scene has none";
  EXPECT_EQ(scene.image.composite.blend, LayerBlend::RtrGs);
  // The last three surfels are guesses; of those before them, that many are still there.
  size_t guesses = 0;
  for (size_t i = all - 3; i < all; ++i)
    for (size_t k = 0; k < scene.surfels.diffuse.size(); ++k)
      guesses += std::equal(better.at(Attribute::Mean, i), better.at(Attribute::Mean, i) + 3,
                            scene.surfels.diffuse.at(Attribute::Mean, k));
  ASSERT_LT(scene.surfels.diffuse.size(), all);
  EXPECT_EQ(scene.image.panes.mirrored, scene.surfels.diffuse.size() - guesses);
}

// Both balls of solid glass, with a thing in each that glass alone shows.
class EditGlass : public EditStage {
 protected:
  EditGlass() {
    const fs::path mesh = folder_.path() / "mesh", refine = folder_.path() / "refined";
    for (const fs::path& p : {mesh / "mesh", refine / "refine/gaussians"}) make_folders(p);
    write_mesh_ply(mesh / "mesh/mesh.ply", balls().mesh);
    content_ = test::sphere_mesh(kContent, TwoBalls::kA, 6, 12);
    of_a_ = content_.positions.size();
    shapes::append(content_, test::sphere_mesh(kContent, TwoBalls::kB, 6, 12));
    content_.colors.assign(content_.positions.size(), Vec3f{0.5f, 0.5f, 0.5f});
    write_mesh_ply(mesh / "mesh/behind_glass.ply", content_);
    write_layer(refine / "refine/gaussians/diffuse.ply", balls().layer);
    write_layer(refine / "refine/gaussians/transmittance.ply", balls().behind_glass);
    solid(balls().mesh);
    inputs_ = with_edits();
    inputs_["mesh"] = mesh, inputs_["refine"] = refine;
  }
  void solid(const TriMesh& shell) {
    ImageOptions options;
    options.transmission.glass = Glass::Thin;
    options.transmission.thick = std::make_shared<ThickGlass>(shell, 1.4f, 0.02f);
    write_image_options(folder_.path() / "refined/refine/model.json", options);
  }
  fs::path edit(const std::string& edits) {
    write_file(folder_.path() / "edits.yaml", "edits:\n" + edits);
    run_.emplace(inputs_);
    run_edit({}, *run_);
    return run_->output() / "edited";
  }
  static float nearest_x(const TriMesh& mesh) {
    return std::ranges::min(mesh.positions, {}, [](const Vec3f& p) { return p.x; }).x;
  }

  static constexpr double kContent = 0.04;
  TriMesh content_;
  size_t of_a_ = 0;  // vertices
  std::map<std::string, fs::path> inputs_;
  std::optional<RecordingContext> run_;
};

TEST_F(EditGlass, WhatIsDeletedTakesItsSolidGlassAndWhatStandsInItAlong) {
  for (const char* ball_a : {"component: 1", "class: specular", "box: [-0.5, -0.3, -0.3, 0, 0.3, 0.3]"}) {
    const fs::path out = edit(fmt::format("  - select: {{{}}}\n    delete: true\n", ball_a));
    const TriMesh left = read_mesh_ply(out / "mesh/behind_glass.ply");
    EXPECT_EQ(left.faces.size(), content_.faces.size() / 2) << ball_a;
    EXPECT_GT(nearest_x(left), 0) << ball_a;
    const auto glass = read_trained_scene(out).image.transmission.thick;
    ASSERT_NE(glass, nullptr) << ball_a;
    EXPECT_EQ(glass->ior(), 1.4f);
    EXPECT_EQ(glass->tolerance(), 0.02f);
    EXPECT_EQ(glass->mesh().faces.size(), read_mesh_ply(out / "mesh/mesh.ply").faces.size()) << ball_a;
    const auto told = nlohmann::json::parse(read_file(out / "report.json"))["edits"][0];
    EXPECT_EQ(told["behind_glass_vertices"], of_a_) << ball_a;
  }
  solid(test::sphere_mesh(TwoBalls::kRadiusA, TwoBalls::kA, 24, 48));
  const fs::path out = edit("  - select: {component: 1}\n    delete: true\n");
  EXPECT_EQ(read_trained_scene(out).image.transmission.thick, nullptr) << "all that was solid is gone";
  EXPECT_FALSE(fs::exists(out / "optimize/thick_glass.ply"));
}

TEST_F(EditGlass, OtherEditsLeaveItsShapeAndTintWhatStandsThere) {
  const fs::path out = edit("  - select: {box: [0.1, -0.3, -0.3, 0.5, 0.3, 0.3]}\n    set: {tint: [0.2, 1, 1]}\n");
  const TriMesh content = read_mesh_ply(out / "mesh/behind_glass.ply");
  ASSERT_EQ(content.positions.size(), content_.positions.size());
  for (size_t v = 0; v < content.positions.size(); ++v) {
    EXPECT_EQ(content.positions[v], content_.positions[v]);
    EXPECT_EQ(content.colors[v].x < 0.4f, v >= of_a_) << v;
  }
  EXPECT_EQ(read_file(out / "optimize/thick_glass.ply"), read_file(folder_.path() / "refined/refine/thick_glass.ply"));
  // Without colours of their own nothing of it is an edit's to change.
  const fs::path duller = edit("  - select: {class: specular}\n    set: {roughness: 0.9}\n");
  EXPECT_EQ(read_file(duller / "mesh/behind_glass.ply"), read_file(folder_.path() / "mesh/mesh/behind_glass.ply"));
}

TEST_F(EditStage, WorksWithoutMaterialsAndMasks) {
  write_file(folder_.path() / "edits.yaml", "edits:\n  - select: {component: 1}\n" + kTint);
  auto inputs = with_edits();
  inputs.erase("decompose"), inputs.erase("masks"), inputs.erase("objects");
  RecordingContext context(inputs);
  run_edit({}, context);
  EXPECT_FALSE(fs::exists(context.output() / "edited/decompose"));
  const TrainedScene scene = read_trained_scene(context.output() / "edited");
  EXPECT_NE(scene.surfels.diffuse.at(Attribute::ShDc, 0)[0], balls().layer.at(Attribute::ShDc, 0)[0]);
  write_file(folder_.path() / "edits.yaml", "edits:\n  - select: {class: specular}\n" + kTint);
  EXPECT_EQ(error_of([&] { run_edit({}, context); }).detail().code, "NO_MASKS");
}

}  // namespace
}  // namespace vitrine
