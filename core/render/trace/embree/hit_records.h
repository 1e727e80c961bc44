// Scatter buffer of the reverse pass: one record per hit, bucketed by surfel. Rays write records into buckets of neighbouring
// surfels, at offsets counted beforehand; buckets are then summed one by one, each in the order of the rays. No two threads add
// to the same number, and the sums do not depend on the number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "core/render/trace/kernels/ray_splat.h"
#include "core/render/trace/tracer.h"

namespace vitrine::embree {

struct alignas(64) HitRecord {
  uint32_t place;  // of the surfel in the tree's arrays
  uint32_t ray;    // of the batch; the top three bits flag the positive colour channels
  float weight, t;
  HitMoments<float> moments;
};
inline constexpr uint32_t kRayBits = 29;

class RecordBuckets {
 public:
  static constexpr size_t kBuckets = 256;

  // Reserves space for the hits of chunks [begin, end) of `hits`. `place_of` is indexed by surfel.
  void count(const HitLists& hits, size_t begin, size_t end, std::span<const uint32_t> place_of);
  // Write positions of a chunk, one cursor per bucket; advance them after each record.
  uint32_t* cursors(size_t chunk) { return offsets_.data() + (chunk - first_chunk_) * kBuckets; }
  HitRecord& at(uint32_t cursor) { return records_[cursor]; }
  size_t bucket_of(uint32_t place) const { return place / per_bucket_; }

  size_t places_per_bucket() const { return per_bucket_; }
  // Valid after all records were written.
  std::span<const HitRecord> bucket(size_t b) const { return std::span(records_).subspan(begin_[b], begin_[b + 1] - begin_[b]); }

 private:
  size_t first_chunk_ = 0, per_bucket_ = 1;
  std::vector<uint32_t> offsets_;  // [chunk][bucket]
  std::vector<uint32_t> begin_;    // [kBuckets + 1]
  std::vector<HitRecord> records_;
};

}  // namespace vitrine::embree
