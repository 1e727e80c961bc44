// Rasterises a window of a picture from a subset of a layer. Surfels outside the window are neither copied nor rasterised. The
// passes that use it (PanePass, SilhouettePass) select the surfels.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "core/foundation/base/parallel.h"
#include "core/scene/camera/view.h"
#include "core/render/raster/renderer.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// View frustum for culling: most of a scene is outside a small window, and copying it costs as much as rasterising the rest.
class Frustum {
 public:
  explicit Frustum(const View& view) : cam_from_world_(view.cam_from_world) {
    const Intrinsics& k = view.intrinsics;
    // Planes through the eye and the edges of the picture, facing inwards.
    sides_ = {Vec3d{k.fx, 0, k.cx + kMargin}, Vec3d{-k.fx, 0, k.width + kMargin - k.cx}, Vec3d{0, k.fy, k.cy + kMargin},
              Vec3d{0, -k.fy, k.height + kMargin - k.cy}};
    for (Vec3d& n : sides_) n = normalized(n);
  }
  // `log_scale`: logarithms of the two standard deviations of the surfel.
  bool may_show(const Vec3f& mean, const float* log_scale) const {
    const Vec3d p = cam_from_world_ * cast<double>(mean);
    double outside = -p.z;
    for (const Vec3d& n : sides_) outside = std::max(outside, -dot(n, p));
    return outside <= 0 || outside <= double(kReach * std::exp(std::max(log_scale[0], log_scale[1])));
  }

 private:
  static constexpr float kReach = 3.5f;  // extent of a surfel in standard deviations: beyond, it is below 1/255
  static constexpr double kMargin = 4;   // pixels, for the low-pass of the rasteriser
  Rigid cam_from_world_;
  std::array<Vec3d, 4> sides_;
};

class WindowPicture {
 public:
  explicit WindowPicture(Backend backend) : renderer_(make_renderer(backend)) {}

  // Selects, in the order of `layer`, the surfels i for which takes_part(i) holds and that intersect the frustum of `window`.
  template <class TakesPart>
  void choose(const SplatLayer& layer, const View& window, const TakesPart& takes_part) {
    window_ = window;
    const Frustum frustum(window);
    chunks_.resize(chunk_count(layer.size(), kGrain));
    parallel_chunks(layer.size(), kGrain, [&](size_t chunk, size_t first, size_t last) {
      auto& chosen = chunks_[chunk];
      chosen.clear();
      for (size_t i = first; i < last; ++i) {
        const float* m = layer.at(Attribute::Mean, i);
        if (frustum.may_show({m[0], m[1], m[2]}, layer.at(Attribute::LogScale, i)) && takes_part(i))
          chosen.push_back(static_cast<uint32_t>(i));
      }
    });
    copy_chosen(layer);
  }

  struct Style {
    FeatureSet features = FeatureSet::Material;
    int sh_degree = 0;  // at most the layer's
    float near_z = 0.01f;
    std::span<const uint8_t> wanted = {};  // RasterDesc::wanted
    bool differentiable = false;           // gradients() will be called
  };
  const RasterImages& draw(const Style& style);
  const RasterImages& picture() const { return picture_; }

  // Zero after draw(); same planes.
  RasterImages& gradients() { return gradients_; }
  // Propagates gradients() to the chosen surfels of the layer and their statistics (added). `error`: [window] or empty.
  void backward(std::span<const float> error, SplatLayer& grad, SurfelStatistics& statistics);

 private:
  static constexpr size_t kGrain = 1024;  // surfels per parallel chunk
  void copy_chosen(const SplatLayer& layer);

  std::unique_ptr<Renderer> renderer_;
  View window_;
  std::vector<std::vector<uint32_t>> chunks_;
  std::vector<uint32_t> chosen_;
  SplatLayer surfels_, grad_;
  RasterImages picture_, gradients_;
  SurfelStatistics statistics_;
};

}  // namespace vitrine
