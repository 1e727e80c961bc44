// Tracer "blocks": layers, rays and lists of hits to the arrays of the kernels, and back. Rays are sorted so that neighbours in
// the arrays start near each other in about the same direction.
#include <algorithm>
#include <utility>

#include "core/foundation/base/parallel.h"
#include "core/render/raster/blocks/device_errors.h"
#include "core/render/trace/blocks/trace_pass.h"
#include "core/render/trace/embree/space_order.h"
#include "core/render/trace/tracer.h"

namespace vitrine {

namespace blocks {
namespace {

// Values of rays in the order of their places.
class OrderedValues {
 public:
  static constexpr size_t kChunk = 4096;  // rays
  // Empty: null.
  const float* scalars(std::span<const float> values, std::span<const uint32_t> ray_at) {
    if (values.empty()) return nullptr;
    return gathered(1, ray_at, [&](float* to, size_t ray) { *to = values[ray]; });
  }
  const float* vectors(std::span<const Vec3f> values, std::span<const uint32_t> ray_at) {
    if (values.empty()) return nullptr;
    return gathered(3, ray_at, [&](float* to, size_t ray) {
      for (size_t c = 0; c < 3; ++c) to[c] = values[ray][c];
    });
  }

 private:
  template <class Write>
  const float* gathered(size_t width, std::span<const uint32_t> ray_at, const Write& write) {
    values_.resize(width * ray_at.size());
    parallel_chunks(ray_at.size(), kChunk, [&](size_t, size_t begin, size_t end) {
      for (size_t place = begin; place < end; ++place) write(values_.data() + width * place, ray_at[place]);
    });
    return values_.data();
  }
  std::vector<float> values_;
};

struct OrderedRays {
  OrderedValues origins, directions, near, far;
  RayArrays of(const RayBatch& rays, std::span<const uint32_t> ray_at) {
    return {origins.vectors(rays.origins, ray_at), directions.vectors(rays.directions, ray_at), near.scalars(rays.near, ray_at),
            far.scalars(rays.far, ray_at), static_cast<uint32_t>(rays.size())};
  }
};

// Chunks of HitLists that one batch of hits takes; at least one.
struct ChunkBatch {
  size_t begin, end;  // chunks
  size_t hits;
  uint32_t first_ray() const { return static_cast<uint32_t>(begin * HitLists::kChunk); }
  uint32_t end_ray(size_t rays) const { return static_cast<uint32_t>(std::min(rays, end * HitLists::kChunk)); }
};
std::vector<ChunkBatch> batches_of(std::span<const size_t> hits_of_chunk, size_t most_hits) {
  std::vector<ChunkBatch> all;
  for (size_t c = 0; c < hits_of_chunk.size(); ++c) {
    if (all.empty() || all.back().hits + hits_of_chunk[c] > most_hits) all.push_back({c, c, 0});
    all.back().end = c + 1;
    all.back().hits += hits_of_chunk[c];
  }
  return all;
}

class BlocksTracer final : public Tracer {
 public:
  BlocksTracer(std::unique_ptr<TracePass> pass, size_t most_hits) : pass_(std::move(pass)), most_hits_(most_hits) {}

  void build(const SplatLayer& layer) override {
    layer_ = &layer;
    rays_ = 0;
    run([&] { pass_->build(build_surfel_bvh(layer), surfel_arrays()); });
  }
  void forward(const RayBatch& rays, const TraceDesc& desc, RayValues& out, HitLists* hits) const override;
  void backward(const RayBatch& rays, const TraceDesc& desc, const HitLists& hits, const TraceBackwardInput& input,
                SplatLayer& grad, RayGradients* ray_gradients, SurfelStatistics* statistics) const override;
  std::string_view name() const override { return "blocks"; }

 private:
  template <class Run>
  void run(const Run& run) const {
    on_device(run, [&] {
      const size_t surfels = layer_->size(), rays = rays_;
      const auto smaller = [=](double share) {
        return fmt::format("{:.0f} surfels, or {:.0f} rays, may fit; or --device cpu", share * static_cast<double>(surfels),
                           share * static_cast<double>(rays));
      };
      return DeviceWork{"the batch of rays", fmt::format("{} surfels, {} rays", surfels, rays), smaller};
    });
  }
  MarchOptions march_options(const TraceDesc& desc) const {
    return {std::min(desc.sh_degree, layer_->sh_degree()), desc.min_transmittance, desc.first_hit_weight};
  }
  SurfelArrays surfel_arrays() const {
    const auto at = [&](Attribute a) { return layer_->width(a) == 0 ? nullptr : layer_->values(a).data(); };
    SurfelArrays s{};
    s.mean = at(Attribute::Mean);
    s.rotation = at(Attribute::Rotation);
    s.log_scale = at(Attribute::LogScale);
    s.opacity = at(Attribute::Opacity);
    s.sh_dc = at(Attribute::ShDc);
    s.sh_rest = at(Attribute::ShRest);
    s.sh_rest_width = static_cast<uint32_t>(layer_->width(Attribute::ShRest));
    s.count = static_cast<uint32_t>(layer_->size());
    return s;
  }
  void count_rays(size_t rays) const {
    rays_ = rays;
    run([&] {
      if (rays > kMostItems) throw ExecutorOverflow("rays");
    });
  }
  void list_hits(std::span<const uint32_t> counts, HitLists& hits) const;

  std::unique_ptr<TracePass> pass_;
  size_t most_hits_;  // on the device at a time
  const SplatLayer* layer_ = nullptr;
  mutable size_t rays_ = 0;  // of the pass that runs, for its errors
};

void BlocksTracer::forward(const RayBatch& rays, const TraceDesc& desc, RayValues& out, HitLists* hits) const {
  VITRINE_CHECK(layer_ != nullptr, "forward needs build");
  const size_t n = rays.size();
  count_rays(n);
  out.resize(n);
  HitLists order_only;
  HitLists& lists = hits ? *hits : order_only;
  embree::order_rays(rays, lists);
  OrderedRays ordered;
  std::vector<float> values(9 * n);
  std::vector<uint32_t> counts(n);
  float* const p = values.data();
  const RayPlanes<float> planes{p, p + 6 * n, p + 7 * n, p + 8 * n, p + 3 * n};
  run([&] { pass_->forward(ordered.of(rays, lists.ray_at), march_options(desc), planes, counts.data()); });
  parallel_chunks(n, OrderedValues::kChunk, [&](size_t, size_t begin, size_t end) {
    for (size_t at = begin; at < end; ++at) {
      const size_t i = lists.ray_at[at];
      for (size_t c = 0; c < 3; ++c) {
        out.color[i][c] = planes.color[3 * at + c];
        out.normal[i][c] = planes.normal[3 * at + c];
      }
      out.transmittance[i] = planes.transmittance[at];
      out.distance[i] = planes.distance[at];
      out.first_hit[i] = planes.first_hit[at];
    }
  });
  if (hits) list_hits(counts, *hits);
}

void BlocksTracer::list_hits(std::span<const uint32_t> counts, HitLists& hits) const {
  const size_t n = counts.size(), chunks = chunk_count(n, HitLists::kChunk);
  hits.chunks.resize(chunks);
  std::vector<size_t> hits_of_chunk(chunks);
  parallel_chunks(n, HitLists::kChunk, [&](size_t c, size_t begin, size_t end) {
    HitLists::Chunk& chunk = hits.chunks[c];
    chunk.end.clear();
    for (size_t at = begin; at < end; ++at) {
      hits_of_chunk[c] += counts[at];
      chunk.end.push_back(static_cast<uint32_t>(hits_of_chunk[c]));
    }
  });
  std::vector<BlendedHit> found;
  for (const ChunkBatch& batch : batches_of(hits_of_chunk, most_hits_)) {
    run([&] { checked_count(static_cast<uint32_t>(std::min<size_t>(batch.hits, ~0u)), "hits of 64 rays"); });
    found.resize(batch.hits);
    uint32_t listed = 0;
    run([&] { listed = pass_->list(batch.first_ray(), batch.end_ray(n), found.data(), static_cast<uint32_t>(found.size())); });
    VITRINE_CHECK(listed == batch.hits, "{} hits were counted and {} found", batch.hits, listed);
    std::vector<size_t> begin(batch.end - batch.begin);
    for (size_t c = 1; c < begin.size(); ++c) begin[c] = begin[c - 1] + hits_of_chunk[batch.begin + c - 1];
    parallel_for(begin.size(), 1, [&](size_t c) {
      std::vector<TraceHit>& to = hits.chunks[batch.begin + c].hits;
      to.clear();
      to.reserve(hits_of_chunk[batch.begin + c]);
      for (size_t h = begin[c]; h < begin[c] + hits_of_chunk[batch.begin + c]; ++h) {
        const BlendedHit& hit = found[h];
        to.push_back({hit.surfel, hit.t, hit.alpha, {hit.color[0], hit.color[1], hit.color[2]}});
      }
    });
  }
}

// Gradients in the arrays of a layer that starts at zero.
SurfelGradients surfel_gradients(SplatLayer& grad, SurfelStatistics& statistics) {
  const auto at = [&](Attribute a) { return grad.width(a) == 0 ? nullptr : grad.values(a).data(); };
  SurfelGradients g{};
  g.mean = at(Attribute::Mean);
  g.rotation = at(Attribute::Rotation);
  g.log_scale = at(Attribute::LogScale);
  g.opacity = at(Attribute::Opacity);
  g.sh_dc = at(Attribute::ShDc);
  g.sh_rest = at(Attribute::ShRest);
  g.screen_gradient = statistics.screen_gradient.data();
  g.weight = statistics.weight.data();
  g.error = statistics.error.data();
  return g;
}

void add(std::span<float> to, std::span<const float> from) {
  for (size_t i = 0; i < from.size(); ++i) to[i] += from[i];
}

void BlocksTracer::backward(const RayBatch& rays, const TraceDesc& desc, const HitLists& hits, const TraceBackwardInput& input,
                            SplatLayer& grad, RayGradients* ray_gradients, SurfelStatistics* statistics) const {
  VITRINE_CHECK(layer_ != nullptr && input.gradients != nullptr, "backward needs build, a forward pass and gradients");
  VITRINE_CHECK(grad.size() == layer_->size() && grad.sh_degree() == layer_->sh_degree(), "gradient and layer differ in shape");
  VITRINE_CHECK(hits.ray_at.size() == rays.size(), "the hits are not those of the rays");
  const size_t n = rays.size();
  count_rays(n);
  OrderedRays ordered;
  OrderedValues color, transmittance, distance, first_hit, normal, error;
  const RayValues& g = *input.gradients;
  const TraceUpstream upstream{{color.vectors(g.color, hits.ray_at), transmittance.scalars(g.transmittance, hits.ray_at),
                                distance.scalars(g.distance, hits.ray_at), first_hit.scalars(g.first_hit, hits.ray_at),
                                normal.vectors(g.normal, hits.ray_at)},
                               error.scalars(input.error, hits.ray_at)};
  run([&] { pass_->start_reverse(ordered.of(rays, hits.ray_at), march_options(desc), upstream, ray_gradients != nullptr); });
  std::vector<size_t> hits_of_chunk;
  for (const HitLists::Chunk& chunk : hits.chunks) hits_of_chunk.push_back(chunk.hits.size());
  std::vector<BlendedHit> found;
  std::vector<uint32_t> counts;
  for (const ChunkBatch& batch : batches_of(hits_of_chunk, most_hits_)) {
    found.clear();
    counts.clear();
    for (size_t c = batch.begin; c < batch.end; ++c) {
      const HitLists::Chunk& chunk = hits.chunks[c];
      for (const TraceHit& h : chunk.hits) found.push_back({h.surfel, h.t, h.alpha, {h.color.x, h.color.y, h.color.z}});
      for (size_t r = 0; r < chunk.end.size(); ++r) counts.push_back(chunk.end[r] - (r == 0 ? 0 : chunk.end[r - 1]));
    }
    run([&] {
      pass_->reverse(batch.first_ray(), batch.end_ray(n), counts.data(), found.data(),
                     checked_count(static_cast<uint32_t>(std::min<size_t>(found.size(), ~0u)), "hits of 64 rays"));
    });
  }
  SplatLayer added = grad.zeros_like();
  SurfelStatistics of_pass;
  of_pass.reset(layer_->size());
  std::vector<float> origins, directions;
  if (ray_gradients != nullptr) {
    origins.resize(3 * n);
    directions.resize(3 * n);
  }
  run([&] { pass_->finish_reverse(surfel_gradients(added, of_pass), origins.data(), directions.data()); });
  for (const AttributeRow& r : kAttributes) add(grad.values(r.id), added.values(r.id));
  if (ray_gradients != nullptr) {
    ray_gradients->origins.resize(n);
    ray_gradients->directions.resize(n);
    for (size_t at = 0; at < n; ++at)
      for (size_t c = 0; c < 3; ++c) {
        ray_gradients->origins[hits.ray_at[at]][c] = origins[3 * at + c];
        ray_gradients->directions[hits.ray_at[at]][c] = directions[3 * at + c];
      }
  }
  if (statistics == nullptr) return;
  for (auto* v : {&statistics->screen_gradient, &statistics->weight, &statistics->error}) v->resize(layer_->size(), 0.f);
  add(statistics->screen_gradient, of_pass.screen_gradient);
  add(statistics->weight, of_pass.weight);
  add(statistics->error, of_pass.error);
}

}  // namespace
}  // namespace blocks

std::unique_ptr<Tracer> make_blocks_tracer(std::unique_ptr<blocks::TracePass> pass, size_t most_hits) {
  return std::make_unique<blocks::BlocksTracer>(std::move(pass), most_hits);
}

std::unique_ptr<Tracer> make_blocks_tracer(uint64_t shuffle_seed) {
  return make_blocks_tracer(std::make_unique<blocks::ExecutorTrace<blocks::BlockLoops>>(blocks::BlockLoops(shuffle_seed)));
}

}  // namespace vitrine
