// The photos at the size that masks are looked for in, with stereo of all of them: what stands where, and the large planes.
#pragma once

#include "core/stereo/background.h"
#include "stages/masks/small_photo.h"

namespace vitrine {

class SmallStereo {
 public:
  // PatchMatch of all photos: most of the time of what uses it.
  SmallStereo(std::span<const SmallPhoto> photos, const MaskCapture& capture);

  // Whether stereo found so little that no background can be predicted.
  bool blind() const;
  std::span<const View> views() const { return views_; }
  Surroundings surroundings() const { return {.photos = photos_, .maps = maps_, .planes = planes_}; }

 private:
  std::vector<View> views_;
  std::vector<EdgePhoto> photos_;
  std::vector<DepthMap> maps_;
  std::vector<ScenePlane> planes_;
};

}  // namespace vitrine
