// First hits of secondary rays (algorithms 5.5). For the rays of one layer, with t the first hit, tbar the mean distance and A
// the alpha of a ray (the last two held constant), and r the minimum distance of the layer's surfels:
//   L = sum_rays v A [ max(0, r + delta - t) + eta |t - tbar| ] / (R sum_rays v),   R = scene radius
// The first term keeps the layer away from the surface that transmits or reflects it, the second makes its first surface
// compact. The losses of transmitted and reflected rays are added.
#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/learn/loss/loss.h"
#include "core/learn/loss/target_mask.h"

namespace vitrine {

namespace {

constexpr size_t kChunk = 4096;
constexpr float kSceneRadius = 1;             // the sfm stage scales the ring of cameras to it
constexpr float kTransmissionMargin = 0.01f;  // delta: transmitted light starts this far behind the front surface, scene radii
constexpr float kReflectionMargin = 0.02f;    // delta: reflected objects are at least this far from the reflector, scene radii
constexpr float kSpread = 0.1f;               // eta: weight of the first hit's distance to the mean hit

class FirstHitLoss final : public Loss {
 public:
  std::string_view name() const override { return "first_hit"; }

  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    return of_layer(input.transmission, kTransmissionMargin, scale, gradient.transmission_first_hit) +
           of_layer(input.reflection, kReflectionMargin, scale, gradient.reflection_first_hit);
  }

 private:
  double of_layer(const LossRays& rays, float margin, double scale, std::span<float> grad) {
    const size_t count = rays.first_hit.size();
    if (count == 0) return 0;
    const auto fits = [&](std::span<const float> values) { return values.size() == count; };
    VITRINE_CHECK(fits(rays.mean_distance) && fits(rays.alpha) && (rays.wall.empty() || fits(rays.wall)) &&
                      (rays.weight.empty() || fits(rays.weight)) && (grad.empty() || fits(grad)),
                  "rays of different numbers");
    const double total = kSceneRadius * (rays.weight.empty() ? static_cast<double>(count) : sum_of(rays.weight));
    if (total <= 0) return 0;
    const float step = static_cast<float>(scale / total);
    sums_.assign(chunk_count(count, kChunk), 0.0);
    parallel_chunks(count, kChunk, [&](size_t chunk, size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const float t = rays.first_hit[i], wall = rays.wall.empty() ? 0.f : rays.wall[i];
        if (t <= 0) continue;
        const float v = rays.alpha[i] * (rays.weight.empty() ? 1.f : rays.weight[i]);
        const float before = std::max(0.f, wall + margin * kSceneRadius - t), off = t - rays.mean_distance[i];
        sums_[chunk] += v * (before + kSpread * std::abs(off));
        const float slope = (before > 0 ? -1.f : 0.f) + (off == 0 ? 0.f : std::copysign(kSpread, off));
        if (!grad.empty()) grad[i] += step * v * slope;
      }
    });
    double sum = 0;
    for (double s : sums_) sum += s;
    return sum / total;
  }

  std::vector<double> sums_;
};

}  // namespace

std::unique_ptr<Loss> make_first_hit_loss() { return std::make_unique<FirstHitLoss>(); }

}  // namespace vitrine
