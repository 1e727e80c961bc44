// What photos say about a plane where they have no reliable depth (bare_walls.h): how much the brightness of their pixels differs
// from that of other photos through the plane, as a mean over regions without edges, which belong to one surface or another.
#pragma once

#include "core/observe/stereo/scene_planes.h"

namespace vitrine {

class BareEvidence {
 public:
  // A pixel every `step`, of 48 photos at most.
  BareEvidence(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps, int step);

  size_t size() const { return samples_.size(); }
  // [region] mean brightness that a plane leaves unexplained; as far as it reaches, if its extent is known. Or where all of it is
  // infinitely far away.
  std::vector<float> costs(const ScenePlane& plane) const;
  std::vector<float> far_costs() const;
  // By how much a plane explains the regions better than `least` [region]; a sum over all samples.
  double gain(const ScenePlane& plane, std::span<const float> least) const;
  // How much worse each of `others` explains the regions that `plane` explains better than `least`, where photos can tell; the
  // least of these sums.
  double refuted(std::span<const ScenePlane> others, const ScenePlane& plane, std::span<const float> least) const;
  // Centre, extent and share of the regions that it explains better than `least`.
  void measure(ScenePlane& plane, std::span<const float> least) const;

 private:
  struct Sample {
    uint32_t photo, region;
    float value;
    Vec3d along;  // world, of z-depth 1
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
