// Photometric cost of a plane in textureless pixels without reliable depth (scene_planes.h): brightness difference to other
// photos warped through the plane, averaged over regions without edges, each of which shows one surface.
#pragma once

#include "core/observe/stereo/scene_planes.h"

namespace vitrine {

class BareEvidence {
 public:
  // Samples every `step`-th pixel, of at most 48 photos.
  BareEvidence(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps, int step);

  size_t size() const { return samples_.size(); }
  // [region] mean brightness residual of a plane, within its reach() if its extent is known; far_costs(): of a background at
  // infinity.
  std::vector<float> costs(const ScenePlane& plane) const;
  std::vector<float> far_costs() const;
  // Reduction of the residual below `least` [region] by the plane; sum over all samples.
  double gain(const ScenePlane& plane, std::span<const float> least) const;
  // Smallest, over `others`, increase of the residual in the regions that `plane` explains better than `least`, where photos
  // can see it.
  double refuted(std::span<const ScenePlane> others, const ScenePlane& plane, std::span<const float> least) const;
  // Sets centre, extent and share of the plane from the regions that it explains better than `least`.
  void measure(ScenePlane& plane, std::span<const float> least) const;

 private:
  struct Sample {
    uint32_t photo, region;
    float value;
    Vec3d along;  // world direction of the pixel's ray, scaled to z-depth 1
  };

  void add_samples(uint32_t photo, int step);
  std::vector<uint32_t> regions_of(uint32_t photo);
  double depth(const ScenePlane& plane, const Sample& s) const;
  float cost(const ScenePlane& plane, const Sample& s) const;
  float cost_at(const Sample& s, const Vec3d& point, bool far) const;
  std::vector<float> by_region(const std::vector<float>& values) const;

  std::span<const StereoPhoto> photos_;
  std::span<const DepthMap> maps_;
  std::vector<Vec3d> centres_;
  std::vector<ImageF> blurred_;
  std::vector<uint32_t> used_;  // photos with a map
  uint32_t regions_ = 0;
  std::vector<Sample> samples_;
};

}  // namespace vitrine
