#include "core/render/trace/embree/hit_records.h"

#include <algorithm>

#include "core/foundation/base/parallel.h"

namespace vitrine::embree {

void RecordBuckets::count(const HitLists& hits, size_t begin, size_t end, std::span<const uint32_t> place_of) {
  first_chunk_ = begin;
  per_bucket_ = std::max<size_t>(1, chunk_count(place_of.size(), kBuckets));
  const size_t chunks = end - begin;
  offsets_.assign(chunks * kBuckets, 0);
  parallel_for(chunks, 1, [&](size_t c) {
    uint32_t* histogram = offsets_.data() + c * kBuckets;
    for (const TraceHit& hit : hits.chunks[begin + c].hits) ++histogram[bucket_of(place_of[hit.surfel])];
  });
  begin_.resize(kBuckets + 1);
  uint32_t next = 0;
  for (size_t b = 0; b < kBuckets; ++b) {
    begin_[b] = next;
    for (size_t c = 0; c < chunks; ++c) {
      uint32_t& cell = offsets_[c * kBuckets + b];
      const uint32_t size = cell;
      cell = next;
      next += size;
    }
  }
  begin_[kBuckets] = next;
  if (records_.size() < next) records_.resize(next);
}

}  // namespace vitrine::embree
