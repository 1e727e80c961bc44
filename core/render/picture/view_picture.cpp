#include "core/render/picture/view_picture.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/math/color.h"
#include "core/render/raster/raster_desc.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr float kOpaqueAlpha = 0.5f;

ImageF interleaved(std::span<const float> planes, int width, int height, int channels) {
  ImageF out(width, height, channels);
  const size_t n = out.pixel_count(), count = size_t(channels);
  for (size_t i = 0; i < n; ++i)
    for (size_t c = 0; c < count; ++c) out.data()[count * i + c] = planes[c * n + i];
  return out;
}

ImageOptions options_of_picture(const TrainedScene& scene, const PictureDesc& desc) {
  constexpr int kManySamples = 32;
  ImageOptions o = scene.image;
  const bool reference = desc.backend == Backend::Reference;
  o.diffuse.backend = desc.backend;
  o.diffuse.materials = desc.layers;
  o.surface.ray_budget = 0;
  o.reflection.backend = o.transmission.backend = reference ? TracerBackend::Reference : TracerBackend::Embree;
  if (desc.samples > 0) o.reflection.lobe = Lobe::Sampled;
  o.reflection.samples = desc.samples > 0 ? desc.samples : kManySamples;
  o.composite.layer_images = desc.layers;
  if (!desc.medium) o.medium.reset();
  return o;
}

PictureLayer radiance_layer(const char* name, std::span<const float> planes, const Intrinsics& k) {
  return {name, {interleaved(planes, k.width, k.height, 3), {"R", "G", "B"}, {}}};
}
PictureLayer scalar_layer(const char* name, std::span<const float> plane, const Intrinsics& k) {
  return {name, {interleaved(plane, k.width, k.height, 1), {"Y"}, {}}};
}

}  // namespace

const ImageF* ViewPicture::layer(std::string_view name) const {
  const auto it = std::ranges::find(layers, name, &PictureLayer::name);
  return it == layers.end() ? nullptr : &it->map.pixels;
}

ImageF displayed(const ImageF& linear, const Vec3d& gain) {
  ImageF out = linear;
  for (size_t i = 0; i < out.data().size(); ++i)
    out.data()[i] = srgb_from_linear(std::clamp(float(gain[i % 3]) * linear.data()[i], 0.f, 1.f));
  return out;
}

ScenePainter::ScenePainter(TrainedScene scene, const PictureDesc& desc)
    : scene_(std::move(scene)), desc_(desc), model_(options_of_picture(scene_, desc)) {}

ViewPicture ScenePainter::picture(const View& view) {
  frame_.differentiable = false;
  model_.forward(scene_.surfels, view, frame_);
  const Intrinsics& k = view.intrinsics;
  ViewPicture out{k, {}, ImageF(k.width, k.height, 1), ImageF(k.width, k.height, 3), {}, {}};
  out.linear = interleaved(frame_.linear, k.width, k.height, 3);
  if (!frame_.clear.empty()) out.clear = interleaved(frame_.clear, k.width, k.height, 3);
  out.srgb = displayed(out.linear, view.gain);
  const size_t n = out.srgb.pixel_count();
  const RasterImages& surface = frame_.diffuse;
  const auto normal = surface.plane(Aov::Normal), zdepth = surface.plane(Aov::ZDepth);
  const auto alpha = surface.plane(Aov::Alpha), median_z = surface.plane(Aov::MedianZ);
  for (size_t i = 0; i < n; ++i) {
    if (!(alpha[i] >= kOpaqueAlpha)) continue;
    out.zdepth.data()[i] = surface_depth(zdepth[i], alpha[i], median_z[i]);
    const Vec3f blended{normal[i], normal[n + i], normal[2 * n + i]};
    const float size = length(blended);
    if (size > 0)
      for (size_t c = 0; c < 3; ++c) out.normal_in_world.data()[3 * i + c] = blended[c] / size;
  }
  if (!desc_.layers) return out;
  out.layers.push_back({"radiance", {out.linear, {"R", "G", "B"}, {}}});
  if (!frame_.clear.empty()) out.layers.push_back({"clear", {out.clear, {"R", "G", "B"}, {}}});
  const LayerImages& parts = frame_.layers;
  const bool reflects = scene_.surfels.reflection.size() > 0, transmits = scene_.surfels.transmittance.size() > 0;
  out.layers.push_back(radiance_layer("diffuse", parts.diffuse, k));
  if (reflects) {
    out.layers.push_back(radiance_layer("reflection", parts.reflection, k));
    out.layers.push_back(radiance_layer("reflected", parts.reflected, k));
    out.layers.push_back(radiance_layer("fresnel", parts.fresnel, k));
    out.layers.push_back(scalar_layer("specular_weight", surface.plane(Aov::SpecularWeight), k));
    out.layers.push_back(scalar_layer("roughness", surface.plane(Aov::Roughness), k));
  }
  if (transmits) {
    out.layers.push_back(radiance_layer("transmission", parts.transmission, k));
    out.layers.push_back(radiance_layer("transmitted", parts.transmitted, k));
    out.layers.push_back(scalar_layer("transmission_weight", surface.plane(Aov::Transmission), k));
  }
  out.layers.push_back({"normal", {out.normal_in_world, {"X", "Y", "Z"}, {}}});
  out.layers.push_back({"depth", {out.zdepth, {"Z"}, {}}});
  return out;
}

ImageF photo_srgb(const std::filesystem::path& sfm_folder, const View& view, const Intrinsics& intrinsics) {
  ImageF photo = read_exr_rgb(linear_image_path(sfm_folder, view));
  if (photo.width() != intrinsics.width || photo.height() != intrinsics.height)
    photo = resized(photo, intrinsics.width, intrinsics.height);
  for (float& v : photo.data()) v = srgb_from_linear(std::clamp(v, 0.f, 1.f));
  return photo;
}

}  // namespace vitrine
