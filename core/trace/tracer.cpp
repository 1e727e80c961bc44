#include "core/trace/tracer.h"

#include <cmath>
#include <numbers>

#include "core/trace/embree/embree_tracer.h"
#include "core/trace/reference/reference_tracer.h"

namespace vitrine {

namespace {

// The slopes of a GGX surface deviate by about alpha/sqrt(2) per axis, reflection doubles the angle; kLobeWidth of that deviation
// is the footprint, since the tails are not what one sees.
constexpr float kLobeWidth = 0.5f;
constexpr float kSpread = kLobeWidth * std::numbers::sqrt2_v<float>;

}  // namespace

float lobe_spread(float roughness) { return kSpread * roughness * roughness; }
float lobe_spread_slope(float roughness) { return 2.f * kSpread * roughness; }

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
