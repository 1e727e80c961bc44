#include "core/model/bent_rays.h"

#include <algorithm>
#include <utility>

#include "core/base/parallel.h"
#include "core/model/gbuffer.h"
#include "core/render/surface_depth.h"

namespace vitrine {

namespace {
constexpr size_t kBentGrain = 256;  // pixels

struct BentPixels {  // of one chunk
  std::vector<uint32_t> pixels, leg_counts;
  std::vector<BentRay::Leg> legs;
};

}  // namespace

void BentRays::forward(const TransmissionOptions& options, const SplatLayer& opened, Frame& frame) {
  BehindGlass& behind = frame.behind;
  const ShadedPixels& s = frame.shaded;
  const GBuffer g(frame);
  const auto median = frame.diffuse.plane(Aov::MedianZ);
  behind.path.assign(g.pixels, GlassPath::Straight);
  std::vector<BentPixels> found(chunk_count(s.pixels.size(), kBentGrain));
  parallel_chunks(s.pixels.size(), kBentGrain, [&](size_t chunk, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      if (!s.asks[i].transmission) continue;
      const uint32_t pixel = s.pixels[i];
      const PixelRay<float> ray = g.ray(pixel);
      const float z = surface_depth(g.zdepth[pixel], g.alpha[pixel], median[pixel]);
      const BentRay bent = options.thick->path(ray.eye, -ray.view, z * length(ray.direction_per_z));
      behind.path[pixel] = bent.path;
      if (bent.path != GlassPath::Bent) continue;
      found[chunk].pixels.push_back(pixel);
      found[chunk].leg_counts.push_back(bent.leg_count);
      found[chunk].legs.insert(found[chunk].legs.end(), bent.legs.begin(), bent.legs.begin() + bent.leg_count);
    }
  });
  for (auto* v : {&pixels_, &begin_}) v->clear();
  for (auto* v : {&origins_, &directions_}) v->clear();
  far_.clear();
  uint32_t legs = 0;
  for (const BentPixels& f : found) {
    pixels_.insert(pixels_.end(), f.pixels.begin(), f.pixels.end());
    for (const uint32_t count : f.leg_counts) begin_.push_back(std::exchange(legs, legs + count));
    for (const BentRay::Leg& leg : f.legs) {
      origins_.push_back(leg.origin);
      directions_.push_back(leg.direction);
      far_.push_back(leg.length);
    }
  }
  begin_.push_back(legs);
  if (pixels_.empty()) return;

  if (!tracer_) tracer_ = make_tracer(options.backend);
  desc_ = {.sh_degree = opened.sh_degree(), .min_transmittance = options.min_transmittance};
  tracer_->build(opened);
  if (!frame.differentiable) hits_ = {};
  tracer_->forward(batch(), desc_, values_, frame.differentiable ? &hits_ : nullptr);
  parallel_chunks(pixels_.size(), kBentGrain, [&](size_t, size_t first, size_t last) {
    for (size_t p = first; p < last; ++p) {
      Vec3f color{};
      float through = 1;
      for (uint32_t k = begin_[p]; k < begin_[p + 1]; ++k) {
        color += through * values_.color[k];
        through *= values_.transmittance[k];
      }
      for (size_t c = 0; c < 3; ++c) behind.radiance[c * g.pixels + pixels_[p]] = color[c];
      behind.inner_transmittance[pixels_[p]] = through;
    }
  });
}

void BentRays::backward(Frame& frame, std::span<float> blame, SplatLayer& grad, SurfelStatistics& statistics) {
  if (pixels_.empty()) return;
  std::vector<float>& upstream = frame.behind.grad_radiance;
  const size_t all = frame.pixel_count();
  gradients_.color.resize(far_.size());
  gradients_.transmittance.resize(far_.size());
  blame_.resize(blame.empty() ? 0 : far_.size());
  parallel_chunks(pixels_.size(), kBentGrain, [&](size_t, size_t first, size_t last) {
    for (size_t p = first; p < last; ++p) {
      const uint32_t pixel = pixels_[p], begin = begin_[p], end = begin_[p + 1];
      Vec3f g;
      for (size_t c = 0; c < 3; ++c) g[c] = std::exchange(upstream[c * all + pixel], 0.f);
      float through = 1;
      for (uint32_t k = begin; k < end; ++k) {
        gradients_.color[k] = through * g;
        gradients_.transmittance[k] = through;  // times what comes from behind, below
        through *= values_.transmittance[k];
      }
      Vec3f beyond{};
      for (uint32_t k = end; k-- > begin;) {
        gradients_.transmittance[k] *= dot(g, beyond);
        beyond = values_.color[k] + values_.transmittance[k] * beyond;
      }
      if (blame.empty()) continue;
      std::fill(blame_.begin() + begin, blame_.begin() + end, blame[pixel]);
      blame[pixel] = 0;
    }
  });
  tracer_->backward(batch(), desc_, hits_, {.gradients = &gradients_, .error = blame_}, grad, nullptr, &statistics);
}

}  // namespace vitrine
