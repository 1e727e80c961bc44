#include "stages/decompose/lit_points.h"

#include <cmath>
#include <unordered_map>

#include "core/foundation/base/rng.h"
#include "core/render/raster/raster_desc.h"
#include "core/render/raster/renderer.h"

namespace vitrine {

namespace {

constexpr float kShortestNormal = 0.05f;

// Key of the voxel and the dominant axis of the normal, which separates the two sides of a thin object.
uint64_t key_of(const Vec3f& position, const Vec3f& normal, double voxel, bool inner) {
  size_t axis = 0;
  for (size_t c = 1; c < 3; ++c)
    if (std::abs(normal[c]) > std::abs(normal[axis])) axis = c;
  uint64_t key = 2 * axis + (normal[axis] > 0) + (inner ? 8 : 0);
  for (size_t c = 0; c < 3; ++c) key = mix64(key, static_cast<uint64_t>(static_cast<int64_t>(std::floor(position[c] / voxel))));
  return key;
}

struct Sum {
  Vec3d position{}, normal{}, radiance{};
  double specular = 0, transmission = 0, weight = 0, masked = 0;
  bool inner = false;
};

}  // namespace

std::vector<LitPoint> lit_points(const SplatLayer& layer, const std::vector<View>& views, const LitPointsDesc& desc,
                                 const std::function<void(double)>& progress) {
  const std::unique_ptr<Renderer> renderer = make_renderer(Backend::Cpu);
  RasterImages images;
  std::unordered_map<uint64_t, size_t> place;
  std::vector<Sum> sums;
  for (size_t v = 0; v < views.size(); ++v) {
    progress(double(v) / double(views.size()));
    const View& view = views[v];
    RasterDesc raster;
    raster.intrinsics = view.intrinsics.limited_to(desc.max_side);
    raster.cam_from_world = view.cam_from_world;
    raster.features = FeatureSet::Material;
    raster.sh_degree = layer.sh_degree();
    raster.near_z = desc.near_z;
    renderer->forward(layer, raster, images);
    const Intrinsics& k = raster.intrinsics;
    const size_t pixels = k.pixel_count();
    const auto color = images.plane(Aov::Color), normals = images.plane(Aov::Normal), zsum = images.plane(Aov::ZDepth);
    const auto alpha = images.plane(Aov::Alpha), median = images.plane(Aov::MedianZ);
    const auto specular = images.plane(Aov::SpecularWeight), transmission = images.plane(Aov::Transmission);
    const ImageF mask = desc.masked ? desc.masked(view, k) : ImageF();
    const Rigid world_from_cam = inverse(view.cam_from_world);
    const Vec3f eye = cast<float>(world_from_cam.translation), centre = cast<float>(desc.inner.centre());
    for (size_t p = 0; p < pixels; ++p) {
      const float a = alpha[p];
      if (!(a >= desc.min_alpha)) continue;
      const float z = surface_depth(zsum[p], a, median[p]);
      const Vec3f blended{normals[p], normals[pixels + p], normals[2 * pixels + p]};
      const float size = length(blended);
      if (!(z > 0) || !std::isfinite(z) || !(size > kShortestNormal)) continue;
      const Vec3d ray = k.ray(double(p % size_t(k.width)) + 0.5, double(p / size_t(k.width)) + 0.5);
      const Vec3f position = cast<float>(world_from_cam * (double(z) * ray)), n = blended / size;
      const float cosine = dot(n, normalized(eye - position));
      if (!(cosine > desc.min_cosine)) continue;
      if (length(position - centre) > desc.sky_distance) continue;
      const bool inner = desc.inner.contains(position);
      const auto [it, is_new] =
          place.try_emplace(key_of(position, n, desc.voxel * (inner ? 1 : desc.outer_factor), inner), sums.size());
      if (is_new) sums.emplace_back();
      Sum& s = sums[it->second];
      const double w = cosine;
      s.inner = inner;
      s.weight += w;
      s.position += w * cast<double>(position);
      s.normal += w * cast<double>(n);
      s.radiance += (w / a) * Vec3d{color[p], color[pixels + p], color[2 * pixels + p]};
      s.specular += w * specular[p] / a;
      if (!mask.empty() && mask.data()[p] > 0.5f) s.masked += w;
      s.transmission += w * transmission[p] / a;
    }
  }
  std::vector<LitPoint> points;
  points.reserve(sums.size());
  for (const Sum& s : sums) {
    if (!(length(s.normal) > 0.3 * s.weight)) continue;  // opposite normals cancel
    points.push_back({.position = cast<float>(s.position / s.weight),
                      .normal = cast<float>(normalized(s.normal)),
                      .radiance = cast<float>(s.radiance / s.weight),
                      .specular_weight = float(s.specular / s.weight),
                      .transmission = float(s.transmission / s.weight),
                      .weight = float(s.weight),
                      .masked = float(s.masked / s.weight),
                      .inner = s.inner});
  }
  return points;
}

}  // namespace vitrine
