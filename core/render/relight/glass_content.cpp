#include "core/render/relight/glass_content.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/render/model/opened_scene.h"
#include "core/render/model/sheet_pass.h"

namespace vitrine {

namespace {

constexpr int kFluenceSamples = 48, kPatchSamples = 192;
constexpr float kAbove = 0.3f;       // in grains: offset of rays above a surface behind glass
constexpr float kMostBrighter = 50;  // maximum ratio of new to old light; larger ones at dark places are noise
constexpr float kLeastFluence_rel = 1e-3f;
constexpr float kGlassReach = 3;  // in grains: distance up to which a surfel belongs to the mesh
constexpr float kBeyond = 1;      // in grains: offset of rays behind thick glass, clear of the mesh it was smoothed from
constexpr size_t kTask = 64;      // surfels
constexpr uint64_t kDiffuseStream = uint64_t(1) << 40;

void set_color(SplatLayer& layer, size_t i, const Vec3f& color) {
  for (size_t c = 0; c < 3; ++c) layer.at(Attribute::ShDc, i)[c] = (color[c] - 0.5f) / kShDc;
}

}  // namespace

GlassContent::GlassContent(const RelitScene& scene, const SceneSurface& surface)
    : scene_(&scene), surface_(&surface), renderer_(make_renderer(Backend::Cpu)) {
  const ImageOptions& image = scene.trained.image;
  if (scene.trained.surfels.transmittance.size() == 0 && !draws_sheets(image)) return;
  SplatScene parts{.diffuse = material_layer(scene), .transmittance = scene.trained.surfels.transmittance};
  if (image.transmission.glass != Glass::Thin) parts.diffuse.resize(0);
  OpenedScene opened;
  without_glass_with_materials(parts, {.diffuse = 0, .transmittance = parts.transmittance.sh_degree()}, opened);
  opaque_ = std::move(opened.opaque);
  merged_ = std::move(opened.surfels);
  if (image.transmission.thick) matt_ = merged_;
  if (!scene.behind_glass.faces.empty()) content_mesh_.emplace(scene.behind_glass);
  const SplatLayer& inside = scene.trained.surfels.transmittance;
  for (size_t i = 0; i < inside.size(); ++i)
    for (size_t c = 0; c < 3; ++c) middle_[c] += inside.at(Attribute::Mean, i)[c] / float(inside.size());
}

// Black marks the sky behind glass, which has no albedo (core/render/picture/decomposed_materials.h).
bool GlassContent::knows_albedo(size_t inside) const {
  const std::vector<Vec3f>& albedo = scene_->materials.albedo_behind_glass;
  return !albedo.empty() && albedo[inside] != Vec3f{};
}

std::vector<Vec3f> GlassContent::fluence(const LitScene& lit) const {
  const SplatLayer& inside = scene_->trained.surfels.transmittance;
  std::vector<Vec3f> out(inside.size());
  parallel_for(out.size(), kTask, [&](size_t i) {
    throw_if_interrupted();
    if (knows_albedo(i)) return;
    const float* m = inside.at(Attribute::Mean, i);
    out[i] = lit.fluence({m[0], m[1], m[2]}, i, kFluenceSamples);
  });
  return out;
}

// Irradiance / pi of the mesh at the surfel; the fluence if the surfel is off the mesh.
Vec3f GlassContent::arriving_at(const LitScene& lit, size_t surfel) const {
  const SplatLayer& layer = scene_->trained.surfels.diffuse;
  const float *m = layer.at(Attribute::Mean, surfel), *q = layer.at(Attribute::Rotation, surfel);
  const Vec3f mean{m[0], m[1], m[2]}, normal = rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]})).c2;
  const float reach = kGlassReach * surface_->grain();
  for (const Vec3f& n : {normal, -normal})
    if (const auto place = lit.surface().front_near(mean + reach * n, -n, 2 * reach))
      return lit.surface().at(lit.irradiance(), *place) / std::numbers::pi_v<float>;
  return lit.fluence(mean, kDiffuseStream + surfel, kFluenceSamples);
}

// Irradiance / pi of the front of a surfel. On the mesh behind glass: its side, with the shadow of that mesh. Off that mesh: the
// side facing away from the centroid of the layer.
Vec3f GlassContent::arriving_inside(const LitScene& lit, size_t inside) const {
  const SplatLayer& layer = scene_->trained.surfels.transmittance;
  const float *m = layer.at(Attribute::Mean, inside), *q = layer.at(Attribute::Rotation, inside);
  const Vec3f mean{m[0], m[1], m[2]}, normal = rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]})).c2;
  const float reach = kGlassReach * surface_->grain();
  float nearest = reach;
  std::optional<LitScene::Patch> front;
  for (const Vec3f& n : {normal, -normal}) {
    if (!content_mesh_) break;
    const auto hit = content_mesh_->first_face(mean + reach * n, -n, 0, 2 * reach);
    if (!hit || hit->from_inside || !(std::abs(hit->t - reach) < nearest)) continue;
    nearest = std::abs(hit->t - reach);
    front = {mean + (reach - hit->t + kAbove * surface_->grain()) * n, n};
  }
  const auto blocked = [&](const Vec3f& direction) {
    return front && content_mesh_->occluded(front->point, direction, 0, MeshHits::kFar);
  };
  const LitScene::Patch patch = front.value_or(LitScene::Patch{mean, dot(normal, mean - middle_) > 0 ? normal : -normal});
  return lit.irradiance_in_the_open(patch, blocked, inside, kPatchSamples);
}

void GlassContent::relight(const LitScene& lit, const LitSceneDesc& desc) {
  if (empty()) return;
  if (fluence_before_.empty()) {
    const Lighting captured{.environment = scene_->captured, .points = {}, .directionals = {}, .areas = {}};
    fluence_before_ = fluence(LitScene(*surface_, captured, desc));
  }
  tracer_.reset();
  const std::vector<Vec3f> now = fluence(lit);
  parallel_for(opaque_.size(), kTask, [&](size_t k) {
    throw_if_interrupted();
    const Vec3f light = arriving_at(lit, opaque_[k]);
    const RelitMaterial material = scene_->material(opaque_[k]);
    set_color(merged_, k, hadamard(light, scattered_reflectance(scene_->blend(), material)));
    if (matt_.size() > 0) set_color(matt_, k, hadamard(light, bounce_reflectance(scene_->blend(), material)));
  });
  const SplatLayer& inside = scene_->trained.surfels.transmittance;
  const Vec3f mean = scene_->captured.mean();
  const float least = kLeastFluence_rel * (mean.x + mean.y + mean.z) / 3 + 1e-12f;
  const std::vector<Vec3f>& albedo = scene_->materials.albedo_behind_glass;
  parallel_for(inside.size(), kTask, [&](size_t i) {
    throw_if_interrupted();
    const size_t to = opaque_.size() + i, width = inside.width(Attribute::ShRest);
    const bool known = knows_albedo(i);
    if (known) set_color(merged_, to, hadamard(albedo[i], arriving_inside(lit, i)));
    for (size_t k = 0; known && k < width; ++k) merged_.at(Attribute::ShRest, to)[k] = 0;
    for (size_t c = 0; !known && c < 3; ++c) {
      const float ratio = std::min((now[i][c] + least) / (fluence_before_[i][c] + least), kMostBrighter);
      merged_.at(Attribute::ShDc, to)[c] = (ratio * (0.5f + kShDc * inside.at(Attribute::ShDc, i)[c]) - 0.5f) / kShDc;
      for (size_t k = c; k < width; k += 3) merged_.at(Attribute::ShRest, to)[k] = ratio * inside.at(Attribute::ShRest, i)[k];
    }
    if (matt_.size() == 0) return;
    for (const Attribute a : {Attribute::ShDc, Attribute::ShRest})
      std::copy_n(merged_.at(a, to), merged_.width(a), matt_.at(a, to));
  });
}

void GlassContent::look(const Frame& frame, std::span<const uint32_t> requesting) {
  const TransmissionOptions& options = scene_->trained.image.transmission;
  RasterDesc desc;
  desc.intrinsics = frame.view->intrinsics;
  desc.cam_from_world = frame.view->cam_from_world;
  desc.features = FeatureSet::Material;
  desc.sh_degree = merged_.sh_degree();
  desc.near_z = scene_->trained.image.diffuse.near_z;
  picture_.view = frame.view;
  renderer_->forward(merged_, desc, picture_.diffuse);
  content_.emplace(picture_);
  bent_.clear();
  if (!options.thick) return;
  std::vector<GlassPath> path(frame.pixel_count(), GlassPath::Straight);
  legs_.find(*options.thick, frame, requesting, path);
  bent_.assign(path.size(), 0);
  if (legs_.pixels.empty()) return;
  if (!tracer_) {
    tracer_ = make_tracer();
    tracer_->build(matt_);
  }
  tracer_->forward(legs_.batch(), {.sh_degree = matt_.sh_degree(), .min_transmittance = options.min_transmittance}, leg_values_,
                   nullptr);
  for (uint32_t p = 0; p < legs_.pixels.size(); ++p) bent_[legs_.pixels[p]] = p + 1;
}

GlassContent::Seen GlassContent::seen(uint32_t pixel, const Vec3f& origin, const Vec3f& direction) const {
  if (!bent_.empty() && bent_[pixel] > 0) {
    const uint32_t p = bent_[pixel] - 1, last = legs_.begin[p + 1] - 1;
    const BentLegs::Shown shown = legs_.shown(p, leg_values_);
    const Vec3f& d = legs_.directions[last];
    return {shown.color, shown.transmittance, legs_.origins[last] + kBeyond * surface_->grain() * d, d};
  }
  return {content_->rgb(content_->color, pixel), 1 - content_->alpha[pixel], origin, direction};
}

std::optional<ShownSurface> GlassContent::specular_surface(uint32_t pixel, const PixelRay<float>& ray) const {
  if (!bent_.empty() && bent_[pixel] > 0) return std::nullopt;
  const GBuffer& g = *content_;
  if (!(g.specular[pixel] > float(kMinSpecular) && g.alpha[pixel] > 0 && g.zdepth[pixel] > 0)) return std::nullopt;
  ShownSurface shown = shown_surface(g, std::as_const(picture_).diffuse.plane(Aov::MedianZ), pixel, ray);
  shown.material.albedo = {}, shown.material.transmission = 0;
  shown.behind_glass = true;
  return shown;
}

}  // namespace vitrine
