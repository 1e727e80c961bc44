// What one environment's relit pictures scored (relit_error.h).
#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/math/vec.h"

namespace vitrine {

struct RelitScore {
  std::string environment;
  // The object outside the glass; the object with what glass shows of it; all pixels; all pixels.
  std::optional<double> psnr, with_glass_psnr, everywhere_psnr, ssim;
  std::map<std::string, double> region_psnr;  // of all regions but the object
  Vec3d scale{1, 1, 1};                       // of the pictures, where the albedo was not scaled
  size_t views = 0;                           // that show something of the truth
};

}  // namespace vitrine
