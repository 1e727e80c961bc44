#include "stages/decompose/metals.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/math/kd_tree.h"
#include "core/foundation/math/median.h"
#include "core/foundation/math/spherical_harmonics.h"
#include "core/render/trace/tracer.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/resample.h"
#include "core/scene/mesh/mesh_hits.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/surfels/activation.h"
#include "stages/decompose/light_solver.h"

namespace vitrine {

namespace {

constexpr float kMinCosine = 0.3f;
constexpr float kBrightest = 0.95f;                               // of a photo; brighter values are clipped
constexpr size_t kFewestPixels = 300;                             // of an object, over all views
constexpr size_t kFewestOfFace = 4;                               // minimum views to separate specular light from paint
constexpr float kLeastCoverage = 0.05f;                           // surfel coverage of a ray; with less it sees the environment
constexpr float kBrightestMetal = 0.95f;                          // silver
constexpr float kCoatF0 = 0.04f;                                  // at normal incidence, index 1.5
constexpr float kLeastPaint = 0.1f, kDarkestRadiance = 1e-4f;     // minimum paint share of a coated surfel's radiance; radiance
constexpr float kCoatRoughness = 0.1f, kMetalRoughness = 0.25f;   // if none was trained
constexpr size_t kNearFaces = 8;                                  // faces averaged for the specular light of a surfel

struct ReflectorPixels {
  std::vector<uint32_t> face;
  std::vector<Vec3f> origins, normals, directions, photo, light;
  std::vector<int> view, x, y;
  std::vector<float> cosine;
  std::vector<bool> well_known;  // the mirrored ray meets matt surface inside the photographed region
  size_t size() const { return face.size(); }
};

class ReflectorFinder {
 public:
  explicit ReflectorFinder(const MetalsDesc& desc) : d_(desc), hits_(desc.mesh), normals_(vertex_normals(desc.mesh)) {
    for (const Object& o : desc.objects.objects().objects)
      if (o.role == ObjectRole::Mirror || o.role == ObjectRole::Coat) ids_.push_back(o.id);
    for (size_t f = 0; f < desc.mesh.faces.size(); ++f) {
      object_.push_back(desc.mesh.object_of_face(f));
      reflector_.push_back(index_of(object_.back()));
    }
  }

  Metals run() {
    const size_t surfels = d_.scene.surfels.diffuse.size();
    Metals out{{}, std::vector<int>(surfels, -1), std::vector<Vec3f>(surfels)};
    for (size_t v = 0; v < d_.views.size() && !ids_.empty(); ++v) look_at(int(v));
    if (pixels_.size() == 0) return out;
    drop_unsure();
    trace();
    const std::vector<FaceShows> faces = faces_show();
    out.reflectors = measured();
    spread(faces, out);
    return out;
  }

 private:
  void look_at(int number) {
    const View& view = d_.views[size_t(number)];
    const Intrinsics k = view.intrinsics.limited_to(d_.max_side);
    const Image16 labels = d_.objects.labels(view, k);
    if (labels.empty()) return;
    ImageF photo = resized(read_exr_rgb(linear_image_path(d_.sfm_folder, view)), k.width, k.height);
    for (float& v : photo.data()) v = std::max(v, 0.f);  // negative values are colours outside Rec. 709
    const Rigid world_from_cam = inverse(view.cam_from_world);
    const Vec3f eye = cast<float>(world_from_cam.translation);
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x) {
        const Vec3f towards = normalized(cast<float>(world_from_cam.rotation * k.ray(x + 0.5, y + 0.5)));
        const auto hit = hits_.first_hit(eye, towards);
        if (!hit) continue;
        // The mesh edge may lie in front of the pixel's object.
        if (reflector_[hit->face] < 0 || labels.at(x, y) != object_[hit->face]) continue;
        const Vec3f p = eye + hit->t * towards, n = normal_at(hit->face, p);
        const float cosine = -dot(n, towards);
        const float* c = photo.pixel(x, y);
        if (!(cosine > kMinCosine) || std::max({c[0], c[1], c[2]}) > kBrightest) continue;
        pixels_.face.push_back(hit->face);
        pixels_.view.push_back(number), pixels_.x.push_back(x), pixels_.y.push_back(y);
        pixels_.origins.push_back(p);
        pixels_.normals.push_back(n);
        pixels_.directions.push_back(towards + 2 * cosine * n);
        Vec3f radiance{c[0] / float(view.gain.x), c[1] / float(view.gain.y), c[2] / float(view.gain.z)};
        if (const auto& medium = d_.scene.image.medium)
          radiance = cast<float>(without_medium(*medium, cast<double>(radiance), double(hit->t)));
        pixels_.photo.push_back(radiance);
        pixels_.cosine.push_back(cosine);
      }
  }

  Vec3f normal_at(uint32_t face, const Vec3f& p) const {
    const auto& f = d_.mesh.faces[face];
    const Vec3f &a = d_.mesh.positions[f[0]], &b = d_.mesh.positions[f[1]], &c = d_.mesh.positions[f[2]], g = cross(b - a, c - a);
    const float area = squared_length(g);
    if (!(area > 0)) return normals_[f[0]];
    const float u = dot(cross(p - a, c - a), g) / area, v = dot(cross(b - a, p - a), g) / area;
    const Vec3f n = (1 - u - v) * normals_[f[0]] + u * normals_[f[1]] + v * normals_[f[2]];
    return squared_length(n) > 0 ? normalized(n) : normalized(g);
  }

  // Index into ids_, or -1.
  int index_of(uint16_t object) const {
    const auto own = std::ranges::lower_bound(ids_, object);
    return own == ids_.end() || *own != object ? -1 : static_cast<int>(own - ids_.begin());
  }

  // Removes objects with too few pixels; they stay unchanged.
  void drop_unsure() {
    std::vector<size_t> pixels(ids_.size(), 0);
    for (const uint32_t face : pixels_.face) ++pixels[size_t(reflector_[face])];
    for (int& t : reflector_)
      if (t >= 0 && pixels[size_t(t)] < kFewestPixels) t = -1;
  }

  // Traces the mirrored rays; pixels with a second specular hit are discarded.
  void trace() {
    ReflectorPixels kept;
    for (size_t i = 0; i < pixels_.size(); ++i) {
      if (reflector_[pixels_.face[i]] < 0) continue;
      const auto again = hits_.first_hit(pixels_.origins[i], pixels_.directions[i], d_.reach);
      if (again && reflector_[again->face] >= 0) continue;
      kept.face.push_back(pixels_.face[i]);
      kept.view.push_back(pixels_.view[i]), kept.x.push_back(pixels_.x[i]), kept.y.push_back(pixels_.y[i]);
      kept.origins.push_back(pixels_.origins[i]);
      kept.normals.push_back(pixels_.normals[i]);
      kept.directions.push_back(pixels_.directions[i]);
      kept.photo.push_back(pixels_.photo[i]);
      kept.cosine.push_back(pixels_.cosine[i]);
      kept.well_known.push_back(again && object_[again->face] == 0);
    }
    pixels_ = std::move(kept);
    tracer_ = make_tracer();
    tracer_->build(d_.scene.surfels.diffuse);
    pixels_.light = light_along(pixels_.origins, pixels_.directions);
  }

  // Radiance of the trained scene, and of the environment outside it, along rays.
  std::vector<Vec3f> light_along(std::span<const Vec3f> origins, std::span<const Vec3f> directions) const {
    RayValues seen;
    const std::vector<float> near(origins.size(), d_.reach);
    tracer_->forward({.origins = origins, .directions = directions, .near = near},
                     {.sh_degree = d_.scene.surfels.diffuse.sh_degree()}, seen, nullptr);
    std::vector<Vec3f> light(origins.size());
    for (size_t i = 0; i < light.size(); ++i) {
      light[i] = seen.transmittance[i] * d_.environment.radiance(directions[i]);
      if (1 - seen.transmittance[i] > kLeastCoverage) light[i] += seen.color[i];
    }
    return light;
  }

  // Per face: mean radiance over the views, and mean of the darker half without the reflected light of a coat.
  struct FaceShows {
    Vec3f mean{}, paint{};
    size_t views = 0;
  };
  std::vector<FaceShows> faces_show() const {
    std::vector<std::vector<uint32_t>> of_face(reflector_.size());
    for (uint32_t i = 0; i < pixels_.size(); ++i) of_face[pixels_.face[i]].push_back(i);
    std::vector<FaceShows> faces(reflector_.size());
    for (size_t f = 0; f < of_face.size(); ++f) {
      std::vector<uint32_t>& views = of_face[f];
      if (views.size() < kFewestOfFace) continue;
      FaceShows& face = faces[f];
      face.views = views.size();
      const auto photo = [&](uint32_t i) { return luminance(pixels_.photo[i]); };
      std::ranges::stable_sort(views, {}, photo);
      const size_t half = (views.size() + 1) / 2;
      for (size_t v = 0; v < views.size(); ++v) {
        face.mean += pixels_.photo[views[v]] / float(views.size());
        if (v >= half) continue;
        const Vec3f mirrored = schlick(Vec3f{kCoatF0, kCoatF0, kCoatF0}, pixels_.cosine[views[v]]).value;
        const Vec3f paint = pixels_.photo[views[v]] - hadamard(mirrored, pixels_.light[views[v]]);
        for (size_t c = 0; c < 3; ++c) face.paint[c] += std::max(paint[c], 0.f) / float(half);
      }
    }
    return faces;
  }

  std::vector<Reflector> measured() const {
    std::vector<Reflector> reflectors(ids_.size());
    for (size_t t = 0; t < reflectors.size(); ++t) {
      Reflector& reflector = reflectors[t];
      reflector.object = ids_[t];
      reflector.metal = d_.objects.objects().find(ids_[t])->role == ObjectRole::Mirror;
      reflector.reflectance = {kCoatF0, kCoatF0, kCoatF0};
      Vec3d photo[2]{}, light[2]{};
      size_t well_known = 0;
      for (size_t i = 0; i < pixels_.size(); ++i) {
        if (reflector_[pixels_.face[i]] != int(t)) continue;
        ++reflector.pixels;
        well_known += pixels_.well_known[i];
        photo[pixels_.well_known[i]] += cast<double>(pixels_.photo[i]);
        light[pixels_.well_known[i]] += cast<double>(pixels_.light[i]);
      }
      if (well_known < kFewestPixels) photo[1] += photo[0], light[1] += light[0];
      reflector.metal = reflector.metal && std::min({light[1].x, light[1].y, light[1].z}) > 0;
      if (!reflector.metal) continue;
      for (size_t c = 0; c < 3; ++c) reflector.reflectance[c] = float(photo[1][c] / light[1][c]);
      const float most = std::max({reflector.reflectance.x, reflector.reflectance.y, reflector.reflectance.z});
      if (most > kBrightestMetal) reflector.reflectance = (kBrightestMetal / most) * reflector.reflectance;
      reflector.roughness = roughness_of_contrast(
          well_known_of(int(t)), reflector.reflectance,
          [&](std::span<const Vec3f> origins, std::span<const Vec3f> directions) { return light_along(origins, directions); });
    }
    return reflectors;
  }

  MirroredPixels well_known_of(int reflector) const {
    MirroredPixels out;
    for (size_t i = 0; i < pixels_.size(); ++i) {
      if (reflector_[pixels_.face[i]] != reflector || !pixels_.well_known[i]) continue;
      out.view.push_back(pixels_.view[i]), out.x.push_back(pixels_.x[i]), out.y.push_back(pixels_.y[i]);
      out.origins.push_back(pixels_.origins[i]);
      out.normals.push_back(pixels_.normals[i]);
      out.towards_eye.push_back(normalized(2 * pixels_.cosine[i] * pixels_.normals[i] - pixels_.directions[i]));
      out.photo.push_back(pixels_.photo[i]);
    }
    return out;
  }

  void spread(const std::vector<FaceShows>& shown, Metals& out) {
    std::vector<Vec3f> centres;
    for (const auto& f : d_.mesh.faces)
      centres.push_back((d_.mesh.positions[f[0]] + d_.mesh.positions[f[1]] + d_.mesh.positions[f[2]]) / 3.f);
    const KdTreef tree(centres);
    const std::span<const uint16_t> objects = d_.scene.surfels.diffuse.object_ids();
    std::vector<KdTreef::Near> near;
    for (size_t i = 0; i < objects.size(); ++i) {
      const int reflector = index_of(objects[i]);
      if (reflector < 0 || out.reflectors[size_t(reflector)].pixels == 0) continue;
      out.of_surfel[i] = reflector;
      const float* m = d_.scene.surfels.diffuse.at(Attribute::Mean, i);
      tree.nearest({m[0], m[1], m[2]}, kNearFaces, d_.reach, near);
      float faces = 0;
      for (const auto& n : near)
        if (reflector_[n.index] == reflector && shown[n.index].views > 0) {
          for (size_t c = 0; c < 3; ++c) out.coat_light[i][c] += std::max(shown[n.index].mean[c] - shown[n.index].paint[c], 0.f);
          faces += 1;
        }
      if (faces > 0) out.coat_light[i] = out.coat_light[i] / faces;
    }
  }

  const MetalsDesc& d_;
  MeshHits hits_;
  std::vector<Vec3f> normals_;
  std::vector<uint16_t> ids_;     // of mirrors and coats, ascending
  std::vector<uint16_t> object_;  // [face] id, 0: matt
  std::vector<int> reflector_;    // [face] index into ids_, or -1
  std::unique_ptr<Tracer> tracer_;
  ReflectorPixels pixels_;
};

}  // namespace

Metals find_metals(const MetalsDesc& desc) { return ReflectorFinder(desc).run(); }

void apply_reflectors(const Metals& found, const TrainedScene& scene, const std::vector<Vec3f>& radiance,
                      DecomposedMaterials& materials) {
  const LayerBlend blend = scene.image.composite.blend;
  for (size_t i = 0; i < materials.size(); ++i) {
    if (found.of_surfel[i] < 0) continue;
    const Reflector& reflector = found.reflectors[size_t(found.of_surfel[i])];
    Vec3f& albedo = materials.albedo[i];
    for (size_t c = 0; c < 3; ++c)
      albedo[c] =
          reflector.metal
              ? 0
              : albedo[c] * std::clamp(1 - found.coat_light[i][c] / std::max(radiance[i][c], kDarkestRadiance), kLeastPaint, 1.f);
    if (!reflector.metal && blend == LayerBlend::RtrGs)
      continue;  // this blend has no surface with both paint and its own reflection
    set_reflectance(blend, reflector.reflectance, materials.specular_weight[i], materials.f0[i]);
    materials.transmission[i] = 0;
    if (reflector.roughness)
      materials.roughness[i] = *reflector.roughness;
    else if (!reflector.metal || scene.surfels.reflection.size() == 0)
      materials.roughness[i] = reflector.metal ? kMetalRoughness : kCoatRoughness;
  }
}

void set_reflectance(LayerBlend blend, const Vec3f& reflectance, float& specular_weight, Vec3f& f0) {
  // Reflectance is k F, or k + (1 - k) F: the smallest k with a full Fresnel term lets F set the colour.
  const float k = blend == LayerBlend::RtrGs ? 0 : float(kFullFresnel);
  specular_weight = blend == LayerBlend::RtrGs ? 1 : k;
  for (size_t c = 0; c < 3; ++c) f0[c] = std::clamp((reflectance[c] - k) / (1 - k), 0.f, 1.f);
}

}  // namespace vitrine
