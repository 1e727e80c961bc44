// Renderer "blocks": the table of a layer and the planes of a picture to the arrays of the kernels, and back.
#include <array>
#include <span>
#include <utility>

#include "core/render/raster/blocks/device_host.h"
#include "core/render/raster/renderer.h"

namespace vitrine {

namespace blocks {
namespace {

constexpr std::array kMaterials{Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight, Attribute::Transmission};

SurfelArrays surfel_arrays(const SplatLayer& layer, FeatureSet features) {
  const auto at = [&](Attribute a) { return layer.width(a) == 0 ? nullptr : layer.values(a).data(); };
  SurfelArrays s{};
  s.mean = at(Attribute::Mean);
  s.rotation = at(Attribute::Rotation);
  s.log_scale = at(Attribute::LogScale);
  s.opacity = at(Attribute::Opacity);
  s.sh_dc = at(Attribute::ShDc);
  s.sh_rest = at(Attribute::ShRest);
  if (features == FeatureSet::Material)
    for (size_t m = 0; m < 4; ++m) s.material[m] = at(kMaterials[m]);
  s.sh_rest_width = static_cast<uint32_t>(layer.width(Attribute::ShRest));
  s.count = static_cast<uint32_t>(layer.size());
  return s;
}

PixelPlanes pixel_planes(RasterImages& images, const RasterDesc& desc, std::vector<uint32_t>& work) {
  const size_t pixels = desc.intrinsics.pixel_count();
  work.resize(2 * pixels);
  PixelPlanes p{};
  size_t feature = 0;
  for (const AovRow& r : kAovs) {
    if (!r.feature || !produces(desc, r.id)) continue;
    for (size_t c = 0; c < static_cast<size_t>(r.width); ++c) p.features[feature++] = images.plane(r.id).data() + c * pixels;
  }
  p.zdepth = images.plane(Aov::ZDepth).data();
  p.alpha = images.plane(Aov::Alpha).data();
  p.median_z = images.plane(Aov::MedianZ).data();
  p.distortion = images.plane(Aov::Distortion).data();
  p.fragments = work.data();
  p.evaluated = work.data() + pixels;
  return p;
}

GradientPlanes gradient_planes(const BackwardInput& input, const RasterDesc& desc) {
  const RasterImages& images = *input.gradients;
  const auto plane = [&](Aov a) { return images.plane(a).empty() ? nullptr : images.plane(a).data(); };
  GradientPlanes g{};
  size_t feature = 0;
  for (const AovRow& r : kAovs) {
    if (!r.feature || !produces(desc, r.id)) continue;
    for (size_t c = 0; c < static_cast<size_t>(r.width); ++c, ++feature)
      g.features[feature] = plane(r.id) == nullptr ? nullptr : plane(r.id) + c * desc.intrinsics.pixel_count();
  }
  g.zdepth = plane(Aov::ZDepth);
  g.alpha = plane(Aov::Alpha);
  g.median_z = plane(Aov::MedianZ);
  g.distortion = plane(Aov::Distortion);
  g.error = input.error_image.empty() ? nullptr : input.error_image.data();
  return g;
}

class BlocksRenderer final : public Renderer {
 public:
  explicit BlocksRenderer(std::unique_ptr<BlockPass> pass) : pass_(std::move(pass)) {}

  void forward(const SplatLayer& layer, const RasterDesc& desc, RasterImages& out) override {
    check_wanted(desc);
    out.resize(desc);
    desc_ = desc;
    layer_ = &layer;
    const PassScene scene{surfel_arrays(layer, desc.features), block_view(desc, layer.sh_degree()),
                          static_cast<int>(feature_count(desc.features)), desc.distortion,
                          desc.wanted.empty() ? nullptr : desc.wanted.data()};
    counts_ = {};
    on_device(load(), [&] { counts_.instances = pass_->forward(scene, pixel_planes(out, desc, work_)); });
    const size_t pixels = desc.intrinsics.pixel_count();
    for (size_t i = 0; i < pixels; ++i) {
      counts_.fragments += work_[i];
      counts_.lanes += work_[pixels + i];
    }
  }

  void backward(const BackwardInput& input, SplatLayer& grad, SurfelStatistics* statistics) override {
    VITRINE_CHECK(layer_ != nullptr && input.gradients != nullptr, "backward needs a forward pass and gradients");
    const size_t n = layer_->size();
    SplatLayer added = grad.zeros_like();
    SurfelStatistics of_pass;
    of_pass.reset(n);
    on_device(load(), [&] { pass_->reverse(gradient_planes(input, desc_), surfel_gradients(added, of_pass)); });
    for (const AttributeRow& r : kAttributes) add(grad.values(r.id), added.values(r.id));
    if (statistics == nullptr) return;
    for (auto* v : {&statistics->screen_gradient, &statistics->weight, &statistics->error}) v->resize(n, 0.f);
    add(statistics->screen_gradient, of_pass.screen_gradient);
    add(statistics->weight, of_pass.weight);
    add(statistics->error, of_pass.error);
  }
  RasterCounts counts() const override { return counts_; }
  std::string_view name() const override { return "blocks"; }
  std::string_view numerics_tag() const override { return "cuda-2"; }  // the same on the CPU and on every device

 private:
  DeviceLoad load() const { return {layer_->size(), desc_.intrinsics.width, desc_.intrinsics.height}; }
  static void add(std::span<float> to, std::span<const float> from) {
    for (size_t i = 0; i < from.size(); ++i) to[i] += from[i];
  }
  SurfelGradients surfel_gradients(SplatLayer& grad, SurfelStatistics& statistics) const {
    const auto at = [&](Attribute a) { return grad.width(a) == 0 ? nullptr : grad.values(a).data(); };
    SurfelGradients g{};
    g.mean = at(Attribute::Mean);
    g.rotation = at(Attribute::Rotation);
    g.log_scale = at(Attribute::LogScale);
    g.opacity = at(Attribute::Opacity);
    g.sh_dc = at(Attribute::ShDc);
    g.sh_rest = at(Attribute::ShRest);
    if (desc_.features == FeatureSet::Material)
      for (size_t m = 0; m < 4; ++m) g.material[m] = at(kMaterials[m]);
    g.screen_gradient = statistics.screen_gradient.data();
    g.weight = statistics.weight.data();
    g.error = statistics.error.data();
    return g;
  }

  std::unique_ptr<BlockPass> pass_;
  const SplatLayer* layer_ = nullptr;
  RasterDesc desc_;
  std::vector<uint32_t> work_;  // of each pixel: fragments, then evaluated
  RasterCounts counts_;
};

}  // namespace
}  // namespace blocks

std::unique_ptr<Renderer> make_blocks_renderer(std::unique_ptr<blocks::BlockPass> pass) {
  return std::make_unique<blocks::BlocksRenderer>(std::move(pass));
}

std::unique_ptr<Renderer> make_blocks_renderer(uint64_t shuffle_seed) {
  return make_blocks_renderer(std::make_unique<blocks::ExecutorPass<blocks::BlockLoops>>(blocks::BlockLoops(shuffle_seed)));
}

}  // namespace vitrine
