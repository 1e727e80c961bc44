#include "core/render/trace/tracer.h"

#include <utility>

#include "core/render/raster/device.h"
#include "core/render/trace/blocks/trace_pass.h"

namespace vitrine {

namespace {

// Constant when the program starts: kernels that are linked in provide themselves before main().
constinit DeviceTraceMaker provided = nullptr;

}  // namespace

DeviceTraceMaker provide_device_tracer(DeviceTraceMaker maker) { return std::exchange(provided, maker); }

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
  switch (backend) {
    case TracerBackend::Reference:
      return make_reference_tracer();
    case TracerBackend::Blocks:
      return make_blocks_tracer();
    case TracerBackend::Embree:
      if (chosen_device() != nullptr && provided != nullptr) return make_blocks_tracer(provided());
      break;
  }
  return make_embree_tracer();
}

}  // namespace vitrine
