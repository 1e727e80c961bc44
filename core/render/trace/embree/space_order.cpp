#include "core/render/trace/embree/space_order.h"

#include "core/foundation/base/parallel.h"
#include "core/render/trace/embree/morton.h"

namespace vitrine::embree {

namespace {

constexpr size_t kChunk = 8192;  // items
constexpr int kSurfelBits = 10;  // cells per axis: 1024
constexpr int kOriginBits = 5;   // 32: rays of a cell share most of their hits
constexpr int kOctantBits = 3;   // of directions

void invert(const std::vector<uint32_t>& order, std::vector<uint32_t>& place) {
  place.resize(order.size());
  for (size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<uint32_t>(i);
}

}  // namespace

void SpaceOrder::build(const SplatLayer& layer) {
  std::vector<Vec3f> means(layer.size());
  for (size_t i = 0; i < means.size(); ++i) {
    const float* m = layer.at(Attribute::Mean, i);
    means[i] = {m[0], m[1], m[2]};
  }
  const MortonGrid grid(means, kSurfelBits);
  std::vector<uint32_t> codes(means.size());
  parallel_chunks(means.size(), kChunk, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) codes[i] = grid.code(means[i]);
  });
  order_by_code(codes, 3 * kSurfelBits, surfel_at);
  invert(surfel_at, place_of);
}

void order_rays(const RayBatch& rays, HitLists& lists) {
  const MortonGrid grid(rays.origins, kOriginBits);
  std::vector<uint32_t> codes(rays.size());
  parallel_chunks(rays.size(), kChunk, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Vec3f& d = rays.directions[i];
      const uint32_t octant = uint32_t(d.x > 0.f) | uint32_t(d.y > 0.f) << 1 | uint32_t(d.z > 0.f) << 2;
      codes[i] = grid.code(rays.origins[i]) << kOctantBits | octant;
    }
  });
  order_by_code(codes, 3 * kOriginBits + kOctantBits, lists.ray_at);
  invert(lists.ray_at, lists.place_of);
}

}  // namespace vitrine::embree
