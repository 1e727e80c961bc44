#include "core/render/model/secondary_rays.h"

#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {
constexpr size_t kRayGrain = 512;  // groups per parallel chunk
}

void ShadedPixels::clear() {
  for (auto* v : {&pixels, &begin, &chosen}) v->clear();
  requests.clear();
  rays.clear();
  for (auto* v : {&points, &grad_points}) v->clear();
}

void SecondaryRays::clear() {
  rays.clear();
  for (auto* v : {&origins, &directions, &radiance, &grad_radiance}) v->clear();
  for (auto* v : {&near, &mean_distance, &alpha, &weight, &inner_transmittance}) v->clear();
  begin.clear();
  values.resize(0);
  gradients = {};
}

void SecondaryRays::gather(size_t groups, std::span<const std::vector<SecondaryRay>> rays_of) {
  rays.clear();
  for (const auto& chunk : rays_of) rays.insert(rays.end(), chunk.begin(), chunk.end());
  begin.assign(groups + 1, 0);
  for (const SecondaryRay& ray : rays) ++begin[ray.group + 1];
  for (size_t g = 0; g < groups; ++g) begin[g + 1] += begin[g];
  origins.resize(rays.size());
  directions.resize(rays.size());
  near.resize(rays.size());
}

void SecondaryRays::trace(const Tracer& tracer, const TraceDesc& desc, const ShadedPixels& shaded, bool keep_hits) {
  if (!keep_hits) hits = {};
  tracer.forward(batch(), desc, values, keep_hits ? &hits : nullptr);
  const size_t groups = shaded.groups();
  radiance.assign(groups, Vec3f{});
  grad_radiance.assign(groups, Vec3f{});
  inner_transmittance.assign(groups, 1.f);
  for (auto* per_ray : {&mean_distance, &alpha, &weight}) per_ray->resize(rays.size());
  for (auto* per_ray : {&gradients.transmittance, &gradients.first_hit}) per_ray->assign(rays.size(), 0.f);
  parallel_chunks(groups, kRayGrain, [&](size_t, size_t first, size_t last) {
    for (size_t g = first; g < last; ++g) {
      float through = 0;
      for (uint32_t i = begin[g]; i < begin[g + 1]; ++i) {
        alpha[i] = 1.f - values.transmittance[i];
        mean_distance[i] = alpha[i] > 0 ? values.distance[i] / alpha[i] : 0.f;
        weight[i] = shaded.weight(g) * rays[i].share;
        radiance[g] += (rays[i].share * rays[i].lobe.weight) * values.color[i];
        through += values.transmittance[i];
      }
      if (begin[g + 1] > begin[g]) inner_transmittance[g] = through / static_cast<float>(begin[g + 1] - begin[g]);
    }
  });
}

void SecondaryRays::trace_back(const Tracer& tracer, const TraceDesc& desc, const ShadedPixels& shaded,
                               std::span<const float> error_image, SplatLayer& grad, RayGradients* ray_gradients) {
  gradients.color.resize(rays.size());
  ray_error_.resize(error_image.empty() ? 0 : rays.size());
  parallel_chunks(rays.size(), kRayGrain, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const SecondaryRay& ray = rays[i];
      gradients.color[i] = (ray.share * ray.lobe.weight) * grad_radiance[ray.group];
      if (!error_image.empty())
        ray_error_[i] = weight[i] * picture_weight[ray.group] * error_image[shaded.chosen_pixel(ray.group)];
    }
  });
  took_part = true;
  tracer.backward(batch(), desc, hits, {.gradients = &gradients, .error = ray_error_}, grad, ray_gradients, &statistics);
}

}  // namespace vitrine
