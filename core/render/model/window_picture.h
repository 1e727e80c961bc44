// A window of a picture, drawn from a part of a layer: of what stands beside it nothing is copied or drawn. Passes that need such
// a picture (PanePass, SilhouettePass) say which surfels take part.
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

// What a picture can show: most of a scene is beside a small window, and copying it costs as much as drawing the rest.
class Frustum {
 public:
  explicit Frustum(const View& view) : cam_from_world_(view.cam_from_world) {
    const Intrinsics& k = view.intrinsics;
    // Through the eye and an edge of the picture, inwards.
    sides_ = {Vec3d{k.fx, 0, k.cx + kMargin}, Vec3d{-k.fx, 0, k.width + kMargin - k.cx}, Vec3d{0, k.fy, k.cy + kMargin},
              Vec3d{0, -k.fy, k.height + kMargin - k.cy}};
    for (Vec3d& n : sides_) n = normalized(n);
  }
  // A surfel: its mean and the logarithms of its two standard deviations.
  bool may_show(const Vec3f& mean, const float* log_scale) const {
    const Vec3d p = cam_from_world_ * cast<double>(mean);
    double outside = -p.z;
    for (const Vec3d& n : sides_) outside = std::max(outside, -dot(n, p));
    return outside <= 0 || outside <= double(kReach * std::exp(std::max(log_scale[0], log_scale[1])));
  }

 private:
  static constexpr float kReach = 3.5f;  // standard deviations of a surfel's extent: beyond, it is nowhere above 1/255
  static constexpr double kMargin = 4;   // pixels, for the low-pass of the rasteriser
  Rigid cam_from_world_;
  std::array<Vec3d, 4> sides_;
};

class WindowPicture {
 public:
  explicit WindowPicture(Backend backend) : renderer_(make_renderer(backend)) {}

  // Chooses, in the order of `layer`, the surfels i for which takes_part(i) holds and that `window` may show.
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
    bool differentiable = false;           // gradients() will be asked for
  };
  const RasterImages& draw(const Style& style);
  const RasterImages& picture() const { return picture_; }

  // Zero after draw(); of the same planes.
  RasterImages& gradients() { return gradients_; }
  // From gradients() to the chosen surfels of the layer and their statistics, added. `error`: [window] or empty.
  void backward(std::span<const float> error, SplatLayer& grad, SurfelStatistics& statistics);

 private:
  static constexpr size_t kGrain = 1024;  // surfels
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
