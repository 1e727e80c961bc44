#include "core/render/raster/raster_desc.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/render/raster/blocks/block_pass.h"
#include "core/render/raster/device.h"
#include "core/render/raster/renderer.h"

namespace vitrine {

bool produces(const RasterDesc& desc, Aov aov) {
  if (aov == Aov::Distortion) return desc.distortion;
  if (!row(aov).feature) return true;
  size_t end = 0;
  for (const AovRow& r : kAovs) {
    if (r.feature) end += static_cast<size_t>(r.width);
    if (r.id == aov) break;
  }
  return end <= feature_count(desc.features);
}

void check_wanted(const RasterDesc& desc) {
  const size_t pixels = desc.intrinsics.pixel_count();
  VITRINE_CHECK(desc.wanted.empty() || desc.wanted.size() == pixels, "{} wanted pixels of {}", desc.wanted.size(), pixels);
}

void RasterImages::resize(const RasterDesc& desc) {
  width = desc.intrinsics.width;
  height = desc.intrinsics.height;
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  for (const AovRow& r : kAovs) {
    auto& plane = planes[static_cast<size_t>(r.id)];
    plane.resize(produces(desc, r.id) ? static_cast<size_t>(r.width) * pixels : 0);
  }
}

void RasterImages::reset(const RasterDesc& desc) {
  resize(desc);
  constexpr size_t kChunk = 1 << 15;
  for (auto& plane : planes) {
    parallel_chunks(plane.size(), kChunk,
                    [&](size_t, size_t begin, size_t end) { std::fill(plane.data() + begin, plane.data() + end, 0.f); });
  }
}

std::unique_ptr<Renderer> make_cpu_renderer(Simd simd);
std::unique_ptr<Renderer> make_reference_renderer();

std::unique_ptr<Renderer> make_renderer(Backend backend, Simd simd) {
  switch (backend) {
    case Backend::Reference:
      return make_reference_renderer();
    case Backend::Blocks:
      return make_blocks_renderer();
    case Backend::Cpu:
      if (simd == Simd::Best && chosen_device() != nullptr) return make_blocks_renderer(chosen_device()());
      break;
  }
  return make_cpu_renderer(simd);
}

}  // namespace vitrine
