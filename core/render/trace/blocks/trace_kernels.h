// Tracing, a thread for each ray: the nearest hits that are not blended yet are gathered from the tree into a sorted list, then
// blended front to back; where the list was full and light is left, the traversal starts again behind the last of them. The order
// is exactly that of (t, surfel index), however many hits have one t, and no ray needs more memory than its registers and the
// stack of a traversal.
#pragma once

#include "core/render/raster/blocks/block_kernel.h"
#include "core/render/trace/blocks/surfel_bvh.h"
#include "core/render/trace/kernels/march.h"

namespace vitrine::blocks {

// All pointers of the structs below are into the executor's memory.
struct TraceScene {
  const BvhNode* nodes;
  const SurfelShape* shapes;             // by place
  const uint32_t *surfel_at, *place_of;  // SurfelBvh
  const float *sh_dc, *sh_rest;          // by surfel
  float low[3], high[3];                 // bounds of everything
  uint32_t node_count, surfels, sh_rest_width;
};

struct MarchOptions {  // of TraceDesc; the degree is at most the layer's
  int sh_degree;
  float min_transmittance, first_hit_weight;
};

struct RayArrays {
  const float *origins, *directions;  // [n, 3]
  const float *near, *far;            // [n]; null: 0, infinity
  uint32_t count;

  VITRINE_HD static Vec3<F32> vector(const float* of, uint32_t i) {
    const float* v = of + size_t{3} * i;
    return {v[0], v[1], v[2]};
  }
  VITRINE_HD TraceRay<F32> ray(uint32_t i) const {
    return {vector(origins, i), vector(directions, i), near == nullptr ? 0.f : near[i],
            far == nullptr ? float_from_bits(0x7f800000u) : far[i]};
  }
};

// Of each ray; as gradients, null: zero.
template <class Float>
struct RayPlanes {
  Float *color, *transmittance, *distance, *first_hit, *normal;  // color, normal: [n, 3]
};

// A blended hit, as TraceHit of tracer.h.
struct BlendedHit {
  uint32_t surfel;
  float t, alpha;
  float color[3];
};

// Spherical harmonics of a surfel as ray_color() reads them.
struct SurfelCoefficients {
  const float *dc, *rest;
  VITRINE_HD SurfelCoefficients(const TraceScene& scene, uint32_t surfel)
      : dc(scene.sh_dc + size_t{3} * surfel), rest(scene.sh_rest + size_t{scene.sh_rest_width} * surfel) {}
  VITRINE_HD F32 operator[](size_t i) const { return i < 3 ? dc[i] : rest[i - 3]; }
};

VITRINE_HD inline Vec3<F32> facing_normal(const SurfelShape& s, const Vec3<F32>& direction) {
  return dot(s.normal, direction) > F32(0.f) ? -s.normal : s.normal;
}

// A hit as one number: t, whose bits are made to rise with its value, before the index of the surfel.
struct HitKey {
  static constexpr uint64_t kNone = ~uint64_t{0};
  VITRINE_HD static uint64_t of(F32 t, uint32_t surfel) {
    const uint32_t bits = float_bits((t + F32(0.f)).v);  // -0 becomes 0
    return uint64_t{(bits & kSign) != 0 ? ~bits : bits | kSign} << 32 | surfel;
  }
  VITRINE_HD static F32 t(uint64_t key) {
    const uint32_t high = static_cast<uint32_t>(key >> 32);
    return float_from_bits((high & kSign) != 0 ? high & ~kSign : ~high);
  }
  VITRINE_HD static uint32_t surfel(uint64_t key) { return static_cast<uint32_t>(key); }

 private:
  static constexpr uint32_t kSign = 1u << 31;
};

// The part of a ray in a box. Boxes are taken larger by a share of the largest coordinate in play, so that the point of a hit is
// inside for every t that rounding gives.
struct RaySlabs {
  F32 enter_from[3], leave_from[3], inverse[3];
  uint32_t negative[3];

  VITRINE_HD RaySlabs(const TraceRay<F32>& ray, const TraceScene& scene) {
    F32 reach = 0.f;
    for (size_t c = 0; c < 3; ++c) {
      const F32 o = ray.origin[c];
      reach = max(reach, absolute(o) + max(absolute(F32(scene.low[c]) - o), absolute(F32(scene.high[c]) - o)));
    }
    const F32 pad = F32(4e-6f) * reach;
    for (size_t c = 0; c < 3; ++c) {
      const F32 d = ray.direction[c];
      negative[c] = d < F32(0.f) ? 1 : 0;
      inverse[c] = F32(1.f) / (absolute(d) < F32(1e-20f) ? F32(negative[c] != 0 ? -1e-20f : 1e-20f) : d);
      const F32 shift = negative[c] != 0 ? -pad : pad;
      enter_from[c] = ray.origin[c] + shift;
      leave_from[c] = ray.origin[c] - shift;
    }
  }
};

// The degree of the colours is a constant of each copy: the basis then stays in registers.
template <int kDegree>
struct TraceKernel {
  static constexpr uint32_t kThreads = 128;
  static constexpr int kNearest =
      16;  // a fifth to two fifths fewer boxes and surfels to test than with 8, and still 128 registers
  using Shared = NoShared;
  using Thread = NoThread;

  TraceScene scene;
  RayArrays rays;
  MarchOptions options;
  uint32_t first;  // the first ray of this launch
  uint32_t rays_of_launch;
  RayPlanes<float> out;     // null: not wanted
  uint32_t* counts;         // of each ray: blended hits; null: not wanted
  const uint32_t* offsets;  // of each ray of the launch, into `hits`
  BlendedHit* hits;         // null: not wanted

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= rays_of_launch) return;
    const TraceRay<F32> ray = rays.ray(first + i);
    March<F32> march;
    const uint32_t blended = trace(ray, march, hits == nullptr ? nullptr : hits + offsets[i]);
    if (counts != nullptr) counts[first + i] = blended;
    if (out.color != nullptr) write(first + i, march.sum);
  }

 private:
  struct Nearest {  // sorted
    uint64_t keys[kNearest];
    VITRINE_HD bool is_full() const { return keys[kNearest - 1] != HitKey::kNone; }
    VITRINE_HD void insert(uint64_t key) {
#ifdef __CUDA_ARCH__
#pragma unroll
#endif
      for (uint64_t& k : keys) {
        const uint64_t lower = key < k ? key : k;
        key = key < k ? k : key;
        k = lower;
      }
    }
    VITRINE_HD uint64_t take() {
      const uint64_t nearest = keys[0];
#ifdef __CUDA_ARCH__
#pragma unroll
#endif
      for (int k = 0; k + 1 < kNearest; ++k) keys[k] = keys[k + 1];
      keys[kNearest - 1] = HitKey::kNone;
      return nearest;
    }
  };

  // Returns the number of blended hits.
  VITRINE_HD uint32_t trace(const TraceRay<F32>& ray, March<F32>& march, BlendedHit* list) const {
    uint32_t blended = 0;
    if (scene.node_count == 0) return blended;
    const F32 least(options.min_transmittance);
    const RaySlabs slabs(ray, scene);
    Nearest nearest;
    uint64_t behind = 0;
    for (bool more = true; more && march.sum.transmittance >= least;) {
      gather(ray, slabs, behind, nearest);
      more = nearest.is_full();
      F32 basis[sh_coefficient_count(kDegree)];
      sh_basis(kDegree, ray.direction, basis);
      while (nearest.keys[0] != HitKey::kNone && march.sum.transmittance >= least) {
        behind = nearest.take();
        const uint32_t surfel = HitKey::surfel(behind);
        const SurfelShape s = scene.shapes[scene.place_of[surfel]];
        const RayHit<F32> hit = ray_splat<F32>(s, ray);
        const Vec3<F32> color = ray_color(kDegree, basis, SurfelCoefficients(scene, surfel));
        march.blend(hit.t, hit.alpha, color, facing_normal(s, ray.direction), F32(options.first_hit_weight));
        if (list != nullptr) list[blended] = {surfel, hit.t.v, hit.alpha.v, {color.x.v, color.y.v, color.z.v}};
        ++blended;
      }
    }
    return blended;
  }

  // The nearest hits with keys above `behind`.
  VITRINE_HD void gather(const TraceRay<F32>& ray, const RaySlabs& slabs, uint64_t behind, Nearest& nearest) const {
    for (uint64_t& key : nearest.keys) key = HitKey::kNone;
    F32 near = ray.near, far = ray.far;
    if (behind != 0) near = max(near, HitKey::t(behind));
    uint32_t stack[BvhNode::kStack];
    float entries[BvhNode::kStack];  // t where the ray enters
    uint32_t size = 1;
    stack[0] = 0;
    entries[0] = near.v;
    while (size > 0) {
      const uint32_t child = stack[--size];
      if (F32(entries[size]) > far) continue;
      if (!BvhNode::is_leaf(child)) {
        size = push_children(scene.nodes[child], slabs, near, far, stack, entries, size);
        continue;
      }
      const uint32_t begin = BvhNode::leaf_first(child), end = begin + BvhNode::leaf_size(child);
      for (uint32_t place = begin; place < end; ++place) {
        const SurfelShape s = scene.shapes[place];
        const RayHit<F32> hit = ray_splat<F32>(s, ray);
        if (!hit.counts) continue;
        const uint64_t key = HitKey::of(hit.t, scene.surfel_at[place]);
        if (key <= behind) continue;
        nearest.insert(key);
        if (nearest.is_full()) far = min(ray.far, HitKey::t(nearest.keys[kNearest - 1]));
      }
    }
  }

  struct Entered {
    F32 t;
    uint32_t child;
  };
  VITRINE_HD static void order(Entered& a, Entered& b) {  // farther first
    const Entered x = a, y = b;
    const bool swap = x.t < y.t;
    a = swap ? y : x;
    b = swap ? x : y;
  }
  // Those that the ray meets between near and far; the nearest is on top. Returns the new size of the stack.
  VITRINE_HD static uint32_t push_children(const BvhNode& node, const RaySlabs& slabs, F32 near, F32 far, uint32_t* stack,
                                           float* entries, uint32_t size) {
    F32 enter[BvhNode::kChildren], leave[BvhNode::kChildren];
    for (uint32_t c = 0; c < BvhNode::kChildren; ++c) {
      enter[c] = near;
      leave[c] = far;
    }
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const uint32_t negative = slabs.negative[axis];
      const FourFloats front = node.planes[negative][axis], back = node.planes[1 - negative][axis];
      for (uint32_t c = 0; c < BvhNode::kChildren; ++c) {
        enter[c] = max(enter[c], (F32(front.v[c]) - slabs.enter_from[axis]) * slabs.inverse[axis]);
        leave[c] = min(leave[c], (F32(back.v[c]) - slabs.leave_from[axis]) * slabs.inverse[axis]);
      }
    }
    Entered met[BvhNode::kChildren];
    for (uint32_t c = 0; c < BvhNode::kChildren; ++c)
      met[c] = enter[c] <= leave[c] ? Entered{enter[c], node.children[c]} : Entered{3e38f, kMissed};
    order(met[0], met[1]);
    order(met[2], met[3]);
    order(met[0], met[2]);
    order(met[1], met[3]);
    order(met[1], met[2]);
    for (uint32_t c = 0; c < BvhNode::kChildren; ++c) {
      if (met[c].child == kMissed) continue;
      stack[size] = met[c].child;
      entries[size++] = met[c].t.v;
    }
    return size;
  }
  static constexpr uint32_t kMissed = 0;  // the root is no child

  VITRINE_HD void write(uint32_t ray, const MarchValues<F32>& v) const {
    for (size_t c = 0; c < 3; ++c) {
      out.color[size_t{3} * ray + c] = v.color[c].v;
      out.normal[size_t{3} * ray + c] = v.normal[c].v;
    }
    out.transmittance[ray] = v.transmittance.v;
    out.distance[ray] = v.distance.v;
    out.first_hit[ray] = v.first_hit.v;
  }
};

}  // namespace vitrine::blocks
