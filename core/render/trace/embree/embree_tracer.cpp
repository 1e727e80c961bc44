// Tracer "embree": single precision, threads, hit lists for the reverse. Same bytes for any number of threads (README 5, 6).
#include "core/render/trace/tracer.h"

#include <algorithm>

#include "core/foundation/base/parallel.h"
#include "core/render/trace/embree/hit_records.h"
#include "core/render/trace/embree/surfel_tree.h"
#include "core/render/trace/kernels/march.h"

namespace vitrine {

namespace {

using namespace embree;

// Records of one batch of the reverse pass: 64 MB.
constexpr size_t kMaxRecords = 1 << 20;

class EmbreeTracer final : public Tracer {
 public:
  void build(const SplatLayer& layer) override {
    layer_ = &layer;
    tree_.build(layer);
  }
  void forward(const RayBatch& rays, const TraceDesc& desc, RayValues& out, HitLists* hits) const override;
  void backward(const RayBatch& rays, const TraceDesc& desc, const HitLists& hits, const TraceBackwardInput& input,
                SplatLayer& grad, RayGradients* ray_gradients, SurfelStatistics* statistics) const override;
  std::string_view name() const override { return "embree"; }

 private:
  int degree(const TraceDesc& desc) const { return std::min(desc.sh_degree, layer_->sh_degree()); }
  TraceRay<float> ray_of(const RayBatch& rays, size_t i) const {
    return {rays.origins[i], rays.directions[i], rays.near.empty() ? 0.f : rays.near[i],
            rays.far.empty() ? std::numeric_limits<float>::infinity() : rays.far[i]};
  }
  Vec3f facing_normal(size_t place, const Vec3f& direction) const {
    const Vec3f n = tree_.shape(place).normal;
    return dot(n, direction) > 0.f ? -n : n;
  }

  struct Reverse;  // shared by all rays of a reverse pass
  void chunk_records(const Reverse& pass, size_t chunk, size_t first_place, RecordBuckets& buckets) const;
  void bucket_gradients(const Reverse& pass, size_t bucket, size_t first_place, const RecordBuckets& buckets) const;

  const SplatLayer* layer_ = nullptr;
  SurfelTree tree_;
};

void EmbreeTracer::forward(const RayBatch& rays, const TraceDesc& desc, RayValues& out, HitLists* hits) const {
  VITRINE_CHECK(layer_ != nullptr, "forward needs build");
  const size_t n = rays.size();
  out.resize(n);
  HitLists order_only;
  HitLists& lists = hits ? *hits : order_only;
  order_rays(rays, lists);
  if (hits) hits->chunks.resize(chunk_count(n, HitLists::kChunk));
  parallel_chunks(n, HitLists::kChunk, [&](size_t chunk, size_t begin, size_t end) {
    static thread_local std::vector<FoundHit> found;
    HitLists::Chunk* keep = hits ? &hits->chunks[chunk] : nullptr;
    if (keep) {
      keep->hits.clear();
      keep->end.clear();
    }
    for (size_t place = begin; place < end; ++place) {
      const size_t i = lists.ray_at[place];
      const TraceRay<float> ray = ray_of(rays, i);
      const RayBasis basis = ray_basis(degree(desc), ray.direction);
      tree_.gather(ray, desc.min_transmittance, found);
      March<float> march;
      for (const FoundHit& hit : found) {
        if (march.sum.transmittance < desc.min_transmittance) break;
        const Vec3f color = tree_.colors().color(hit.place, basis);
        march.blend(hit.t, hit.alpha, color, facing_normal(hit.place, ray.direction), desc.first_hit_weight);
        if (keep) keep->hits.push_back({hit.surfel, hit.t, hit.alpha, color});
      }
      if (keep) keep->end.push_back(static_cast<uint32_t>(keep->hits.size()));
      out.color[i] = march.sum.color;
      out.transmittance[i] = march.sum.transmittance;
      out.distance[i] = march.sum.distance;
      out.first_hit[i] = march.sum.first_hit;
      out.normal[i] = march.sum.normal;
    }
  });
}

struct EmbreeTracer::Reverse {
  const RayBatch& rays;
  const TraceDesc& desc;
  const HitLists& hits;
  const TraceBackwardInput& input;
  SplatLayer& grad;
  RayGradients* ray_gradients;
  SurfelStatistics* statistics;

  MarchValues<float> upstream(size_t ray) const {
    const RayValues& g = *input.gradients;
    return {g.color.empty() ? Vec3f{} : g.color[ray], g.transmittance.empty() ? 0.f : g.transmittance[ray],
            g.distance.empty() ? 0.f : g.distance[ray], g.first_hit.empty() ? 0.f : g.first_hit[ray],
            g.normal.empty() ? Vec3f{} : g.normal[ray]};
  }
};

void EmbreeTracer::chunk_records(const Reverse& pass, size_t chunk, size_t first_place, RecordBuckets& buckets) const {
  static thread_local std::vector<float> in_front;  // transmittance
  const HitLists::Chunk& list = pass.hits.chunks[chunk];
  const size_t begin = chunk * HitLists::kChunk, end = begin + list.end.size();
  const int sh_degree = degree(pass.desc);
  uint32_t* cursors = buckets.cursors(chunk);
  for (size_t at = begin; at < end; ++at) {
    const size_t i = pass.hits.ray_at[at];
    const std::span<const TraceHit> hits = pass.hits.of(i);
    const TraceRay<float> ray = ray_of(pass.rays, i);
    const MarchValues<float> upstream = pass.upstream(i);
    in_front.resize(hits.size());
    float transmittance = 1.f, weight = 0.f;
    size_t first = hits.size();
    for (size_t h = 0; h < hits.size(); ++h) {
      in_front[h] = transmittance;
      weight += hits[h].alpha * transmittance;
      if (first == hits.size() && weight >= pass.desc.first_hit_weight) first = h;
      transmittance *= 1.f - hits[h].alpha;
    }
    Vec3f grad_origin{}, grad_direction{};
    F4 basis_weight[kMaxFours] = {};
    const size_t coefficients = pass.ray_gradients && sh_degree > 0 ? fours(sh_degree) : 0;
    float behind = transmittance * upstream.transmittance;
    for (size_t h = hits.size(); h-- > 0;) {
      const TraceHit& hit = hits[h];
      const uint32_t place = tree_.place_of(hit.surfel);
      const PackedSurfel& s = tree_.shape(place);
      const bool flipped = dot(s.normal, ray.direction) > 0.f;
      const BlendGrad<float> b =
          blend_hit_vjp(in_front[h], hit.t, hit.alpha, hit.color, flipped ? -s.normal : s.normal, h == first, upstream, behind);
      RayHit<float> again;
      again.t = hit.t;
      again.alpha = hit.alpha;
      again.free = hit.alpha < static_cast<float>(kMaxAlpha);
      place_hit<float>(s, ray, again);
      const HitGrad<float> g = ray_splat_vjp<float>(s, ray, again, b.alpha, b.t, flipped ? -b.normal : b.normal);
      HitRecord& record = buckets.at(cursors[buckets.bucket_of(place)]++);
      const uint32_t positive = (hit.color.x > 0.f) | (hit.color.y > 0.f) << 1 | (hit.color.z > 0.f) << 2;
      record.place = place;
      record.ray = static_cast<uint32_t>(at - first_place) | positive << kRayBits;
      record.weight = hit.alpha * in_front[h];
      record.t = hit.t;
      record.moments = g.moments;
      if (!pass.ray_gradients) continue;
      grad_origin += g.origin;
      grad_direction += g.direction;
      for (size_t c = 0; c < 3; ++c) {
        if (!(hit.color[c] > 0.f)) continue;
        const F4* sh = tree_.colors().of(place, c);
        for (size_t k = 0; k < coefficients; ++k) basis_weight[k] += b.color[c] * sh[k];
      }
    }
    if (!pass.ray_gradients) continue;
    if (coefficients > 0) {
      float weights[kMaxShCoefficients];
      for (size_t k = 0; k < kMaxShCoefficients; ++k) weights[k] = basis_weight[k / 4][k % 4];
      grad_direction += sh_basis_vjp(sh_degree, ray.direction, weights);
    }
    pass.ray_gradients->origins[i] = grad_origin;
    pass.ray_gradients->directions[i] = grad_direction;
  }
}

void EmbreeTracer::bucket_gradients(const Reverse& pass, size_t bucket, size_t first_place, const RecordBuckets& buckets) const {
  struct Sum {
    HitMoments<float> moments;
    float t_u, t_v, t_plane;  // gradients of u, v, plane times t
    float weight, error;
    uint32_t hits;
  };
  static thread_local std::vector<Sum> sums;
  static thread_local std::vector<F4> sums_sh;  // [surfel][rgb][fours]
  const std::span<const HitRecord> records = buckets.bucket(bucket);
  if (records.empty()) return;
  const size_t per_bucket = buckets.places_per_bucket(), first = bucket * per_bucket;
  const size_t count = std::min(per_bucket, layer_->size() - first);
  const int sh_degree = degree(pass.desc);
  const size_t stride = fours(sh_degree);
  sums.assign(count, {});
  sums_sh.assign(count * 3 * stride, F4{});
  const bool with_color = !pass.input.gradients->color.empty();
  uint32_t basis_of = ~0u;
  RayBasis basis{};
  for (const HitRecord& r : records) {
    Sum& sum = sums[r.place - first];
    const HitMoments<float>& m = r.moments;
    sum.moments += m;
    ++sum.hits;
    const uint32_t ray = pass.hits.ray_at[first_place + (r.ray & ((1u << kRayBits) - 1))];
    if (pass.statistics) {
      sum.t_u += r.t * m.u;
      sum.t_v += r.t * m.v;
      sum.t_plane += r.t * m.plane;
      sum.weight += r.weight;
      if (!pass.input.error.empty()) sum.error += r.weight * pass.input.error[ray];
    }
    if (!with_color) continue;
    if (ray != basis_of) basis = ray_basis(sh_degree, pass.rays.directions[ray]);
    basis_of = ray;
    const Vec3f& g = pass.input.gradients->color[ray];
    for (size_t c = 0; c < 3; ++c) {
      if (!(r.ray >> (kRayBits + c) & 1)) continue;
      F4* to = sums_sh.data() + (3 * (r.place - first) + c) * stride;
      for (size_t k = 0; k < stride; ++k) to[k] += (r.weight * g[c]) * basis.y[k];
    }
  }
  const size_t coefficients = sh_coefficient_count(sh_degree);
  for (size_t j = 0; j < count; ++j) {
    const Sum& sum = sums[j];
    if (sum.hits == 0) continue;
    const size_t i = tree_.surfel_at(first + j);
    const float *m = layer_->at(Attribute::Mean, i), *q = layer_->at(Attribute::Rotation, i),
                *s = layer_->at(Attribute::LogScale, i);
    const SurfelGeometry<float> raw{{m[0], m[1], m[2]}, {q[0], q[1], q[2], q[3]}, s[0], s[1]};
    const PackedSurfel& surfel = tree_.shape(first + j);
    const RaySurfelGrad<float> g = ray_surfel_vjp(raw, surfel.opacity, sum.moments);
    const float rotation[] = {g.geometry.rotation.w, g.geometry.rotation.x, g.geometry.rotation.y, g.geometry.rotation.z};
    for (size_t c = 0; c < 3; ++c) pass.grad.at(Attribute::Mean, i)[c] += g.geometry.mean[c];
    for (size_t c = 0; c < 4; ++c) pass.grad.at(Attribute::Rotation, i)[c] += rotation[c];
    pass.grad.at(Attribute::LogScale, i)[0] += g.geometry.log_su;
    pass.grad.at(Attribute::LogScale, i)[1] += g.geometry.log_sv;
    *pass.grad.at(Attribute::Opacity, i) += g.raw_opacity;
    for (size_t c = 0; c < 3; ++c) {
      const F4* sh = sums_sh.data() + (3 * j + c) * stride;
      pass.grad.at(Attribute::ShDc, i)[c] += sh[0][0];
      for (size_t k = 1; k < coefficients; ++k) pass.grad.at(Attribute::ShRest, i)[3 * (k - 1) + c] += sh[k / 4][k % 4];
    }
    if (!pass.statistics) continue;
    const Vec3f screen = 0.5f * (sum.t_plane * surfel.normal - sum.t_u * surfel.axis_u - sum.t_v * surfel.axis_v);
    pass.statistics->screen_gradient[i] += length(screen);
    pass.statistics->weight[i] += sum.weight;
    pass.statistics->error[i] += sum.error;
  }
}

void EmbreeTracer::backward(const RayBatch& rays, const TraceDesc& desc, const HitLists& hits, const TraceBackwardInput& input,
                            SplatLayer& grad, RayGradients* ray_gradients, SurfelStatistics* statistics) const {
  VITRINE_CHECK(layer_ != nullptr && input.gradients != nullptr, "backward needs build, a forward pass and gradients");
  VITRINE_CHECK(grad.size() == layer_->size() && grad.sh_degree() == layer_->sh_degree(), "gradient and layer differ in shape");
  VITRINE_CHECK(hits.ray_at.size() == rays.size(), "the hits are not those of the rays");
  if (ray_gradients) {
    ray_gradients->origins.resize(rays.size());
    ray_gradients->directions.resize(rays.size());
  }
  if (statistics)
    for (auto* v : {&statistics->screen_gradient, &statistics->weight, &statistics->error}) v->resize(layer_->size(), 0.f);
  const Reverse pass{rays, desc, hits, input, grad, ray_gradients, statistics};
  RecordBuckets buckets;
  for (size_t begin = 0, end = 0; begin < hits.chunks.size(); begin = end) {
    // At least one chunk; a chunk larger than a batch forms its own batch.
    size_t records = hits.chunks[end++].hits.size();
    while (end < hits.chunks.size() && records + hits.chunks[end].hits.size() <= kMaxRecords)
      records += hits.chunks[end++].hits.size();
    const size_t first_place = begin * HitLists::kChunk;
    buckets.count(hits, begin, end, tree_.places());
    parallel_for(end - begin, 1, [&](size_t c) { chunk_records(pass, begin + c, first_place, buckets); });
    parallel_for(RecordBuckets::kBuckets, 1, [&](size_t b) { bucket_gradients(pass, b, first_place, buckets); });
  }
}

}  // namespace

std::unique_ptr<Tracer> make_embree_tracer() { return std::make_unique<EmbreeTracer>(); }

}  // namespace vitrine
