#include "stages/decompose/decompose.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/timer.h"
#include "core/foundation/math/kd_tree.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/surfel_colors.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/light/environment.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/surfels/activation.h"
#include "stages/decompose/grey_card.h"
#include "stages/decompose/light_solver.h"
#include "stages/decompose/lit_points.h"
#include "stages/decompose/metals.h"
#include "stages/decompose/outputs.h"
#include "stages/decompose/transport.h"
#include "stages/decompose/wall_extension.h"

namespace vitrine {

namespace {

constexpr float kMaxInside = 0.5f;    // share of rays that meet back sides; above it the point is below the surface
constexpr float kMaxSpecular = 0.3f;  // points that are more specular or transmissive are not used for the light
constexpr float kMaxMasked = 0.5f;
constexpr float kDarkestTold = 0.004f, kBrightestTold = 0.95f;  // usable radiance range of an 8-bit photo
constexpr double kOuterFactor = 6, kOuterPoints = 20000;        // size outer voxels for at most this many points on the walls
constexpr float kTrainedGloss = 0.05f;                          // specular weight from which the Fresnel term is fully trained
constexpr float kLeastMasked = 0.1f;                            // of a point's pixels
constexpr size_t kFewestPoints = 64;
constexpr double kTrainedShare = 0.5;  // of a card's box: with more overlap the scene contains the card
constexpr double kPolishReach = 6;     // edges of the mesh, between specular faces and their surfels

class Decomposition {
 public:
  Decomposition(const DecomposeConfig& config, StageContext& context)
      : config_(config),
        context_(context),
        scene_(read_trained_scene(context.input("optimize"), context.optional_input("refine"))),
        objects_(LabelledObjects::trusted(context.optional_input("objects"))) {
    const ViewSet set = load_view_set(context.input("sfm"), context.input("optimize"));
    all_views_ = set.views;
    for (const ScenePoint& p : set.points) sparse_.push_back(cast<float>(p.position));
    const ViewSplit split = read_view_split(context.input("optimize") / "optimize" / "views.json", set.views);
    object_alone_ = split.object_alone;
    views_ = at_trained_size(set.views, split.train.empty() ? split.heldout : split.train, split);
    if (!config.grey_card.empty()) card_ = card_box(config.grey_card, all_views_);
    mesh_ = read_shadow_mesh(context.input("mesh"));
    const double area = area_of(mesh_);
    for (const Vec3f& p : mesh_.positions) box_.extend(cast<double>(p));
    const Vec3d margin = 0.02 * (box_.high - box_.low) + Vec3d{1e-3, 1e-3, 1e-3};
    box_.low = box_.low - margin;
    box_.high = box_.high + margin;
    voxel_ = std::sqrt(area / config.points);
    outer_voxel_ = kOuterFactor * std::sqrt(area / std::min(double(config.points), kOuterPoints));
    edge_ = std::sqrt(2 * area / double(mesh_.faces.size()));
  }

  void run() {
    gather();
    trace();
    solve();
    spread();
    write();
  }

 private:
  void step(double fraction, std::string text) {
    throw_if_interrupted();
    context_.progress({.fraction = fraction, .text = std::move(text), .values = {}});
  }

  void gather() {
    const Timer clock;
    sky_distance_ = config_.sky_distance > 0 ? float(config_.sky_distance) : distance_to_sky(sparse_, box_);
    LitPointsDesc desc = points_desc();
    desc.masked = [&](const View& v, const Intrinsics& k) { return marked(v, k); };
    points_ = lit_points(layer(), views_, desc, [&](double f) { step(0.2 * f, "surface points"); });
    if (points_.size() < kFewestPoints)
      throw Error(ErrorKind::Input, "the views show too little surface to find the light",
                  {.why = fmt::format("{} points", points_.size()),
                   .hint = "look at optimize/previews; more points: decompose.points",
                   .code = "NO_SURFACE"});
    around_ =
        surroundings(scene_.surfels.diffuse, {.inner = box_, .height = config_.panorama_height, .sky_distance = sky_distance_});
    shell_ = around_.shell();
    context_.timing("points", clock.seconds());
  }

  LitPointsDesc points_desc() const {
    return {.inner = box_,
            .voxel = voxel_,
            .outer_factor = outer_voxel_ / voxel_,
            .max_side = config_.max_side,
            .near_z = scene_.image.diffuse.near_z,
            .sky_distance = sky_distance_};
  }
  TransportDesc rays_desc() const {
    return {.grid = {.bands = size_t(config_.bands)},
            .reach = float(3 * edge_),
            .offset = float(0.1 * edge_),
            .outer_offset = float(outer_voxel_),
            .seed = uint64_t(config_.seed)};
  }
  SpreadDesc spread_desc() const { return {.inner_radius = float(voxel_), .outer_radius = float(outer_voxel_)}; }

  bool shows_sky(const SplatLayer& of, size_t surfel) const {
    const float* p = of.at(Attribute::Mean, surfel);
    return length(Vec3f{p[0], p[1], p[2]} - around_.centre) > sky_distance_;
  }

  void trace() {
    const Timer clock;
    if (scene_.surfels.transmittance.size() > 0) clear_ = transmission_of(mesh_, points_, voxel_);
    transport_ = transport({.mesh = mesh_, .transmission = clear_, .around = around_, .shell = shell_}, points_, rays_desc(),
                           [&](double f) { step(0.2 + 0.4 * f, fmt::format("light that reaches {} points", points_.size())); });
    for (const float share : transport_.inside) usable_.push_back(share < kMaxInside);
    context_.timing("rays", clock.seconds());
  }

  void solve() {
    const Timer clock;
    step(0.6, "light and albedo by turns");
    std::vector<uint32_t> speaking;
    for (size_t i = 0; i < points_.size(); ++i) {
      const LitPoint& p = points_[i];
      const float brightest = std::max({p.radiance.x, p.radiance.y, p.radiance.z});
      if (p.inner && usable_[i] && p.specular_weight < kMaxSpecular && p.transmission < kMaxSpecular && p.masked < kMaxMasked &&
          brightest < kBrightestTold && luminance(p.radiance) > kDarkestTold)
        speaking.push_back(uint32_t(i));
    }
    if (speaking.size() < kFewestPoints) {
      context_.warning("FEW_DULL_POINTS",
                       fmt::format("only {} of {} surface points are dull and well exposed: all take part, and the "
                                   "light is a guess (are the photos over- or underexposed?)",
                                   speaking.size(), points_.size()));
      speaking.resize(points_.size());
      for (size_t i = 0; i < points_.size(); ++i) speaking[i] = uint32_t(i);
    }
    const size_t wanted = std::min(speaking.size(), size_t(config_.solver_points));
    for (size_t i = 0; i < wanted; ++i) chosen_.push_back(speaking[i * speaking.size() / wanted]);
    std::vector<Vec3f> positions, radiance;
    for (const uint32_t i : chosen_) positions.push_back(points_[i].position), radiance.push_back(points_[i].radiance);
    const double spacing = std::sqrt(area_of(mesh_) / double(wanted));
    const Affinity partners = affinity(positions, radiance, {.radius = float(4 * spacing), .seed = uint64_t(config_.seed)});
    solution_ = solve_light({.transport = transport_, .points = points_, .chosen = chosen_, .affinity = partners},
                            {.rounds = config_.solver_rounds, .white = float(config_.white_albedo)});
    horizon_ = mirrored_horizon(scene_.surfels.reflection, points_);
    walls_ = extended_walls(around_, transport_.grid, solution_.light, solution_.free, horizon_.value_or(1.f));
    context_.timing("light", clock.seconds());
  }

  void spread() {
    step(0.8, "albedo of the surfels");
    const SplatLayer& layer = scene_.surfels.diffuse;
    std::vector<Vec3f> irradiance(points_.size());
    for (size_t i = 0; i < points_.size(); ++i) irradiance[i] = transport_.irradiance(i, solution_.light);
    irradiance_ = spread_irradiance(layer, box_, points_, irradiance, usable_, spread_desc());
    std::vector<Vec3f> eyes;
    for (const View& v : views_) eyes.push_back(cast<float>(v.centre_in_world()));
    const std::vector<Vec3f> radiance = surfel_radiance(layer, eyes);
    materials_.resize(layer.size());
    const bool reflects = scene_.surfels.reflection.size() > 0, transmits = scene_.surfels.transmittance.size() > 0;
    for (size_t i = 0; i < layer.size(); ++i) {
      for (size_t c = 0; c < 3; ++c) {
        materials_.albedo[i][c] = albedo_of(radiance[i][c], irradiance_[i][c]);
        materials_.f0[i][c] = sigmoid(layer.at(Attribute::F0, i)[c]);
      }
      // Without a reflection layer the initial values are not measurements: use matt and opaque.
      materials_.roughness[i] = reflects ? sigmoid(*layer.at(Attribute::Roughness, i)) : 1.f;
      materials_.specular_weight[i] = reflects ? sigmoid(*layer.at(Attribute::SpecularWeight, i)) : 0.f;
      materials_.transmission[i] = transmits ? sigmoid(*layer.at(Attribute::Transmission, i)) : 0.f;
      if (shows_sky(layer, i)) materials_.albedo[i] = materials_.f0[i] = {}, materials_.specular_weight[i] = 0;
    }
    if (reflects) dull_unmarked();
    polish(radiance);
    look_behind_glass(eyes);
    if (card_) match_card(radiance);
    for (auto* albedo : {&materials_.albedo, &materials_.albedo_behind_glass})
      for (Vec3f& rho : *albedo)
        for (size_t c = 0; c < 3; ++c) rho[c] = std::min(kMaxAlbedo, rho[c]);
  }

  static float albedo_of(float radiance, float irradiance) {
    return std::max(0.f, std::numbers::pi_v<float> * radiance / std::max(1e-4f, irradiance));
  }

  void look_behind_glass(std::span<const Vec3f> eyes) {
    const SplatLayer& inside = scene_.surfels.transmittance;
    if (inside.size() == 0) return;
    const fs::path content = context_.input("mesh") / "mesh" / "behind_glass.ply";
    const std::vector<Vec3f> irradiance =
        irradiance_behind_glass({.scene = scene_,
                                 .views = views_,
                                 .first = {.mesh = mesh_, .transmission = clear_, .around = around_, .shell = shell_},
                                 .content = fs::exists(content) ? read_mesh_ply(content) : TriMesh(),
                                 .light = solution_.light,
                                 .points = points_desc(),
                                 .rays = rays_desc(),
                                 .spread = spread_desc()},
                                [&](double f) { step(0.8 + 0.1 * f, "what stands behind glass"); });
    if (irradiance.empty()) return;
    const std::vector<Vec3f> radiance = surfel_radiance(inside, eyes);
    materials_.albedo_behind_glass.resize(inside.size());
    for (size_t i = 0; i < inside.size(); ++i)
      for (size_t c = 0; c < 3 && !shows_sky(inside, i); ++c)
        materials_.albedo_behind_glass[i][c] = albedo_of(radiance[i][c], irradiance[i][c]);
  }

  // Outside glass and mirror masks, small specular weights are noise and their f0 is untrained: at grazing angles they would be
  // visible under another light.
  void dull_unmarked() {
    const bool marked = std::ranges::any_of(points_, [](const LitPoint& p) { return p.masked > kLeastMasked; });
    if (!marked) return;
    std::vector<Vec3f> positions;
    for (const LitPoint& p : points_) positions.push_back(p.position);
    const KdTreef tree(positions);
    std::vector<KdTreef::Near> near;
    for (size_t i = 0; i < materials_.size(); ++i) {
      if (materials_.specular_weight[i] >= kTrainedGloss || materials_.transmission[i] > kMaxSpecular) continue;
      const float* p = layer().at(Attribute::Mean, i);
      tree.nearest({p[0], p[1], p[2]}, 1, float(2 * outer_voxel_), near);
      if (near.empty() || points_[near[0].index].masked <= kLeastMasked) materials_.specular_weight[i] = 0;
    }
  }

  // Sets the materials of mirrors and coats (metals.h).
  void polish(const std::vector<Vec3f>& radiance) {
    const fs::path sfm = context_.input("sfm");
    const Environment light(environment());
    const Metals found = find_metals({.sfm_folder = sfm,
                                      .scene = scene_,
                                      .mesh = mesh_,
                                      .views = views_,
                                      .environment = light,
                                      .objects = objects_,
                                      .max_side = config_.max_side,
                                      .reach = float(kPolishReach * edge_)});
    reflectors_ = found.reflectors;
    apply_reflectors(found, scene_, radiance, materials_);
  }

  // `scene`: radiances of the surfels. `small`: the view at the size of the rendered pictures.
  Vec3f albedo_in_photo(const View& view, const View& small, std::span<const Vec3f> scene) {
    const fs::path sfm = context_.input("sfm");
    const CardInPhoto found =
        albedo_of_card(*card_, view,
                       {.photo = read_exr_rgb(linear_image_path(sfm, view)),
                        .rendered = SurfelColors(layer(), scene, scene_.image.diffuse.near_z).picture(small),
                        .light = Environment(environment()).irradiance(up_in_photo(view, all_views_, read_passes(sfm)))});
    if (const auto& drift = found.drift)
      context_.warning(
          "PHOTO_GAIN",
          fmt::format("the object in {} has {:.2f} {:.2f} {:.2f} times the colour that the gain of the photo gives it: "
                      "gains of the sfm stage drift, and colours of the trained scene may",
                      view.name, drift->x, drift->y, drift->z));
    return found.albedo;
  }

  // Scales the unclamped albedos: a surface above white by the convention may be grey.
  void match_card(std::span<const Vec3f> radiance) {
    View view = all_views_[card_->view];
    view.intrinsics = view.intrinsics.limited_to(2 * config_.max_side);
    const ImageF picture = SurfelColors(layer(), materials_.albedo, scene_.image.diffuse.near_z).picture(view);
    const View& shown_in = all_views_[card_->view];
    const double shown = shown_share(*card_, shown_in, picture);
    card_outside_scene_ = object_alone_ ? shown < kTrainedShare : shown == 0;
    const Vec3f found = card_outside_scene_ ? albedo_in_photo(shown_in, view, radiance) : median_in(*card_, shown_in, picture);
    for (size_t c = 0; c < 3; ++c) card_gain_[c] = float(config_.grey_albedo) / found[c];
    for (auto* albedo : {&materials_.albedo, &materials_.albedo_behind_glass})
      for (Vec3f& rho : *albedo) rho = hadamard(rho, card_gain_);
    for (Vec3f& e : irradiance_)
      for (size_t c = 0; c < 3; ++c) e[c] /= card_gain_[c];
    for (Vec3f& l : solution_.light)
      for (size_t c = 0; c < 3; ++c) l[c] /= card_gain_[c];
  }

  ImageF environment() const { return environment_map(around_, transport_.grid, solution_, card_gain_); }

  void write() {
    step(0.9, "pictures and files");
    const fs::path& out = context_.output();
    make_folders(out / "decompose");
    write_decomposed_materials(out, materials_);
    write_environment(decomposed_environment_path(out), Environment(environment()));
    if (!shell_.faces.empty())
      write_mesh_ply(decomposed_surroundings_path(out), painted_shell(walls_, layer(), irradiance_, float(4 * outer_voxel_)));
    const fs::path sfm = context_.input("sfm");
    const std::optional<double> baked = write_decompose_pictures({.sfm_folder = sfm,
                                                                  .output = out,
                                                                  .layer = layer(),
                                                                  .near_z = scene_.image.diffuse.near_z,
                                                                  .albedo = materials_.albedo,
                                                                  .irradiance = irradiance_,
                                                                  .views = views_,
                                                                  .rows = config_.sheet_rows});
    nlohmann::ordered_json report = report_of({.config = config_,
                                               .points = points_,
                                               .usable = usable_,
                                               .solved_with = chosen_.size(),
                                               .voxel = voxel_,
                                               .solution = solution_,
                                               .around = around_,
                                               .shell_faces = shell_.faces.size(),
                                               .sky_distance = sky_distance_,
                                               .walls = walls_,
                                               .horizon = horizon_,
                                               .card_outside_scene = card_outside_scene_});
    if (!materials_.albedo_behind_glass.empty()) report["surfels_behind_glass"] = materials_.albedo_behind_glass.size();
    if (baked) report["baked_log_rms"] = *baked;
    for (const Reflector& p : reflectors_)
      if (p.pixels > 0)
        report["objects"].push_back({{"id", p.object},
                                     {"kind", p.metal ? "mirror" : "coat"},
                                     {"reflectance", {p.reflectance.x, p.reflectance.y, p.reflectance.z}},
                                     {"roughness", p.roughness ? nlohmann::ordered_json(*p.roughness) : nlohmann::ordered_json()},
                                     {"pixels", p.pixels}});
    write_file(out / "decompose" / "report.json", report.dump(2) + "\n");
    context_.metric("misfit_log_rms", solution_.misfit.back());
    context_.metric("light_known_share", solution_.known_share);
    if (baked) context_.metric("baked_log_rms", *baked);
    const auto free = std::ranges::count(solution_.free, true);
    if (free == 0)
      context_.warning("NO_OPEN_LIGHT", "no surface point looks past the mesh and its surroundings: all light counts as known");
    if (solution_.scale_by_bounces)
      context_.warning("ALBEDO_SCALE", "bounced light alone is brighter than the wanted scale of the albedo allows");
    context_.summary(fmt::format("{}k points, {} of {} light cells solved, {:.0f} % of the light bounced or seen; albedo by {}",
                                 (points_.size() + 500) / 1000, free, solution_.light.size(), 100 * solution_.known_share,
                                 card_outside_scene_ ? "grey card in the photo"
                                 : card_             ? "grey card"
                                                     : "convention"));
  }

  const SplatLayer& layer() const { return scene_.surfels.diffuse; }
  ImageF marked(const View& v, const Intrinsics& k) const {
    return objects_.coverage(v, k, [](const Object& o) { return is_specular(o.role); });
  }

  const DecomposeConfig& config_;
  StageContext& context_;
  TrainedScene scene_;
  const LabelledObjects objects_;
  std::vector<View> all_views_, views_;
  std::optional<GreyCard> card_;
  TriMesh mesh_;
  Bounds3 box_;
  std::vector<Vec3f> sparse_;
  double voxel_ = 0, outer_voxel_ = 0, edge_ = 0;
  float sky_distance_ = 0;
  std::vector<float> clear_;  // [vertices of the mesh] transmission; empty: no glass
  std::vector<LitPoint> points_;
  std::vector<bool> usable_;
  Surroundings around_;
  TriMesh shell_;
  Transport transport_;
  std::vector<uint32_t> chosen_;
  LightSolution solution_;
  std::optional<float> horizon_;
  ExtendedWalls walls_;
  std::vector<Vec3f> irradiance_;
  DecomposedMaterials materials_;
  std::vector<Reflector> reflectors_;
  bool object_alone_ = false, card_outside_scene_ = false;  // the card is measured in the photo, outside the scene
  Vec3f card_gain_{1, 1, 1};
};

}  // namespace

void run_decompose(const DecomposeConfig& config, StageContext& context) { Decomposition(config, context).run(); }

}  // namespace vitrine
