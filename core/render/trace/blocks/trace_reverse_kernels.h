// The reverse of tracing, for a batch of rays: a thread for each ray goes through its blended hits back to front and leaves a
// record of each; a stable sort by place puts the records of a surfel next to each other, in the order of the rays; they are
// added up in runs of a fixed length, a thread for each value, then run by run, then batch by batch. So every sum of floats has
// one owner and one order.
#pragma once

#include "core/render/raster/blocks/radix_sort.h"
#include "core/render/raster/blocks/reverse_kernels.h"
#include "core/render/trace/blocks/trace_kernels.h"

namespace vitrine::blocks {

struct alignas(64) HitRecord {
  float moments[sizeof(HitMoments<F32>) / sizeof(F32)];
  float weight, t;
  uint32_t ray;       // of all
  uint32_t positive;  // channels whose colour is not clamped, as bits
};
static_assert(sizeof(HitRecord) == 64);

// Values that are summed over the hits of a surfel, at their places in a row.
struct SurfelSums {
  static constexpr uint32_t kMoments = sizeof(HitMoments<F32>) / sizeof(F32), kWeight = kMoments, kError = kMoments + 1;
  static constexpr uint32_t kTimesT = kMoments + 2;  // the first three moments (u, v, plane) times t
  static constexpr uint32_t kColor = 16, kRow = kColor + 3 * kMaxShCoefficients;
  static_assert(kTimesT + 3 <= kColor && kRow == 64);
};

// Rays of a reverse pass with their upstream gradients.
struct TraceUpstream {
  RayPlanes<const float> gradients;
  const float* error;  // null: zero

  VITRINE_HD static F32 at(const float* plane, uint32_t ray) { return plane == nullptr ? 0.f : plane[ray]; }
  VITRINE_HD static Vec3<F32> vector_at(const float* plane, uint32_t ray) {
    return plane == nullptr ? Vec3<F32>{} : RayArrays::vector(plane, ray);
  }
  VITRINE_HD MarchValues<F32> of(uint32_t ray) const {
    return {vector_at(gradients.color, ray), at(gradients.transmittance, ray), at(gradients.distance, ray),
            at(gradients.first_hit, ray), vector_at(gradients.normal, ray)};
  }
};

template <int kDegree>
struct RayReverseKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  TraceScene scene;
  RayArrays rays;
  TraceUpstream upstream;
  float first_hit_weight;
  uint32_t first, rays_of_batch;
  const uint32_t* counts;   // of the rays of the batch
  const uint32_t* offsets;  // the same, into the hits
  const BlendedHit* hits;
  HitRecord* records;  // of the hits
  SortedPairs unsorted;
  float* bases;                 // [rays, 16], Y of the direction
  float *origins, *directions;  // gradients [rays, 3], or null

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= rays_of_batch) return;
    const uint32_t r = first + i, begin = offsets[i], end = begin + counts[i];
    const TraceRay<F32> ray = rays.ray(r);
    const MarchValues<F32> grad = upstream.of(r);
    F32 transmittance = 1.f, weight = 0.f;
    uint32_t first_hit = end;
    for (uint32_t h = begin; h < end; ++h) {
      const F32 alpha(hits[h].alpha);
      records[h].weight = transmittance.v;  // until the way back replaces it
      weight += alpha * transmittance;
      if (first_hit == end && weight >= F32(first_hit_weight)) first_hit = h;
      transmittance *= F32(1.f) - alpha;
    }
    write_basis(i, ray);
    Vec3<F32> grad_origin, grad_direction;
    F32 basis_weight[sh_coefficient_count(kDegree)];
    for (F32& w : basis_weight) w = 0.f;
    F32 behind = transmittance * grad.transmittance;
    for (uint32_t h = end; h-- > begin;) {
      const BlendedHit hit = hits[h];
      const uint32_t place = scene.place_of[hit.surfel];
      const SurfelShape s = scene.shapes[place];
      const Vec3<F32> color{hit.color[0], hit.color[1], hit.color[2]};
      RayHit<F32> again;
      again.t = hit.t;
      again.alpha = hit.alpha;
      again.free = F32(hit.alpha) < F32(kMaxAlpha);
      place_hit<F32>(s, ray, again);
      const F32 in_front(records[h].weight);
      const bool flipped = dot(s.normal, ray.direction) > F32(0.f);
      const BlendGrad<F32> b =
          blend_hit_vjp(in_front, again.t, again.alpha, color, flipped ? -s.normal : s.normal, h == first_hit, grad, behind);
      const HitGrad<F32> g = ray_splat_vjp<F32>(s, ray, again, b.alpha, b.t, flipped ? -b.normal : b.normal);
      write_record(h, r, again.alpha * in_front, again.t, g.moments, color);
      unsorted.keys[h] = place;
      unsorted.values[h] = h;
      if (origins == nullptr) continue;
      grad_origin += g.origin;
      grad_direction += g.direction;
      if constexpr (kDegree > 0) add_basis_weights(kDegree, SurfelCoefficients(scene, hit.surfel), color, b.color, basis_weight);
    }
    if (origins == nullptr) return;
    grad_direction += sh_basis_vjp(kDegree, ray.direction, basis_weight);
    for (size_t c = 0; c < 3; ++c) {
      origins[size_t{3} * r + c] = grad_origin[c].v;
      directions[size_t{3} * r + c] = grad_direction[c].v;
    }
  }

 private:
  VITRINE_HD void write_basis(uint32_t i, const TraceRay<F32>& ray) const {
    constexpr size_t kCount = sh_coefficient_count(kDegree);
    F32 basis[kCount];
    sh_basis(kDegree, ray.direction, basis);
    for (size_t k = 0; k < kCount; ++k) bases[size_t{kMaxShCoefficients} * i + k] = basis[k].v;
  }
  VITRINE_HD void write_record(uint32_t h, uint32_t ray, F32 weight, F32 t, const HitMoments<F32>& m,
                               const Vec3<F32>& color) const {
    HitRecord record;
    static_assert(sizeof record.moments == sizeof m);
    memcpy(record.moments, &m, sizeof m);
    record.weight = weight.v;
    record.t = t.v;
    record.ray = ray;
    record.positive = 0;
    for (uint32_t c = 0; c < 3; ++c)
      if (color[c] > F32(0.f)) record.positive |= 1u << c;
    records[h] = record;
  }
};

// The records of a batch, sorted by place.
struct SortedRecords {
  const uint64_t* keys;
  const uint32_t* order;
  const HitRecord* records;
  uint32_t count;
};

// begin[place]: its first sorted record; begin[places] = count.
struct PlaceBeginKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const uint64_t* keys;
  uint32_t* begin;
  uint32_t count, places;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t place = at.block * kThreads + at.thread;
    if (place > places) return;
    uint32_t low = 0, high = count;
    while (low < high) {
      const uint32_t middle = low + (high - low) / 2;
      if (keys[middle] < place)
        low = middle + 1;
      else
        high = middle;
    }
    begin[place] = low;
  }
};

// Runs of the records of a place: the first has its first kLength records, and so on.
struct RecordRuns {
  static constexpr uint32_t kLength = 64;
  const uint32_t* begin;    // of each place, into the sorted records
  const uint32_t* offsets;  // of each place, into the runs
  VITRINE_HD static uint32_t count(const uint32_t* begin, uint32_t place) {
    return (begin[place + 1] - begin[place] + kLength - 1) / kLength;
  }
};

struct RunCountKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const uint32_t* begin;
  uint32_t* counts;
  uint32_t places;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t place = at.block * kThreads + at.thread;
    if (place < places) counts[place] = RecordRuns::count(begin, place);
  }
};

// The place of each run.
struct RunPlaceKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  RecordRuns runs;
  uint32_t* place_of_run;
  uint32_t places;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t place = at.block * kThreads + at.thread;
    if (place >= places) return;
    const uint32_t first = runs.offsets[place], end = first + RecordRuns::count(runs.begin, place);
    for (uint32_t run = first; run < end; ++run) place_of_run[run] = place;
  }
};

// SurfelSums::kRow threads for each run, each adds up one value.
struct RunSumKernel {
  static constexpr uint32_t kThreads = 128, kOfBlock = kThreads / SurfelSums::kRow;
  using Shared = NoShared;
  using Thread = NoThread;
  SortedRecords sorted;
  RecordRuns runs;
  const uint32_t* place_of_run;
  TraceUpstream upstream;
  const float* bases;  // RayReverseKernel
  uint32_t first_ray, run_count, coefficients;
  float* sums;  // [runs, kRow]

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t run = at.block * kOfBlock + at.thread / SurfelSums::kRow, value = at.thread % SurfelSums::kRow;
    if (run >= run_count) return;
    const uint32_t place = place_of_run[run];
    const uint32_t begin = runs.begin[place] + (run - runs.offsets[place]) * RecordRuns::kLength;
    const uint32_t left = runs.begin[place + 1] - begin, end = begin + (left < RecordRuns::kLength ? left : RecordRuns::kLength);
    F32 sum = 0.f;
    if (value < SurfelSums::kColor) {
      for (uint32_t i = begin; i < end; ++i) sum += term(sorted.records[sorted.order[i]], value);
    } else if (value < SurfelSums::kColor + 3 * coefficients && upstream.gradients.color != nullptr) {
      for (uint32_t i = begin; i < end; ++i) sum += color_term(sorted.records[sorted.order[i]], value - SurfelSums::kColor);
    }
    sums[size_t{SurfelSums::kRow} * run + value] = sum.v;
  }

 private:
  VITRINE_HD F32 term(const HitRecord& record, uint32_t value) const {
    if (value < SurfelSums::kMoments) return record.moments[value];
    if (value == SurfelSums::kWeight) return record.weight;
    if (value == SurfelSums::kError) return F32(record.weight) * TraceUpstream::at(upstream.error, record.ray);
    if (value < SurfelSums::kTimesT + 3) return F32(record.t) * F32(record.moments[value - SurfelSums::kTimesT]);
    return 0.f;
  }
  VITRINE_HD F32 color_term(const HitRecord& record, uint32_t value) const {
    const uint32_t coefficient = value / 3, channel = value % 3;
    if ((record.positive >> channel & 1) == 0) return 0.f;
    const F32 basis(bases[size_t{kMaxShCoefficients} * (record.ray - first_ray) + coefficient]);
    return basis * (F32(record.weight) * F32(upstream.gradients.color[size_t{3} * record.ray + channel]));
  }
};

// Adds the runs of a place to the sums of the batches before.
struct PlaceSumKernel {
  static constexpr uint32_t kThreads = 128, kOfBlock = kThreads / SurfelSums::kRow;
  using Shared = NoShared;
  using Thread = NoThread;
  RecordRuns runs;
  const float* run_sums;
  float* sums;  // [places, kRow]
  uint32_t places;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t place = at.block * kOfBlock + at.thread / SurfelSums::kRow, value = at.thread % SurfelSums::kRow;
    if (place >= places) return;
    const uint32_t first = runs.offsets[place], end = first + RecordRuns::count(runs.begin, place);
    if (first == end) return;
    float& to = sums[size_t{SurfelSums::kRow} * place + value];
    F32 sum(to);
    for (uint32_t run = first; run < end; ++run) sum += F32(run_sums[size_t{SurfelSums::kRow} * run + value]);
    to = sum.v;
  }
};

// Gradients of the raw values of every surfel; zero where no ray met it.
struct TracedSurfelKernel {
  static constexpr uint32_t kThreads = 64;
  using Shared = NoShared;
  using Thread = NoThread;
  TraceScene scene;
  SurfelArrays surfels;  // mean, rotation, log_scale
  const float* sums;     // [places, kRow]
  SurfelGradients out;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= scene.surfels) return;
    const uint32_t place = scene.place_of[i];
    RaySurfelGrad<F32> g{};
    F32 screen = 0.f;
    const float* const row = place == SurfelBvh::kInvisible ? nullptr : sums + size_t{SurfelSums::kRow} * place;
    if (row != nullptr && row[SurfelSums::kWeight] > 0) {
      HitMoments<F32> m;
      memcpy(static_cast<void*>(&m), row, sizeof m);
      const SurfelShape s = scene.shapes[place];
      g = ray_surfel_vjp(geometry_of(surfels, i), s.opacity, m);
      const float* const times_t = row + SurfelSums::kTimesT;
      screen = F32(0.5f) * length(F32(times_t[2]) * s.normal - F32(times_t[0]) * s.axis_u - F32(times_t[1]) * s.axis_v);
    }
    for (size_t c = 0; c < 3; ++c) out.mean[size_t{3} * i + c] = g.geometry.mean[c].v;
    const F32 q[] = {g.geometry.rotation.w, g.geometry.rotation.x, g.geometry.rotation.y, g.geometry.rotation.z};
    for (size_t c = 0; c < 4; ++c) out.rotation[size_t{4} * i + c] = q[c].v;
    out.log_scale[size_t{2} * i] = g.geometry.log_su.v;
    out.log_scale[size_t{2} * i + 1] = g.geometry.log_sv.v;
    out.opacity[i] = g.raw_opacity.v;
    out.screen_gradient[i] = screen.v;
    out.weight[i] = row == nullptr ? 0 : row[SurfelSums::kWeight];
    out.error[i] = row == nullptr ? 0 : row[SurfelSums::kError];
    for (size_t k = 0; k < 3 + scene.sh_rest_width; ++k) {
      float& to = k < 3 ? out.sh_dc[size_t{3} * i + k] : out.sh_rest[size_t{scene.sh_rest_width} * i + k - 3];
      to = row == nullptr ? 0 : row[SurfelSums::kColor + k];
    }
  }
};

}  // namespace vitrine::blocks
