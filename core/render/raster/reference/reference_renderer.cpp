// Renderer "reference": double, O(pixels x surfels). For tests, benchmark checks and debugging.
#include "core/render/raster/renderer.h"

#include <cmath>

#include "core/render/raster/reference/reference_pass.h"

namespace vitrine {

namespace {

using namespace reference;

// Visits every scalar of a pixel together with its plane entry.
template <class Pixel, class Images, class Visit>
void visit_planes(Pixel& pixel, Images& images, const RasterDesc& desc, size_t at, Visit visit) {
  const size_t stride = static_cast<size_t>(images.width) * static_cast<size_t>(images.height);
  size_t feature = 0;
  for (const AovRow& r : kAovs) {
    if (!produces(desc, r.id)) continue;
    const auto plane = images.plane(r.id);
    for (size_t c = 0; c < static_cast<size_t>(r.width); ++c) {
      auto& value = r.feature              ? pixel.features[feature++]
                    : r.id == Aov::ZDepth  ? pixel.zdepth
                    : r.id == Aov::Alpha   ? pixel.alpha
                    : r.id == Aov::MedianZ ? pixel.median_z
                                           : pixel.distortion;
      if (!plane.empty()) visit(value, plane[c * stride + at]);
    }
  }
}

class ReferenceRenderer final : public Renderer {
 public:
  void forward(const SplatLayer& layer, const RasterDesc& desc, RasterImages& out) override {
    check_wanted(desc);
    layer_ = &layer;
    desc_ = desc;
    view_ = scene_camera<double>(desc, layer);
    background_ = cast<double>(desc.background);
    values_.assign(layer.size(), {});
    surfels_.clear();
    for (size_t i = 0; i < layer.size(); ++i) {
      visit_values(layer, values_[i], [&](double& v, Attribute a, size_t c) { v = static_cast<double>(layer.at(a, i)[c]); });
      surfels_.push_back(screen_surfel(values_[i], view_));
    }
    out.reset(desc);
    counts_ = {};
    for (const auto& s : surfels_) counts_.surfels += s.visible;
    for_each_pixel([&](size_t at) {
      counts_.fragments += fragments_.size();
      counts_.lanes += counts_.surfels;
      const PixelValues<double> pixel = blend_pixel(surfels_, fragments_, view_, background_);
      visit_planes(pixel, out, desc_, at, [](double value, float& plane) { plane = static_cast<float>(value); });
    });
  }

  void backward(const BackwardInput& input, SplatLayer& grad, SurfelStatistics* statistics) override {
    VITRINE_CHECK(layer_ != nullptr && input.gradients != nullptr, "backward needs a forward pass and gradients");
    std::vector<SurfelSums<double>> sums(surfels_.size());
    for_each_pixel([&](size_t at) {
      PixelValues<double> pixel;
      visit_planes(pixel, *input.gradients, desc_, at, [](double& value, float plane) { value = static_cast<double>(plane); });
      const double error = input.error_image.empty() ? 0.0 : static_cast<double>(input.error_image[at]);
      blend_pixel_vjp(surfels_, fragments_, view_, background_, pixel, error, sums);
    });
    if (statistics) {
      for (auto* v : {&statistics->screen_gradient, &statistics->weight, &statistics->error}) v->resize(surfels_.size(), 0.f);
    }
    for (size_t i = 0; i < surfels_.size(); ++i) {
      if (!surfels_[i].visible) continue;
      Vec2d screen;
      SurfelValues<double> g = screen_surfel_vjp(values_[i], view_, surfels_[i], sums[i].moments, sums[i].features, screen);
      visit_values(*layer_, g, [&](double& v, Attribute a, size_t c) { grad.at(a, i)[c] += static_cast<float>(v); });
      if (!statistics) continue;
      const double gx = screen.x * desc_.intrinsics.width / 2, gy = screen.y * desc_.intrinsics.height / 2;
      statistics->screen_gradient[i] += static_cast<float>(std::hypot(gx, gy));
      statistics->weight[i] += static_cast<float>(sums[i].weight);
      statistics->error[i] += static_cast<float>(sums[i].error);
    }
  }

  RasterCounts counts() const override { return counts_; }
  std::string_view name() const override { return "reference"; }
  std::string_view numerics_tag() const override { return "reference"; }

 private:
  template <class Body>
  void for_each_pixel(Body body) {
    for (int y = 0; y < desc_.intrinsics.height; ++y)
      for (int x = 0; x < desc_.intrinsics.width; ++x) {
        const size_t at = static_cast<size_t>(y) * static_cast<size_t>(desc_.intrinsics.width) + static_cast<size_t>(x);
        fragments_.clear();
        if (desc_.wanted.empty() || desc_.wanted[at] != 0) collect_fragments(surfels_, x + 0.5, y + 0.5, fragments_);
        body(at);
      }
  }

  const SplatLayer* layer_ = nullptr;
  RasterDesc desc_;
  RasterCounts counts_;
  SceneCamera<double> view_;
  Vec3d background_;
  std::vector<SurfelValues<double>> values_;
  std::vector<ScreenSurfel<double>> surfels_;
  std::vector<Fragment<double>> fragments_;
};

}  // namespace

std::unique_ptr<Renderer> make_reference_renderer() { return std::make_unique<ReferenceRenderer>(); }

}  // namespace vitrine
