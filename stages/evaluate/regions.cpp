#include "stages/evaluate/regions.h"

#include <algorithm>

#include "core/image/metrics.h"

namespace vitrine {

RegionMasks region_masks(const Truth& truth, size_t view, const Intrinsics& intrinsics) {
  RegionMasks masks;
  for (MaskClass c : kMaskClasses)
    if (auto mask = truth.mask(view, c, intrinsics)) masks.emplace(name(c), std::move(*mask));
  const auto transparent = masks.find("transparent"), specular = masks.find("specular");
  if (transparent == masks.end() && specular == masks.end()) return masks;
  ImageF rest(intrinsics.width, intrinsics.height, 1, 1.f);
  for (const auto& it : {transparent, specular})
    if (it != masks.end())
      for (size_t i = 0; i < rest.data().size(); ++i)
        if (it->second.data()[i] > 0) rest.data()[i] = 0;
  masks.emplace("rest", std::move(rest));
  return masks;
}

std::map<std::string, double> region_psnr(const RegionMasks& masks, const ImageF& srgb, const ImageF& photo, int min_pixels) {
  std::map<std::string, double> result;
  for (const auto& [region, mask] : masks)
    if (std::count(mask.data().begin(), mask.data().end(), 1.f) >= min_pixels) result[region] = psnr(srgb, photo, &mask);
  return result;
}

}  // namespace vitrine
