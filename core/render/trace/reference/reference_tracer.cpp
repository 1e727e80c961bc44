// Tracer "reference": double, O(rays x surfels), one thread. For tests, benchmark checks and debugging.
#include "core/render/trace/tracer.h"

#include <numeric>

#include "core/foundation/base/parallel.h"
#include "core/render/trace/reference/reference_trace.h"

namespace vitrine {

namespace {

using namespace reference;

class ReferenceTracer final : public Tracer {
 public:
  void build(const SplatLayer& layer) override {
    layer_ = &layer;
    values_.assign(layer.size(), {});
    surfels_.clear();
    for (size_t i = 0; i < layer.size(); ++i) {
      visit_values(layer, values_[i], [&](double& v, Attribute a, size_t c) { v = static_cast<double>(layer.at(a, i)[c]); });
      surfels_.push_back(trace_surfel(values_[i]));
    }
  }

  void forward(const RayBatch& rays, const TraceDesc& desc, RayValues& out, HitLists* hits) const override {
    VITRINE_CHECK(layer_ != nullptr, "forward needs build");
    out.resize(rays.size());
    if (hits) {
      hits->chunks.assign(chunk_count(rays.size(), HitLists::kChunk), {});
      hits->ray_at.resize(rays.size());
      std::iota(hits->ray_at.begin(), hits->ray_at.end(), 0u);
      hits->place_of = hits->ray_at;
    }
    std::vector<BlendedHit<double>> blended;
    for (size_t i = 0; i < rays.size(); ++i) {
      const MarchValues<double> v = trace_ray(surfels_, ray_of(rays, i), march_desc(desc), blended);
      out.color[i] = cast<float>(v.color);
      out.transmittance[i] = static_cast<float>(v.transmittance);
      out.distance[i] = static_cast<float>(v.distance);
      out.first_hit[i] = static_cast<float>(v.first_hit);
      out.normal[i] = cast<float>(v.normal);
      if (!hits) continue;
      HitLists::Chunk& chunk = hits->chunks[i / HitLists::kChunk];
      for (const auto& h : blended)
        chunk.hits.push_back({static_cast<uint32_t>(h.surfel), static_cast<float>(h.hit.t), static_cast<float>(h.hit.alpha),
                              cast<float>(h.color)});
      chunk.end.push_back(static_cast<uint32_t>(chunk.hits.size()));
    }
  }

  // Traces again in double: the hit lists are not used.
  void backward(const RayBatch& rays, const TraceDesc& desc, const HitLists&, const TraceBackwardInput& input, SplatLayer& grad,
                RayGradients* ray_gradients, SurfelStatistics* statistics) const override {
    VITRINE_CHECK(layer_ != nullptr && input.gradients != nullptr, "backward needs build, a forward pass and gradients");
    std::vector<TraceSums<double>> sums(surfels_.size());
    std::vector<BlendedHit<double>> blended;
    if (ray_gradients) {
      ray_gradients->origins.assign(rays.size(), {});
      ray_gradients->directions.assign(rays.size(), {});
    }
    for (size_t i = 0; i < rays.size(); ++i) {
      const RayValues& upstream = *input.gradients;
      MarchValues<double> g;
      if (!upstream.color.empty()) g.color = cast<double>(upstream.color[i]);
      if (!upstream.transmittance.empty()) g.transmittance = static_cast<double>(upstream.transmittance[i]);
      if (!upstream.distance.empty()) g.distance = static_cast<double>(upstream.distance[i]);
      if (!upstream.first_hit.empty()) g.first_hit = static_cast<double>(upstream.first_hit[i]);
      if (!upstream.normal.empty()) g.normal = cast<double>(upstream.normal[i]);
      const double error = input.error.empty() ? 0.0 : static_cast<double>(input.error[i]);
      const TraceRay<double> ray = ray_of(rays, i);
      const MarchValues<double> v = trace_ray(surfels_, ray, march_desc(desc), blended);
      const RayGrad<double> r = trace_ray_vjp(surfels_, ray, march_desc(desc), blended, v, g, error, sums);
      if (!ray_gradients) continue;
      ray_gradients->origins[i] = cast<float>(r.origin);
      ray_gradients->directions[i] = cast<float>(r.direction);
    }
    if (statistics)
      for (auto* v : {&statistics->screen_gradient, &statistics->weight, &statistics->error}) v->resize(surfels_.size(), 0.f);
    for (size_t i = 0; i < surfels_.size(); ++i) {
      const RaySurfelGrad<double> shape = ray_surfel_vjp(values_[i].geometry, surfels_[i].shape.opacity, sums[i].moments);
      SurfelValues<double> g;
      g.geometry = shape.geometry;
      g.opacity = shape.raw_opacity;
      g.sh = sums[i].sh;
      visit_values(*layer_, g, [&](double& v, Attribute a, size_t c) { grad.at(a, i)[c] += static_cast<float>(v); });
      if (!statistics) continue;
      statistics->screen_gradient[i] += static_cast<float>(length(sums[i].screen));
      statistics->weight[i] += static_cast<float>(sums[i].weight);
      statistics->error[i] += static_cast<float>(sums[i].error);
    }
  }

  std::string_view name() const override { return "reference"; }

 private:
  TraceRay<double> ray_of(const RayBatch& rays, size_t i) const {
    return {cast<double>(rays.origins[i]), cast<double>(rays.directions[i]),
            rays.near.empty() ? 0.0 : static_cast<double>(rays.near[i]),
            rays.far.empty() ? std::numeric_limits<double>::infinity() : static_cast<double>(rays.far[i])};
  }
  MarchDesc<double> march_desc(const TraceDesc& desc) const {
    return {std::min(desc.sh_degree, layer_->sh_degree()), static_cast<double>(desc.min_transmittance),
            static_cast<double>(desc.first_hit_weight)};
  }

  const SplatLayer* layer_ = nullptr;
  std::vector<SurfelValues<double>> values_;
  std::vector<TraceSurfel<double>> surfels_;
};

}  // namespace

std::unique_ptr<Tracer> make_reference_tracer() { return std::make_unique<ReferenceTracer>(); }

}  // namespace vitrine
