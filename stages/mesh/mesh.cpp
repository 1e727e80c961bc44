#include "stages/mesh/mesh.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/timer.h"
#include "core/render/model/opened_scene.h"
#include "core/render/picture/part_labels.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/mesh/clean_openmesh.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/mesh/repair_cgal.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/mesh/tsdf_volume.h"
#include "stages/mesh/fusion.h"
#include "stages/mesh/watertight.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kSolidVoxels = 0.75;  // vertices within this distance of an optimised solid are moved onto it
constexpr double kMirrorVoxels = 3;    // a surface farther in front of a mirror is another object

Json json_of(const Vec3d& v) { return {v.x, v.y, v.z}; }

Json json_of(const MeshReport& r) {
  return {{"faces", r.faces},
          {"vertices", r.vertices},
          {"edges", r.edges},
          {"manifold_edges", r.manifold_edges},
          {"boundary_edges", r.boundary_edges},
          {"nonmanifold_edges", r.nonmanifold_edges},
          {"boundary_loops", r.boundary_loops},
          {"components", r.components},
          {"largest_component_faces", r.largest_component},
          {"degenerate_faces", r.degenerate_faces},
          {"euler", r.euler},
          {"genus", genus_of(r)},
          {"closed", r.closed()},
          {"area", r.area},
          {"volume", r.volume},
          {"bounds", {{"low", json_of(r.bounds.low)}, {"high", json_of(r.bounds.high)}}}};
}

Json json_of(const RepairReport& r) {
  return {{"duplicate_vertices", r.duplicate_vertices},
          {"dropped_faces", r.dropped_faces},
          {"flipped_components", r.flipped_components},
          {"intersecting_faces", r.intersecting_faces},
          {"filled_holes", r.filled_holes},
          {"filled_faces", r.filled_faces}};
}

// At the training size.
std::vector<View> training_views(const ViewSet& set, const fs::path& optimize) {
  const fs::path list = optimize / "optimize" / "views.json";
  const ViewSplit split = read_view_split(list, set.views);
  if (split.train.empty())
    throw Error(ErrorKind::Input, "no view was trained on",
                {.where = list.string(), .hint = "run the optimize stage again", .code = "BAD_VIEWS"});
  return at_trained_size(set.views, split.train, split);
}

Error nothing_left(std::string why) {
  return Error(ErrorKind::Input, "there is no surface to mesh",
               {.why = std::move(why),
                .hint = "look at optimize/previews; a larger region or a lower clean.min_component may help",
                .code = "NO_SURFACE"});
}

// Rendered depth of the training views.
class RenderedDepth {
 public:
  RenderedDepth(const MeshConfig& config, const SplatLayer& layer, float near_z, const std::vector<View>& views)
      : layer_(layer), near_z_(near_z), views_(views), renderer_(make_renderer(config.backend)) {}

  RgbdFrame operator()(size_t i, double voxel) {
    const View& v = views_[i];
    render(i, FeatureSet::Surface);
    return rgbd_frame(images_, v.intrinsics, v.cam_from_world, voxel);
  }

  // [h,w] 1 where the layer shows more glass than opaque surface.
  std::vector<uint8_t> glass(size_t i) {
    render(i, FeatureSet::Material);
    const std::span<const float> tau = images_.plane(Aov::Transmission), alpha = images_.plane(Aov::Alpha);
    std::vector<uint8_t> out(alpha.size());
    for (size_t p = 0; p < out.size(); ++p) out[p] = alpha[p] >= kLeastDepthAlpha && tau[p] > 0.5f * alpha[p];
    return out;
  }

 private:
  void render(size_t i, FeatureSet features) {
    const View& v = views_[i];
    renderer_->forward(layer_,
                       {.intrinsics = v.intrinsics,
                        .cam_from_world = v.cam_from_world,
                        .features = features,
                        .sh_degree = layer_.sh_degree(),
                        .near_z = near_z_},
                       images_);
  }
  const SplatLayer& layer_;
  float near_z_;
  const std::vector<View>& views_;
  std::unique_ptr<Renderer> renderer_;
  RasterImages images_;
};

TriMesh cleaned(const TriMesh& raw, const MeshConfig& config, StageContext& context, Json& report) {
  const MeshCleanConfig& clean = config.clean;
  const auto step = [&](double fraction, std::string text) {
    throw_if_interrupted();
    context.progress({.fraction = fraction, .text = std::move(text), .values = {}});
  };
  step(0.62, "components");
  TriMesh mesh = without_small_components(raw, {.min_fraction = clean.min_component, .keep_largest = clean.keep_components});
  if (mesh.faces.empty()) throw nothing_left("every component is smaller than clean.min_component");
  step(0.65, fmt::format("repair of {} faces", mesh.faces.size()));
  const RepairDesc repair{.max_hole_edges = static_cast<size_t>(clean.fill_holes)};
  RepairReport first, second;
  mesh = repaired(mesh, repair, &first);
  step(0.8, "smoothing");
  taubin_smooth(mesh, {.iterations = clean.smooth_iterations});
  if (mesh.faces.size() > static_cast<size_t>(config.faces)) {
    step(0.82, fmt::format("decimation of {} faces to {}", mesh.faces.size(), config.faces));
    mesh = decimated(mesh, {.target_faces = static_cast<size_t>(config.faces)});
  }
  step(0.95, "final repair");           // smoothing and collapses may have folded the surface
  mesh.normals = vertex_normals(mesh);  // keeps the orientation
  mesh = repaired(mesh, repair, &second);
  mesh = without_small_components(mesh, {.min_fraction = clean.min_component, .keep_largest = clean.keep_components});
  mesh.normals = vertex_normals(mesh);
  report["repair"] = json_of(first);
  report["final_repair"] = json_of(second);
  return mesh;
}

// Writes mesh/behind_glass.ply if there is content behind glass.
void write_behind_glass(const MeshConfig& config, const TrainedScene& scene, const std::vector<View>& views,
                        const ObjectSet& objects, std::span<const LabelledView> labels, const TriMesh& mesh, FusionDesc fusion,
                        RenderedDepth& shell, StageContext& context, Json& report) {
  OpenedScene content;
  without_glass(scene.surfels, opened_degrees(scene.surfels, scene.image), content);
  RenderedDepth inside(config, content.surfels, scene.image.diffuse.near_z, views);
  TriMesh behind =
      behind_glass({.mesh = mesh,
                    .diffuse = scene.surfels.diffuse,
                    .views = views.size(),
                    .glass_of = [&](size_t i) { return shell.glass(i); },
                    .depth_of = [&](size_t i, double voxel) { return inside(i, voxel); },
                    .fusion = fusion,
                    .voxel = report["voxel"].get<double>(),
                    .min_component = config.clean.min_component,
                    .smooth_iterations = config.clean.smooth_iterations,
                    .faces = std::max<size_t>(static_cast<size_t>(config.faces) / 4, 4)},
                   [&](double f) {
                     throw_if_interrupted();
                     context.progress({.fraction = 0.96 + 0.04 * f, .text = "what stands behind glass", .values = {}});
                   });
  if (behind.faces.empty()) return;
  if (!labels.empty()) {
    behind.object_ids = labels_of_places(
        behind.positions.size(), [&](size_t v) { return cast<double>(behind.positions[v]); }, labels);
    leave_out_thin_glass(objects, behind.object_ids);
  }
  write_mesh_ply(context.output() / "mesh" / "behind_glass.ply", behind);
  report["behind_glass"] = json_of(mesh_report(behind));
  context.metric("faces_behind_glass", static_cast<double>(behind.faces.size()));
}

// The closed mesh, and its comparison with the fused one in report["watertight"]. With method `both`, nothing and a warning where
// there is none.
std::optional<TriMesh> closed_mesh(const MeshConfig& config, const TriMesh& fused, double voxel, StageContext& context,
                                   Json& report) {
  if (config.method == MeshMethod::Fusion) return std::nullopt;
  WatertightReport compared;
  TriMesh mesh;
  try {
    mesh = watertight(
        fused,
        {.voxel = voxel,
         .faces = static_cast<size_t>(config.faces),
         .pieces = {.min_fraction = config.clean.min_component, .keep_largest = config.clean.keep_components},
         .smooth_iterations = config.clean.smooth_iterations},
        [&](double f) {
          throw_if_interrupted();
          context.progress({.fraction = 0.95 + 0.01 * f, .text = "closing the surface", .values = {}});
        },
        compared);
  } catch (const Error& e) {
    if (config.method == MeshMethod::Poisson || e.detail().code != "NOT_CLOSED") throw;
    context.warning("NOT_CLOSED",
                    fmt::format("no watertight.ply: {} ({}); mesh.ply is not affected", e.message(), e.detail().why));
    return std::nullopt;
  }
  Json& r = report["watertight"] = json_of(mesh_report(mesh));
  r["self_intersections"] = self_intersection_count(mesh);
  r["points"] = compared.poisson.points;
  r["seen_from_inside"] = compared.poisson.inwards;
  r["distance_to_fusion"] = compared.to_fused;
  r["distance_from_fusion"] = compared.from_fused;
  r["invented_share"] = compared.invented_share;
  r["fusion"] = json_of(compared.fused);
  log_info(
      "mesh: closed surface of {} faces, genus {}, volume {:.4f}{}; {:.1f} % of its area is farther than {:.0f} voxels from "
      "the fused surface",
      mesh.faces.size(), r["genus"].get<int64_t>(), r["volume"].get<double>(),
      compared.poisson.inwards ? " (seen from inside)" : "", 100 * compared.invented_share, kInventedVoxels);
  return mesh;
}

// Fuses the depth maps and extracts the surface. The volume is freed on return.
TriMesh fused_surface(size_t views, const DepthSource& frame_of, const FusionDesc& desc, const MeshConfig& config,
                      const Timer& clock, StageContext& context, FusionReport& fusion) {
  const TsdfVolume volume = fuse_views(
      views, frame_of, desc,
      [&](double f) {
        throw_if_interrupted();
        context.progress({.fraction = 0.55 * f, .text = f < 0.5 ? "finding the surface" : "fusing depth", .values = {}});
      },
      fusion);
  context.timing("fusion", clock.seconds());
  if (fusion.voxel > desc.volume.voxel)
    context.warning("VOXEL_ENLARGED", fmt::format("voxel {:.5f} instead of {:.5f}, to stay below fusion.memory_mb = {}",
                                                  fusion.voxel, desc.volume.voxel, config.fusion.memory_mb));
  context.progress({.fraction = 0.56, .text = fmt::format("marching cubes over {} blocks", fusion.blocks), .values = {}});
  return iso_surface(volume);
}

}  // namespace

void run_mesh(const MeshConfig& config, StageContext& context) {
  const Timer clock;
  const ViewSet set = load_view_set(context.input("sfm"), context.input("optimize"));
  const std::vector<View> views = training_views(set, context.input("optimize"));
  const TrainedScene scene = read_trained_scene(context.input("optimize"));
  const SplatLayer& layer = scene.surfels.diffuse;
  const Region region = scene_region(set, config.region, glass_and_gloss(layer));
  if (region.points == 0 && config.region.box.empty())
    context.warning("REGION_FROM_CAMERAS",
                    "too few sparse points: the region is the cube between the cameras (mesh.region.box sets it)");
  const double wanted_voxel = config.voxel > 0 ? config.voxel : region.extent() / config.resolution;
  log_info("mesh: {} capture, region {:.3f} x {:.3f} x {:.3f} (scene radius 1), voxel {:.5f} = 1/{:.0f} of its longest side",
           region.convergent ? "convergent" : "wide", region.box.high.x - region.box.low.x, region.box.high.y - region.box.low.y,
           region.box.high.z - region.box.low.z, wanted_voxel, region.extent() / wanted_voxel);

  RenderedDepth rendered(config, layer, scene.image.diffuse.near_z, views);
  const MirrorDepth mirrors(LabelledObjects::trusted(context.optional_input("objects")), scene.image.shape.set.get(), views);
  const auto frame_of = [&](size_t i, double voxel) {
    RgbdFrame frame = rendered(i, voxel);
    mirrors.put(i, frame, kMirrorVoxels * voxel);
    return frame;
  };
  FusionReport fusion;
  const FusionDesc fusion_desc{
      .volume = {.bounds = region.box, .voxel = wanted_voxel, .free_space_weight = config.fusion.free_space_weight},
      .max_bytes = static_cast<size_t>(config.fusion.memory_mb) << 20};
  if (context.max_memory_bytes() > 0 && context.max_memory_bytes() < 2 * fusion_desc.max_bytes)
    throw Error(ErrorKind::Resource, "the memory limit is too low for the volume",
                {.why = fmt::format("fusion.memory_mb {} needs about twice that", config.fusion.memory_mb),
                 .hint = fmt::format("--set mesh.fusion.memory_mb={}", std::max<size_t>(64, context.max_memory_bytes() >> 22)),
                 .code = "OUT_OF_MEMORY"});
  const TriMesh raw = fused_surface(views.size(), frame_of, fusion_desc, config, clock, context, fusion);
  if (raw.faces.empty()) throw nothing_left("the fused field has no zero level inside the region");
  make_folders(context.output() / "mesh");
  write_mesh_ply(context.output() / "mesh" / "mesh_raw.ply", raw);

  Json skipped = Json::array();
  for (size_t i : fusion.skipped_views) skipped.push_back(views[i].name);
  Json report{{"region",
               {{"kind", config.region.box.empty() ? (region.convergent ? "convergent" : "wide") : "given"},
                {"low", json_of(region.box.low)},
                {"high", json_of(region.box.high)},
                {"sparse_points", region.points}}},
              {"voxel", fusion.voxel},
              {"voxels_along_region", region.extent() / fusion.voxel},
              {"truncation", fusion.voxel * fusion_desc.volume.truncation_voxels},
              {"views", views.size() - fusion.skipped_views.size()},
              {"skipped_views", skipped},
              {"blocks", fusion.blocks},
              {"volume_bytes", fusion.bytes},
              {"voxel_updates", fusion.updates},
              {"raw", json_of(mesh_report(raw))}};
  TriMesh mesh = cleaned(raw, config, context, report);
  report["vertices_on_shapes"] = mirrors.put_vertices(mesh, kSolidVoxels * fusion.voxel);
  if (mesh.faces.empty()) throw nothing_left("nothing was left after the repair");
  std::optional<TriMesh> closed = closed_mesh(config, mesh, fusion.voxel, context, report);
  if (config.method == MeshMethod::Poisson) mesh = *std::exchange(closed, std::nullopt);
  const LabelledObjects objects = LabelledObjects::known(context.optional_input("objects"));
  const std::vector<LabelledView> labels = labelled_views(objects, views);
  if (!labels.empty()) mesh.object_ids = labels_of_vertices(mesh, labels);
  write_mesh_ply(context.output() / "mesh" / "mesh.ply", mesh);
  if (closed) {
    if (!labels.empty()) closed->object_ids = labels_of_vertices(*closed, labels);
    write_mesh_ply(context.output() / "mesh" / "watertight.ply", *closed);
  }
  if (scene.surfels.transmittance.size() > 0)
    write_behind_glass(config, scene, views, objects.objects(), labels, mesh, fusion_desc, rendered, context, report);
  const MeshReport final_report = mesh_report(mesh);
  report["mesh"] = json_of(final_report);
  report["mesh"]["self_intersections"] = self_intersection_count(mesh);
  write_file(context.output() / "mesh" / "report.json", report.dump(2) + "\n");
  write_file(context.output() / "mesh" / "grid.json", Json{{"voxel", fusion.voxel}}.dump(2) + "\n");

  context.timing("mesh", clock.seconds());
  context.metric("faces", static_cast<double>(final_report.faces));
  context.metric("components", static_cast<double>(final_report.components));
  context.metric("voxel", fusion.voxel);
  if (!fusion.skipped_views.empty())
    context.warning("VIEWS_SKIPPED",
                    fmt::format("{} of {} views show too little surface", fusion.skipped_views.size(), views.size()));
  context.summary(fmt::format("TSDF voxel {:.4f} (1/{:.0f} of the region)  {}k faces  {} component{}", fusion.voxel,
                              region.extent() / fusion.voxel, (final_report.faces + 500) / 1000, final_report.components,
                              final_report.components == 1 ? "" : "s"));
}

}  // namespace vitrine
