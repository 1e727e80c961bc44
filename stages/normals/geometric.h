// Normals from the photos themselves: stereo gives depths where there is texture, planes fitted to them give normals; inside the
// masks of glass and mirrors, which stereo cannot match, the known shapes and the visual hull of the masks do.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/camera/mask_files.h"
#include "stages/normals/capture.h"
#include "stages/normals/normal_map.h"
#include "stages/normals/normals.h"

namespace vitrine {

struct HullReport {
  MaskClass of;
  size_t masks = 0;  // photos with one
  bool found = false;
  bool shaped = false;  // known shapes give the normals where they are
  size_t faces = 0;     // flat ones of the hull that its normals come from
  double one_sidedness = 0;
};

struct GeometricReport {
  size_t without_partners = 0;    // photos that share no view with others
  std::vector<HullReport> hulls;  // of the classes that are asked for and have masks
};

struct GeometricDesc {
  const NormalCapture& capture;
  const GeometricConfig& config;
  uint64_t seed = 0;
  std::span<const uint32_t> views;  // photos that are wanted
  bool with_hull = true;
};

// One map per wanted photo, at most config.max_side large; empty for a photo that no other one can be matched with.
std::vector<NormalMap> geometric_normals(const GeometricDesc& desc, const std::function<void(double)>& progress,
                                         GeometricReport* report = nullptr);

}  // namespace vitrine
