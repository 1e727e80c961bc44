#include "core/trace/embree/surfel_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/scene/activation.h"

namespace vitrine::embree {

namespace {

constexpr size_t kPackChunk = 4096;  // surfels
// Boxes are wider than the ellipse by this share of their distance from the origin, so that rounding in t, u and v never puts a
// hit outside of its box; and by this share of the surfel's size.
constexpr float kPad = 4e-6f;
// The transmittance is looked at after so many new hits.
constexpr size_t kBatch = 16;

struct Gathering : RTCIntersectContext {
  const PackedSurfel* surfels;
  TraceRay<float> ray;
  float min_transmittance;
  std::vector<FoundHit>* hits;
  size_t look_at;  // number of hits at which to look for the end

  void insert(const FoundHit& hit, float& far) {
    std::vector<FoundHit>& list = *hits;
    list.push_back(hit);
    size_t at = list.size() - 1;
    const auto behind = [&](const FoundHit& other) { return other.t > hit.t || (other.t == hit.t && other.surfel > hit.surfel); };
    for (; at > 0 && behind(list[at - 1]); --at) list[at] = list[at - 1];
    list[at] = hit;
    if (list.size() < look_at) return;
    // What lies behind the last hit in front of which enough light is left is never blended. Any later hit only brings the end
    // nearer, so that dropping it now is exact.
    float transmittance = 1.f;
    for (size_t i = 0; i < list.size(); ++i) {
      transmittance *= 1.f - list[i].alpha;
      if (transmittance >= min_transmittance) continue;
      list.resize(i + 1);
      far = ray.far = list[i].t;
      break;
    }
    look_at = list.size() + kBatch;
  }
};

}  // namespace

void SurfelTree::bounds(const RTCBoundsFunctionArguments* args) {
  const auto& tree = *static_cast<const SurfelTree*>(args->geometryUserPtr);
  const PackedSurfel& s = tree.surfels_[args->primID];
  // axis / |axis|^2 is s_u r0: the half axes of the ellipse rho = cut, widened by the largest footprint (which also lowers the
  // opacity; the bound is that of the full one).
  const float wide = tree.max_footprint_ * tree.max_footprint_;
  const float cu = s.cut * (s.var_u + wide) * s.var_u, cv = s.cut * (s.var_v + wide) * s.var_v;
  RTCBounds& b = *args->bounds_o;
  if (!(s.cut > 0.f)) {  // too transparent to show: an empty box is left out of the tree
    b.lower_x = b.lower_y = b.lower_z = std::numeric_limits<float>::infinity();
    b.upper_x = b.upper_y = b.upper_z = -std::numeric_limits<float>::infinity();
    return;
  }
  float low[3], high[3];
  for (size_t c = 0; c < 3; ++c) {
    const float u = s.axis_u[c], v = s.axis_v[c];
    const float half = std::sqrt(cu * u * u + cv * v * v);
    const float pad = kPad * (std::abs(s.mean[c]) + std::sqrt(s.cut * (std::max(s.var_u, s.var_v) + wide)));
    low[c] = s.mean[c] - half - pad;
    high[c] = s.mean[c] + half + pad;
  }
  b.lower_x = low[0], b.lower_y = low[1], b.lower_z = low[2];
  b.upper_x = high[0], b.upper_y = high[1], b.upper_z = high[2];
}

void SurfelTree::intersect(const RTCIntersectFunctionNArguments* args) {
  if (!args->valid[0]) return;
  auto& g = *static_cast<Gathering*>(args->context);
  RayHit<float> hit;
  if (!ray_splat<float>(g.surfels[args->primID], g.ray, hit)) return;
  g.insert({hit.t, args->primID, hit.alpha}, RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, 1), 1, 0));
}

void SurfelTree::build(const SplatLayer& layer, const TraceBuildDesc& desc) {
  max_footprint_ = std::max(0.f, desc.max_footprint);
  surfels_.resize(layer.size());
  parallel_chunks(layer.size(), kPackChunk, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const float *m = layer.at(Attribute::Mean, i), *q = layer.at(Attribute::Rotation, i), *s = layer.at(Attribute::LogScale, i);
      const SurfelGeometry<float> raw{{m[0], m[1], m[2]}, {q[0], q[1], q[2], q[3]}, s[0], s[1]};
      static_cast<RaySurfel<float>&>(surfels_[i]) = ray_surfel(raw, sigmoid(*layer.at(Attribute::Opacity, i)));
    }
  });
  scene_ = Scene(RTC_SCENE_FLAG_ROBUST);
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
  rtcInitIntersectContext(&g);
  g.surfels = surfels_.data();
  g.ray = ray;
  g.min_transmittance = min_transmittance;
  g.hits = &out;
  g.look_at = kBatch;
  RTCRayHit r = ray_hit(ray.origin, ray.direction, std::max(0.f, ray.near), ray.far);
  rtcIntersect1(scene_.get(), &g, &r);
}

}  // namespace vitrine::embree
