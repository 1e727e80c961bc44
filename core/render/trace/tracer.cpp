#include "core/render/trace/tracer.h"

namespace vitrine {

std::unique_ptr<Tracer> make_embree_tracer();
std::unique_ptr<Tracer> make_reference_tracer();

void RayValues::resize(size_t rays) {
  color.resize(rays);
  transmittance.resize(rays);
  distance.resize(rays);
  first_hit.resize(rays);
  normal.resize(rays);
}

std::span<const TraceHit> HitLists::of(size_t ray) const {
  const Chunk& chunk = chunks[place_of[ray] / kChunk];
  const size_t at = place_of[ray] % kChunk, begin = at == 0 ? 0 : chunk.end[at - 1];
  return std::span(chunk.hits).subspan(begin, chunk.end[at] - begin);
}

size_t HitLists::size() const {
  size_t n = 0;
  for (const Chunk& chunk : chunks) n += chunk.hits.size();
  return n;
}

std::unique_ptr<Tracer> make_tracer(TracerBackend backend) {
  return backend == TracerBackend::Reference ? make_reference_tracer() : make_embree_tracer();
}

}  // namespace vitrine
