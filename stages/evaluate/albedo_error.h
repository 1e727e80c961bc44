// Albedo error against the ground truth (the protocol of Jin et al. 2023, "TensoIR"; algorithms 8.2). Photos determine albedo up
// to one factor per channel, so our albedo is multiplied by
//   k_c = median of truth_c / ours_c     one number per channel for the whole scene ("global median per channel")
// over the counted object pixels, in linear values; then clipped to [0,1], raised to 1/2.2 and compared. Metal has no diffuse
// albedo and is excluded: pixels with a channel of 0 in the truth, and pixels that mix with them when both pictures are reduced
// to the coarser size.
#pragma once

#include <optional>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "stages/evaluate/truth.h"

namespace vitrine {

struct AlbedoPicture {
  const Intrinsics& intrinsics;
  const ImageF& albedo;    // linear; 0 = no surface
  const ImageF& radiance;  // of the diffuse layer at that size: the albedo without decomposition
  const ImageF* object;    // masks of 0 and 1 at that size; nullptr: everywhere
  const ImageF* glass;     // nullptr: nowhere
};

struct AlbedoScores {
  Vec3d scale{1, 1, 1};                 // k
  std::optional<double> psnr;           // object, outside the glass
  std::optional<double> through_glass;  // object behind glass
  std::optional<double> everywhere;     // all pixels with a truth
  std::optional<double> undecomposed;   // radiance in place of albedo, with its own scale; object, outside the glass
  size_t views = 0;
};

class AlbedoError {
 public:
  void add(const AlbedoPicture& ours, const TruthPicture& truth);
  AlbedoScores scores() const;

 private:
  enum Region : unsigned char { kObject, kThroughGlass, kRest };
  struct Pixel {
    Vec3f ours, radiance, truth;
    Region region;
  };
  using Guess = Vec3f Pixel::*;  // the compared value
  Vec3d scale_of(Guess guess) const;
  std::optional<double> psnr(Guess guess, const Vec3d& scale, const std::vector<bool>& regions) const;
  std::vector<std::vector<Pixel>> views_;
};

}  // namespace vitrine
