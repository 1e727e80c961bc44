#include "stages/export/formats/source.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/render/model/kernels/layer_blend.h"
#include "core/render/model/opened_scene.h"
#include "core/render/picture/confidence.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/surfels/activation.h"
#include "stages/export/bake/preview_fit.h"

namespace vitrine {

namespace {

constexpr float kReachEdges = 3;       // largest distance of used surfels from the mesh, in mean edges
constexpr float kPlainRoughness = 1;   // of surfaces without measured reflection
constexpr float kVisible = 1 / 255.f;  // opacity

// Reflectance at normal incidence; glass reflects for any specular weight.
Vec3f reflectance(LayerBlend blend, float specular, const Vec3f& f0, float tau) {
  return layer_weights<float>(blend, {.f0 = f0, .specular = specular, .transmission = tau, .cosine = 1},
                              {.reflection = true, .transmission = true})
      .reflection;
}

// Transmitted share of the light that is not reflected: glTF applies the factor 1 - F itself.
float transmission(LayerBlend blend, float specular, float tau) {
  return layer_weights<float>(blend, {.specular = specular, .transmission = tau}, {.transmission = true}).transmission.x;
}

std::vector<SurfelMaterial> trained_materials(const TrainedScene& scene) {
  const SplatLayer& layer = scene.surfels.diffuse;
  const LayerBlend blend = scene.image.composite.blend;
  const bool reflects = scene.surfels.reflection.size() > 0, transmits = scene.surfels.transmittance.size() > 0;
  std::vector<SurfelMaterial> out(layer.size());
  for (size_t i = 0; i < out.size(); ++i) {
    SurfelMaterial& m = out[i];
    m.f0 = {kDielectricF0, kDielectricF0, kDielectricF0};
    m.roughness = kPlainRoughness;
    const float specular = sigmoid(*layer.at(Attribute::SpecularWeight, i));
    const float tau = transmits ? sigmoid(*layer.at(Attribute::Transmission, i)) : 0;
    if (transmits) m.transmission = transmission(blend, specular, tau);
    if (!reflects) continue;
    const float* raw = layer.at(Attribute::F0, i);
    const Vec3f found = reflectance(blend, specular, {sigmoid(raw[0]), sigmoid(raw[1]), sigmoid(raw[2])}, tau);
    // Roughness is untrained on surfaces that send no rays.
    const float opaque_gate = fresnel_gate(specular), measured = opaque_gate + (1 - opaque_gate) * tau;
    m.f0 = measured * found + (1 - measured) * m.f0;
    m.roughness = measured * sigmoid(*layer.at(Attribute::Roughness, i)) + (1 - measured) * kPlainRoughness;
  }
  return out;
}

std::vector<SurfelMaterial> relit_materials(const DecomposedMaterials& found, LayerBlend blend) {
  std::vector<SurfelMaterial> out(found.size());
  for (size_t i = 0; i < out.size(); ++i)
    out[i] = {found.albedo[i], reflectance(blend, found.specular_weight[i], found.f0[i], found.transmission[i]),
              found.roughness[i], transmission(blend, found.specular_weight[i], found.transmission[i]),
              found.marks.empty() ? Vec3f{} : found.marks[i]};
  return out;
}

TriMesh checked_mesh(const std::filesystem::path& path) {
  TriMesh mesh = read_mesh_ply(path);
  const auto refuse = [&](std::string why) {
    throw Error(ErrorKind::Input, "the mesh cannot be exported",
                {.where = path.string(), .why = std::move(why), .hint = "run the mesh stage again", .code = "BAD_MESH"});
  };
  if (mesh.faces.empty()) refuse("it has no faces");
  constexpr float kFarthest = 1e6f;
  for (const Vec3f& p : mesh.positions)
    for (size_t c = 0; c < 3; ++c)
      if (!(std::abs(p[c]) < kFarthest)) refuse("a vertex is not finite, or absurdly far away");
  bool unit = mesh.normals.size() == mesh.positions.size();
  for (const Vec3f& n : mesh.normals) unit = unit && std::abs(length(n) - 1) < 0.01f;
  if (!unit) mesh.normals = vertex_normals(mesh);
  return mesh;
}

// True if a visible surfel is inside the glass itself.
bool any_inside(const ThickGlass& glass, const SplatLayer& layer) {
  for (size_t i = 0; i < layer.size(); ++i) {
    const float* p = layer.at(Attribute::Mean, i);
    if (sigmoid(*layer.at(Attribute::Opacity, i)) > kVisible && glass.contains({p[0], p[1], p[2]})) return true;
  }
  return false;
}

// Materials of the scene without glass: those of the opaque diffuse surfels; surfels seen only through glass are plain matt.
std::vector<SurfelMaterial> content_materials(std::span<const SurfelMaterial> diffuse, std::span<const uint32_t> opaque,
                                              size_t count) {
  std::vector<SurfelMaterial> out(count, {.f0 = {kDielectricF0, kDielectricF0, kDielectricF0}, .roughness = kPlainRoughness});
  for (size_t i = 0; i < opaque.size(); ++i) out[i] = diffuse[opaque[i]], out[i].transmission = 0;
  return out;
}

std::string place_note(const GeoOrigin& g) {
  return fmt::format(
      "the origin is at latitude {:.7f}, longitude {:.7f}{} (WGS84, by GPS of the photos); +x of rhzu is east, +y north",
      g.latitude, g.longitude, g.altitude ? fmt::format(", altitude {:.1f} m", *g.altitude) : "");
}

}  // namespace

std::vector<View> photo_cameras(const std::filesystem::path& sfm) {
  const ColmapModel model = read_colmap_model(sfm / "sparse" / "0");
  std::vector<View> views;
  for (const ColmapImage& image : model.images)
    views.push_back({image.name, pinhole_part(*model.find_camera(image.camera_id)), image.cam_from_world()});
  return views;
}

const SceneInfo& ExportSource::scene_info() {
  if (!info_) info_ = read_scene_info(inputs_.sfm / "scene.json");
  return *info_;
}

bool ExportSource::metric() { return settings_.scale > 0 || scene_info().metres_per_unit().has_value(); }

ExportFrame ExportSource::frame(ExportAxes axes) {
  double scale = settings_.scale;
  const auto note_once = [this](const std::string& note) {
    if (!note.empty() && std::ranges::find(notes_, note) == notes_.end()) notes_.push_back(note);
  };
  note_once(settings_.scale_note);
  if (place()) note_once(place_note(*place()));
  if (!(scale > 0)) scale = scene_info().metres_per_unit().value_or(1);
  return ExportFrame::of(axes, scale);
}

const ObjectSet& ExportSource::objects() {
  if (!objects_) objects_ = read_objects(inputs_.objects).known();
  return *objects_;
}

std::string ExportSource::object_name(uint16_t id) {
  const Object* object = objects().find(id);
  if (object == nullptr) return id == 0 ? "scene" : fmt::format("object-{}", id);
  std::string name = object->name;
  // Replaces control characters: a name may end a line of a text file.
  std::ranges::replace_if(
      name, [](char c) { return (c >= 0 && c < ' ') || c == 0x7f; }, ' ');
  return name;
}

std::vector<std::string> ExportSource::header_lines(std::vector<std::string> lines) {
  if (diffuse().object_ids().empty()) return lines;
  for (const Object& o : objects().objects)
    lines.push_back(fmt::format("object {}: {}, {}", o.id, object_name(o.id), name(o.role)));
  return lines;
}

const TrainedScene& ExportSource::scene() {
  if (!scene_) scene_ = read_trained_scene(inputs_.optimize, inputs_.refine);
  return *scene_;
}

const TriMesh& ExportSource::mesh() {
  if (mesh_) return *mesh_;
  TriMesh mesh = checked_mesh(inputs_.mesh / "mesh" / "mesh.ply");
  first_behind_glass_ = uint32_t(mesh.positions.size());
  const ThickGlass* solid = scene().image.transmission.thick.get();
  if (const auto path = inputs_.mesh / "mesh" / "behind_glass.ply"; std::filesystem::exists(path)) {
    TriMesh content = checked_mesh(path);
    if (solid && !any_inside(*solid, scene().surfels.transmittance)) content = submesh(content, outside_of(*solid, content));
    if (mesh.colors.empty() != content.colors.empty())
      mesh.colors.clear();
    else
      mesh.colors.insert(mesh.colors.end(), content.colors.begin(), content.colors.end());
    if (mesh.object_ids.empty() != content.object_ids.empty())
      mesh.object_ids.clear();
    else
      mesh.object_ids.insert(mesh.object_ids.end(), content.object_ids.begin(), content.object_ids.end());
    mesh.positions.insert(mesh.positions.end(), content.positions.begin(), content.positions.end());
    mesh.normals.insert(mesh.normals.end(), content.normals.begin(), content.normals.end());
    for (std::array<uint32_t, 3> face : content.faces) {
      for (uint32_t& v : face) v += first_behind_glass_;
      mesh.faces.push_back(face);
    }
  }
  if (solid) solid_ = find_solid_glass(mesh, *solid);
  mesh_ = std::move(mesh);
  return *mesh_;
}

const DecomposedMaterials& ExportSource::decomposed() {
  if (decomposed_) return *decomposed_;
  VITRINE_CHECK(inputs_.decompose, "materials of a stage that did not run were requested");
  decomposed_ = read_decomposed_materials(*inputs_.decompose, scene().surfels);
  return *decomposed_;
}

const std::vector<SurfelMaterial>& ExportSource::materials() {
  if (!materials_)
    materials_ = has_albedo() ? relit_materials(decomposed(), scene().image.composite.blend) : trained_materials(scene());
  return *materials_;
}

std::span<const float> ExportSource::confidence() {
  if (confidence_) return *confidence_;
  confidence_.emplace();
  const auto list = inputs_.optimize / "optimize" / "views.json";
  if (!std::filesystem::exists(list)) return *confidence_;
  const std::vector<View> views = load_view_set(inputs_.sfm, inputs_.optimize).views;
  const ViewSplit split = read_view_split(list, views);
  const std::vector<View> training = at_trained_size(views, split.train, split);
  for (const View& v : training)
    if (!std::filesystem::exists(linear_image_path(inputs_.sfm, v))) return *confidence_;
  ScenePainter painter(scene(), {});
  confidence_ = surfel_confidence(painter, training, [&](const View& v) { return photo_srgb(inputs_.sfm, v, v.intrinsics); });
  return *confidence_;
}

const SurfaceSampler& ExportSource::sampler() {
  if (sampler_) return *sampler_;
  const MaterialSource surface{.surfels = &diffuse(),
                               .materials = materials(),
                               .with_albedo = has_albedo() ? diffuse().size() : 0,
                               .confidence = confidence()};
  if (first_behind_glass() == mesh().positions.size()) {
    sampler_.emplace(surface);
    return *sampler_;
  }
  without_glass(scene().surfels, opened_degrees(scene().surfels, scene().image), content_);
  content_materials_ = content_materials(materials(), content_.opaque, content_.surfels.size());
  const MaterialSource content{
      .surfels = &content_.surfels, .materials = content_materials_, .with_albedo = has_albedo() ? content_.opaque.size() : 0};
  sampler_.emplace(surface, content, first_behind_glass());
  notes_.push_back("what stands behind glass is there, matt" +
                   std::string(has_albedo() ? "; what is seen through glass alone has the photos' light in its colours" : ""));
  return *sampler_;
}

float ExportSource::reach() { return kReachEdges * float(mean_edge_length(mesh())); }

const std::vector<SurfaceSample>& ExportSource::vertex_samples() {
  if (!vertex_samples_) vertex_samples_ = sample_vertices(sampler(), mesh(), reach());
  return *vertex_samples_;
}

const PbrMesh& ExportSource::pbr_mesh() {
  if (pbr_mesh_) return *pbr_mesh_;
  pbr_mesh_ = make_pbr_mesh(mesh(), sampler(), vertex_samples(),
                            {.texture_size = settings_.texture_size, .reach = reach(), .solid = solid_ ? &*solid_ : nullptr});
  notes_.push_back(color_note(*this));
  notes_.push_back(
      fmt::format("{} texels square, {} charts, surfels met in {:.1f} % of the texels on the surface; {} faces are glass",
                  pbr_mesh_->textures.base_color.width(), pbr_mesh_->charts, 100 * pbr_mesh_->covered,
                  pbr_mesh_->count(FaceClass::Pane) + pbr_mesh_->count(FaceClass::SolidGlass)));
  if (pbr_mesh_->has(FaceClass::SolidGlass))
    notes_.push_back(fmt::format("{} of them are solid glass, index of refraction {}, up to {:.3g} thick",
                                 pbr_mesh_->count(FaceClass::SolidGlass), pbr_mesh_->ior,
                                 frame().scale * double(pbr_mesh_->thickness)));
  return *pbr_mesh_;
}

const SplatLayer& ExportSource::preview() {
  if (preview_) return *preview_;
  const std::vector<View> views = photo_cameras(inputs_.sfm);
  if (views.empty())
    throw Error(ErrorKind::Input, "there are no cameras to fit a preview to",
                {.where = inputs_.sfm.string(), .hint = "leave out the previews (`vitrine export --list`)", .code = "NO_VIEWS"});
  PreviewFit fit = fit_preview(scene(), views, {});
  notes_.push_back(
      fmt::format("against the composed pictures: {:.1f} dB, {:.1f} dB before the fit", fit.psnr_after, fit.psnr_before));
  preview_ = std::move(fit.surfels);
  return *preview_;
}

std::string color_note(const ExportSource& source) {
  return source.has_albedo() ? "colours are albedo, found by the decompose stage"
                             : "colours are the diffuse radiance of the photos: their light and shadows are in them";
}

}  // namespace vitrine
