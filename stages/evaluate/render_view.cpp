#include "stages/evaluate/render_view.h"

#include <algorithm>
#include <cmath>

#include "core/camera/view_set.h"
#include "core/image/exr.h"
#include "core/image/resample.h"
#include "core/math/color.h"

namespace vitrine {
namespace {

constexpr float kOpaqueAlpha = 0.5f;
// Mean depth is smoother, but at an edge it lies between two surfaces: where it leaves the median by more, the median counts.
constexpr float kMeanNearMedian_rel = 0.01f;

float encoded(float linear) { return srgb_from_linear(std::clamp(linear, 0.f, 1.f)); }

}  // namespace

RenderedView rendered_view(Renderer& renderer, const SplatLayer& layer, const View& view, int max_side) {
  RasterDesc desc;
  desc.intrinsics = view.intrinsics.limited_to(max_side);
  desc.cam_from_world = view.cam_from_world;
  desc.features = FeatureSet::Surface;
  desc.sh_degree = layer.sh_degree();
  RasterImages images;
  renderer.forward(layer, desc, images);

  const int w = desc.intrinsics.width, h = desc.intrinsics.height;
  const size_t n = size_t(w) * size_t(h);
  RenderedView out{desc.intrinsics, ImageF(w, h, 3), ImageF(w, h, 1), ImageF(w, h, 3)};
  const auto color = images.plane(Aov::Color), normal = images.plane(Aov::Normal), zdepth = images.plane(Aov::ZDepth);
  const auto alpha = images.plane(Aov::Alpha), median_z = images.plane(Aov::MedianZ);
  for (size_t i = 0; i < n; ++i) {
    for (size_t c = 0; c < 3; ++c) out.srgb.data()[3 * i + c] = encoded(float(view.gain[c]) * color[c * n + i]);
    if (!(alpha[i] >= kOpaqueAlpha)) continue;
    const float mean_z = zdepth[i] / alpha[i], med = median_z[i];
    out.zdepth.data()[i] = med > 0 && std::abs(mean_z - med) > kMeanNearMedian_rel * med ? med : mean_z;
    const Vec3f blended{normal[i], normal[n + i], normal[2 * n + i]};
    const float len = length(blended);
    if (len > 0)
      for (size_t c = 0; c < 3; ++c) out.normal_in_world.data()[3 * i + c] = blended[c] / len;
  }
  return out;
}

ImageF photo_srgb(const std::filesystem::path& sfm_folder, const View& view, const Intrinsics& intrinsics) {
  ImageF photo = read_exr_rgb(linear_image_path(sfm_folder, view));
  if (photo.width() != intrinsics.width || photo.height() != intrinsics.height)
    photo = resized(photo, intrinsics.width, intrinsics.height);
  for (float& v : photo.data()) v = encoded(v);
  return photo;
}

}  // namespace vitrine
