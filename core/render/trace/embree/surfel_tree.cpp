#include "core/render/trace/embree/surfel_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/foundation/base/parallel.h"
#include "core/render/trace/embree/simd8.h"
#include "core/scene/mesh/embree_device.h"
#include "core/scene/mesh/embree_version.h"
#include "core/scene/surfels/activation.h"

namespace vitrine::embree {

namespace {

constexpr size_t kPackChunk = 4096;  // surfels
// Padding of the boxes: by this share of their distance from the origin, so that rounding in t, u and v never puts a hit
// outside its box; and by this share of the surfel's size.
constexpr float kPad = 4e-6f;
constexpr uint32_t kLanes = 8;
// Tolerance of the running transmittance, a product of the hits in arbitrary order, compared with the product of the sorted list.
constexpr float kProductSlack = 1.01f;

}  // namespace

// State of one ray during traversal. Embree reports surfels whose box the ray hits; they are collected until there are eight,
// while their records are prefetched, and then evaluated together.
struct SurfelTree::Gathering : RayContext {
  const SurfelTree* tree;
  TraceRay<float> ray;
  float min_transmittance;
  float behind_all = 1.f;
  std::vector<FoundHit>* hits;
  uint32_t waiting_count = 0;
  uint32_t waiting[kLanes];

  void evaluate() {
    if (waiting_count == 0) return;
    const float* records[kLanes];
    for (uint32_t i = 0; i < kLanes; ++i)
      records[i] = reinterpret_cast<const float*>(&tree->surfels_[waiting[i < waiting_count ? i : 0]]);
    V8 c[16];
    load_columns(records, 0, c);
    load_columns(records, 8, c + 8);
    const RaySurfel<V8> s{{c[0], c[1], c[2]},  c[3],  {c[4], c[5], c[6]},    c[7],
                          {c[8], c[9], c[10]}, c[11], {c[12], c[13], c[14]}, c[15]};
    const TraceRay<V8> r{
        {ray.origin.x, ray.origin.y, ray.origin.z}, {ray.direction.x, ray.direction.y, ray.direction.z}, ray.near, ray.far};
    const RayHit<V8> hit = ray_splat(s, r);
    alignas(32) float t[kLanes], alpha[kLanes];
    _mm256_store_ps(t, hit.t.v);
    _mm256_store_ps(alpha, hit.alpha.v);
    for (uint32_t left = bits(hit.counts) & ((1u << waiting_count) - 1); left != 0; left &= left - 1) {
      const uint32_t i = static_cast<uint32_t>(std::countr_zero(left)), place = waiting[i];
      tree->colors_.prefetch(place);
      insert({t[i], tree->order_.surfel_at[place], alpha[i], place});
    }
    waiting_count = 0;
    if (behind_all < min_transmittance * kProductSlack) cut();
  }

  void insert(const FoundHit& hit) {
    std::vector<FoundHit>& list = *hits;
    list.push_back(hit);
    size_t at = list.size() - 1;
    const auto behind = [&](const FoundHit& other) { return other.t > hit.t || (other.t == hit.t && other.surfel > hit.surfel); };
    for (; at > 0 && behind(list[at - 1]); --at) list[at] = list[at - 1];
    list[at] = hit;
    behind_all *= 1.f - hit.alpha;
  }

  // Hits behind the one at which the transmittance falls below the minimum are never blended. Later hits only move that end
  // closer, so dropping them now is exact.
  void cut() {
    float transmittance = 1.f;
    for (size_t i = 0; i < hits->size(); ++i) {
      transmittance *= 1.f - (*hits)[i].alpha;
      if (transmittance >= min_transmittance) continue;
      hits->resize(i + 1);
      ray.far = hits->back().t;
      behind_all = transmittance;
      return;
    }
  }
};

void SurfelTree::bounds(const RTCBoundsFunctionArguments* args) {
  const auto& tree = *static_cast<const SurfelTree*>(args->geometryUserPtr);
  const PackedSurfel& s = tree.surfels_[args->primID];
  // axis / |axis|^2 is s_u r0: the half axes of the ellipse rho = cut.
  const float cu = s.cut * s.var_u * s.var_u, cv = s.cut * s.var_v * s.var_v;
  RTCBounds& b = *args->bounds_o;
  if (!(s.cut > 0.f)) {  // too transparent to be visible: an empty box is left out of the tree
    b.lower_x = b.lower_y = b.lower_z = std::numeric_limits<float>::infinity();
    b.upper_x = b.upper_y = b.upper_z = -std::numeric_limits<float>::infinity();
    return;
  }
  float low[3], high[3];
  for (size_t c = 0; c < 3; ++c) {
    const float u = s.axis_u[c], v = s.axis_v[c];
    const float half = std::sqrt(cu * u * u + cv * v * v);
    const float pad = kPad * (std::abs(s.mean[c]) + std::sqrt(s.cut * std::max(s.var_u, s.var_v)));
    low[c] = s.mean[c] - half - pad;
    high[c] = s.mean[c] + half + pad;
  }
  b.lower_x = low[0], b.lower_y = low[1], b.lower_z = low[2];
  b.upper_x = high[0], b.upper_y = high[1], b.upper_z = high[2];
}

void SurfelTree::intersect(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  auto& g = *static_cast<Gathering*>(args->context);
  __builtin_prefetch(&g.tree->surfels_[args->primID]);
  g.waiting[g.waiting_count++] = args->primID;
  if (g.waiting_count < kLanes) return;
  g.evaluate();
  RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, 1), 1, 0) = g.ray.far;
}

void SurfelTree::build(const SplatLayer& layer) {
  order_.build(layer);
  surfels_.resize(layer.size());
  parallel_chunks(layer.size(), kPackChunk, [&](size_t, size_t begin, size_t end) {
    for (size_t place = begin; place < end; ++place) {
      const size_t i = order_.surfel_at[place];
      const float *m = layer.at(Attribute::Mean, i), *q = layer.at(Attribute::Rotation, i), *s = layer.at(Attribute::LogScale, i);
      const SurfelGeometry<float> raw{{m[0], m[1], m[2]}, {q[0], q[1], q[2], q[3]}, s[0], s[1]};
      static_cast<RaySurfel<float>&>(surfels_[place]) = ray_surfel(raw, sigmoid(*layer.at(Attribute::Opacity, i)));
    }
  });
  colors_.build(layer, order_.surfel_at);
  scene_ = Scene::robust();
  RTCGeometry geometry = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(surfels_.size()));
  rtcSetGeometryUserData(geometry, this);
  rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_.get());
}

void SurfelTree::gather(const TraceRay<float>& ray, float min_transmittance, std::vector<FoundHit>& out) const {
  out.clear();
  Gathering g;
  g.tree = this;
  g.ray = ray;
  g.min_transmittance = min_transmittance;
  g.hits = &out;
  RTCRayHit r = ray_hit(ray.origin, ray.direction, std::max(0.f, ray.near), ray.far);
  embree::intersect(scene_.get(), g, r);
  g.evaluate();
}

}  // namespace vitrine::embree
