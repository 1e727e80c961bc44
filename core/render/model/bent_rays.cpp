#include "core/render/model/bent_rays.h"

#include <algorithm>
#include <utility>

#include "core/foundation/base/parallel.h"
#include "core/render/model/gbuffer.h"
#include "core/render/raster/raster_desc.h"

namespace vitrine {

namespace {
constexpr size_t kBentGrain = 256;  // pixels per parallel chunk
constexpr int kPictureRays = 2;     // rays per pixel and axis without gradients: objects appear small in glass

struct BentPixels {  // of one chunk
  std::vector<uint32_t> pixels, leg_counts;
  std::vector<uint8_t> solid;
  std::vector<BentRay::Leg> legs;
};

}  // namespace

void BentLegs::find(const ThickGlass& glass, const Frame& frame, std::span<const uint32_t> asking, std::span<GlassPath> path,
                    int side) {
  const GBuffer g(frame);
  const auto median = frame.diffuse.plane(Aov::MedianZ);
  std::vector<BentPixels> found(chunk_count(asking.size(), kBentGrain));
  parallel_chunks(asking.size(), kBentGrain, [&](size_t chunk, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const uint32_t pixel = asking[i];
      const float z = surface_depth(g.zdepth[pixel], g.alpha[pixel], median[pixel]);
      for (int k = 0; k < side * side; ++k) {
        const auto off = [&](int at) { return (float(at) + 0.5f) / float(side) - 0.5f; };
        const PixelRay<float> ray = g.ray(pixel, off(k % side), off(k / side));
        const BentRay bent = glass.path(ray.eye, -ray.view, z * length(ray.direction_per_z));
        if (path[pixel] != GlassPath::Bent) path[pixel] = bent.path;
        if (bent.path != GlassPath::Bent) continue;
        found[chunk].pixels.push_back(pixel);
        found[chunk].leg_counts.push_back(bent.leg_count);
        found[chunk].solid.push_back(frame.sheets.shows_solid(pixel));
        found[chunk].legs.insert(found[chunk].legs.end(), bent.legs.begin(), bent.legs.begin() + bent.leg_count);
      }
    }
  });
  for (auto* v : {&pixels, &begin}) v->clear();
  for (auto* v : {&origins, &directions}) v->clear();
  far.clear(), passed.clear();
  uint32_t legs = 0;
  for (const BentPixels& f : found) {
    pixels.insert(pixels.end(), f.pixels.begin(), f.pixels.end());
    size_t leg = 0;
    for (size_t p = 0; p < f.pixels.size(); ++p) {
      begin.push_back(std::exchange(legs, legs + f.leg_counts[p]));
      for (const size_t end = leg + f.leg_counts[p]; leg < end; ++leg) {
        origins.push_back(f.legs[leg].origin);
        directions.push_back(f.legs[leg].direction);
        far.push_back(f.legs[leg].length);
        passed.push_back(f.solid[p] ? f.legs[leg].passed : 1.f);
      }
    }
  }
  begin.push_back(legs);
}

BentLegs::Shown BentLegs::shown(size_t bent_pixel, const RayValues& values) const {
  Shown out;
  for (uint32_t k = begin[bent_pixel]; k < begin[bent_pixel + 1]; ++k) {
    out.transmittance *= passed[k];
    out.color += out.transmittance * values.color[k];
    out.transmittance *= values.transmittance[k];
  }
  return out;
}

void BentRays::forward(const TransmissionOptions& options, const SplatLayer& opened, Frame& frame) {
  BehindGlass& behind = frame.behind;
  const ShadedPixels& s = frame.shaded;
  const size_t all = frame.pixel_count();
  behind.path.assign(all, GlassPath::Straight);
  requesting_.clear();
  for (size_t i = 0; i < s.pixels.size(); ++i)
    if (s.requests[i].transmission) requesting_.push_back(s.pixels[i]);
  const int side = frame.differentiable ? 1 : kPictureRays;
  legs_.find(*options.thick, frame, requesting_, behind.path, side);
  if (legs_.pixels.empty()) return;

  if (!tracer_) tracer_ = make_tracer(options.backend);
  desc_ = {.sh_degree = opened.sh_degree(), .min_transmittance = options.min_transmittance};
  tracer_->build(opened);
  if (!frame.differentiable) hits_ = {};
  tracer_->forward(legs_.batch(), desc_, values_, frame.differentiable ? &hits_ : nullptr);
  parallel_chunks(legs_.pixels.size(), kBentGrain, [&](size_t, size_t first, size_t last) {
    for (size_t p = first; p < last; ++p) {
      const uint32_t pixel = legs_.pixels[p];
      if (p > 0 && legs_.pixels[p - 1] == pixel) continue;  // the first of a pixel's rays already sums them up
      BentLegs::Shown mean{.color = {}, .transmittance = 0};
      float rays = 0;
      for (size_t q = p; q < legs_.pixels.size() && legs_.pixels[q] == pixel; ++q, ++rays) {
        const BentLegs::Shown shown = legs_.shown(q, values_);
        mean.color += shown.color, mean.transmittance += shown.transmittance;
      }
      for (size_t c = 0; c < 3; ++c) behind.radiance[c * all + pixel] = mean.color[c] / rays;
      behind.inner_transmittance[pixel] = mean.transmittance / rays;
    }
  });
}

void BentRays::backward(Frame& frame, std::span<float> error_image, SplatLayer& grad, SurfelStatistics& statistics) {
  if (legs_.pixels.empty()) return;
  std::vector<float>& upstream = frame.behind.grad_radiance;
  const size_t all = frame.pixel_count();
  gradients_.color.resize(legs_.far.size());
  gradients_.transmittance.resize(legs_.far.size());
  ray_error_.resize(error_image.empty() ? 0 : legs_.far.size());
  parallel_chunks(legs_.pixels.size(), kBentGrain, [&](size_t, size_t first, size_t last) {
    for (size_t p = first; p < last; ++p) {
      const uint32_t pixel = legs_.pixels[p], begin = legs_.begin[p], end = legs_.begin[p + 1];
      Vec3f g;
      for (size_t c = 0; c < 3; ++c) g[c] = std::exchange(upstream[c * all + pixel], 0.f);
      float through = 1;
      for (uint32_t k = begin; k < end; ++k) {
        through *= legs_.passed[k];
        gradients_.color[k] = through * g;
        gradients_.transmittance[k] = through;  // multiplied by the radiance behind, below
        through *= values_.transmittance[k];
      }
      Vec3f beyond{};
      for (uint32_t k = end; k-- > begin;) {
        gradients_.transmittance[k] *= dot(g, beyond);
        beyond = legs_.passed[k] * (values_.color[k] + values_.transmittance[k] * beyond);
      }
      if (error_image.empty()) continue;
      std::fill(ray_error_.begin() + begin, ray_error_.begin() + end, error_image[pixel]);
      error_image[pixel] = 0;
    }
  });
  tracer_->backward(legs_.batch(), desc_, hits_, {.gradients = &gradients_, .error = ray_error_}, grad, nullptr, &statistics);
}

}  // namespace vitrine
