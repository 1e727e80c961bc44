// Normals from the photos themselves: stereo gives depths where there is texture, planes fitted to them give normals; inside the
// labels of glass and mirrors, which stereo cannot match, the shapes of the objects do.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "stages/normals/capture.h"
#include "stages/normals/normal_map.h"
#include "stages/normals/normals.h"

namespace vitrine {

struct GeometricReport {
  size_t without_partners = 0;  // photos that share no view with others
};

struct GeometricDesc {
  const NormalCapture& capture;
  const GeometricConfig& config;
  uint64_t seed = 0;
  std::span<const uint32_t> views;  // photos that are wanted
  bool with_objects = true;
};

// One map per wanted photo, at most config.max_side large; empty for a photo that no other one can be matched with.
std::vector<NormalMap> geometric_normals(const GeometricDesc& desc, const std::function<void(double)>& progress,
                                         GeometricReport* report = nullptr);

}  // namespace vitrine
