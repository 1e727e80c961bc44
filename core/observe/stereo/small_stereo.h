// Small photos with stereo of all of them: what stands where, and the large planes.
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/view_set.h"
#include "core/observe/stereo/background.h"
#include "core/observe/stereo/edge_field.h"

namespace vitrine {

class SmallStereo {
 public:
  // `photos`: of all views, without their gains; those without a picture take no part. PatchMatch of all the others: most of the
  // time of what uses it.
  SmallStereo(std::vector<EdgePhoto> photos, const ViewSet& set);

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
