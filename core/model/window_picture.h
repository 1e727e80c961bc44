// A window of a picture, drawn from a part of a layer: of what stands beside it nothing is copied or drawn. Passes that need such
// a picture (PanePass, SilhouettePass) say which surfels take part.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/base/parallel.h"
#include "core/model/frustum.h"
#include "core/render/renderer.h"
#include "core/scene/layers.h"

namespace vitrine {

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
