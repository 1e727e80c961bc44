#include "core/render/model/medium_pass.h"

#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {

constexpr size_t kMediumRows = 8;
constexpr float kLeastCoverage = 1e-4f;  // below, a pixel has no distance

// Distance of pixels along their rays.
class Distances {
 public:
  explicit Distances(const Frame& frame)
      : k_(frame.view->intrinsics), zdepth_(frame.diffuse.plane(Aov::ZDepth)), alpha_(frame.diffuse.plane(Aov::Alpha)) {}

  float alpha(size_t pixel) const { return alpha_[pixel]; }
  // |ray| / A, the derivative of the distance by Z; 0 without a surface.
  float per_zdepth(size_t pixel) const {
    if (!(alpha_[pixel] > kLeastCoverage)) return 0;
    const auto width = static_cast<size_t>(k_.width);
    const Vec3d ray = k_.ray(double(pixel % width) + 0.5, double(pixel / width) + 0.5);
    return static_cast<float>(length(ray)) / alpha_[pixel];
  }
  float zdepth(size_t pixel) const { return zdepth_[pixel]; }

 private:
  const Intrinsics& k_;
  std::span<const float> zdepth_, alpha_;
};

size_t band_pixels(const Frame& frame) { return kMediumRows * static_cast<size_t>(frame.view->intrinsics.width); }

}  // namespace

void MediumPass::forward(const SplatScene&, Frame& frame) {
  frame.clear.clear();
  if (!frame.options.medium) return;
  const MediumCoefficients<double>& m = *frame.options.medium;
  const Vec3f direct = cast<float>(m.direct), backscatter = cast<float>(m.backscatter), veil = cast<float>(m.veil);
  const size_t pixels = frame.pixel_count();
  const Distances distances(frame);
  frame.clear = frame.linear;
  parallel_chunks(pixels, band_pixels(frame), [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const float z = distances.per_zdepth(i) * distances.zdepth(i), a = distances.alpha(i);
      for (size_t c = 0; c < 3; ++c) {
        float& value = frame.linear[c * pixels + i];
        value = seen_through_medium(value, z, a, direct[c], backscatter[c], veil[c]);
      }
    }
  });
}

void MediumPass::backward(const SplatScene&, Frame& frame, SplatScene&) {
  gradient_ = {};
  if (!frame.options.medium) return;
  const MediumCoefficients<double>& m = *frame.options.medium;
  const Vec3f direct = cast<float>(m.direct), backscatter = cast<float>(m.backscatter), veil = cast<float>(m.veil);
  const size_t pixels = frame.pixel_count();
  const Distances distances(frame);
  const std::span<float> grad_z = frame.grad_diffuse.plane(Aov::ZDepth), grad_alpha = frame.grad_diffuse.plane(Aov::Alpha);
  std::vector<MediumCoefficients<double>> sums(chunk_count(pixels, band_pixels(frame)));
  parallel_chunks(pixels, band_pixels(frame), [&](size_t band, size_t first, size_t last) {
    MediumCoefficients<double>& sum = sums[band];
    for (size_t i = first; i < last; ++i) {
      const float per_z = distances.per_zdepth(i), z = per_z * distances.zdepth(i), a = distances.alpha(i);
      float on_distance = 0, on_coverage = 0;
      for (size_t c = 0; c < 3; ++c) {
        float& grad = frame.grad_linear[c * pixels + i];
        const MediumGradient<float> g =
            seen_through_medium_vjp(frame.clear[c * pixels + i], z, a, direct[c], backscatter[c], veil[c], grad);
        grad = g.clear;
        on_distance += g.distance;
        on_coverage += g.coverage;
        sum.direct[c] += double(g.direct);
        sum.backscatter[c] += double(g.backscatter);
        sum.veil[c] += double(g.veil);
      }
      grad_z[i] += per_z * on_distance;
      grad_alpha[i] += on_coverage - (per_z > 0 ? z * on_distance / a : 0.f);
    }
  });
  for (const MediumCoefficients<double>& sum : sums) {
    gradient_.direct += sum.direct;
    gradient_.backscatter += sum.backscatter;
    gradient_.veil += sum.veil;
  }
}

}  // namespace vitrine
