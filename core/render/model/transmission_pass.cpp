#include "core/render/model/transmission_pass.h"

#include <algorithm>

#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {

constexpr size_t kTransmissionGrain = 512;

TraceDesc trace_desc(const TransmissionOptions& o, const SplatLayer& layer) {
  return {.sh_degree = std::min(o.sh_degree, layer.sh_degree()), .min_transmittance = o.min_transmittance};
}

}  // namespace

void TransmissionPass::forward(const SplatScene& scene, Frame& frame) {
  SecondaryRays& r = frame.transmission;
  const ShadedPixels& s = frame.shaded;
  const TransmissionOptions& options = frame.options.transmission;
  r.clear();
  if (options.glass != Glass::Traced || scene.transmittance.size() == 0 || s.groups() == 0) return;
  tracer_->build(scene.transmittance);
  rays_.clear();
  for (size_t g = 0; g < s.groups(); ++g) {
    if (!s.requested(g).transmission) continue;
    SecondaryRay ray;
    ray.group = static_cast<uint32_t>(g);
    ray.lobe.direction = -s.rays[g].view;
    ray.lobe.weight = 1;
    rays_.push_back(ray);
  }
  r.gather(s.groups(), std::span(&rays_, 1));
  parallel_chunks(r.rays.size(), kTransmissionGrain, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      r.origins[i] = s.points[r.rays[i].group].position;
      r.directions[i] = r.rays[i].lobe.direction;
      r.near[i] = options.near;
    }
  });
  r.trace(*tracer_, trace_desc(options, scene.transmittance), s, frame.differentiable);
}

void TransmissionPass::backward(const SplatScene& scene, Frame& frame, SplatScene& grad) {
  if (frame.transmission.rays.empty()) return;
  frame.transmission.trace_back(*tracer_, trace_desc(frame.options.transmission, scene.transmittance), frame.shaded,
                                frame.error_image, grad.transmittance, nullptr);
}

}  // namespace vitrine
