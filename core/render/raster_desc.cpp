#include "core/render/raster_desc.h"

#include <algorithm>

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
  for (auto& plane : planes) std::fill(plane.begin(), plane.end(), 0.f);
}

}  // namespace vitrine
