// PatchMatch stereo of all photos at a reduced size: depth maps and the large planes of the scene.
#pragma once

#include <span>
#include <vector>

#include "core/observe/stereo/background.h"
#include "core/observe/stereo/edge_field.h"
#include "core/observe/stereo/patch_match.h"
#include "core/scene/camera/view_set.h"

namespace vitrine {

class SmallStereo {
 public:
  // `photos`: of all views, with gains removed; views without a picture are skipped. Runs PatchMatch on all the others, which
  // dominates the run time of the callers.
  SmallStereo(std::vector<EdgePhoto> photos, const ViewSet& set);

  // Whether stereo found too little to predict a background.
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
