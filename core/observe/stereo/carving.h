// Space carving from silhouettes (Laurentini, "The visual hull concept for silhouette-based image understanding", 1994) that
// tolerates a share of contradicting photos. All visual hulls use this rule.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/observe/stereo/silhouette.h"

namespace vitrine {

struct CarvingRule {
  double outlier_share = 0.1;  // of the photos that see a point, those that may show it outside; masks have errors
  size_t fewest_views = 3;     // minimum number of photos that show a point inside
  double seen_share = 0.35;    // minimum share of all photos that show it inside: few photos give no usable visual hull
};
// For outlines found in each photo separately, by GrabCut or a network, which have more errors than masks. With an outlier
// share of 0.1 the lid of a marked pot was lost (IoU .72 instead of .88).
inline constexpr CarvingRule kOutlineVote{.outlier_share = 0.2};

class Carving {
 public:
  // Keeps a reference to the silhouettes. `widened`: inside() will be called with a slack.
  Carving(std::span<const Silhouette> silhouettes, const CarvingRule& rule, bool widened = false);

  // Cameras nearer than `near` do not count. `slack`: dilation of the silhouettes in scene units, so that a coarse grid loses
  // no voxels.
  bool inside(const Vec3d& p, double near = 0, double slack = 0) const;
  // Soft occupancy in [0, 1], with coverage interpolated between pixels: the value that all photos except the outlier share
  // reach. `scratch` is overwritten.
  float occupancy(const Vec3d& p, std::vector<float>& scratch) const;

 private:
  // Number of silhouette pixels in a rectangle of the photo: a summed-area table, [h+1,w+1].
  class Counts {
   public:
    explicit Counts(const ImageF& value);
    bool any_near(int u, int v, int radius) const;

   private:
    int width_, height_;
    std::vector<uint32_t> sums_;
  };
  bool near_inside(size_t silhouette, int u, int v, double slope) const;  // slope: slack over depth
  bool enough(size_t inside) const;

  std::span<const Silhouette> silhouettes_;
  CarvingRule rule_;
  std::vector<Counts> counts_;  // [silhouette] or empty
};

}  // namespace vitrine
