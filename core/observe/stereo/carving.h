// Carving: the points of space that silhouettes agree to be inside an object (Laurentini, "The visual hull concept for
// silhouette-based image understanding", 1994), with a share of the photos that may contradict. One rule for all hulls.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/observe/stereo/silhouette.h"

namespace vitrine {

struct CarvingRule {
  double dissent = 0.1;      // share of the photos, of those that show a point, that may show it outside: masks have errors
  size_t fewest_views = 3;   // photos that must show a point inside, at least
  double seen_share = 0.35;  // of all photos that must show it inside: a hull of few photos is no hull
};
// Of outlines that were looked for in each photo by itself, by GrabCut or a network: they err more than masks do, and vote. With
// a tenth the outlines of a marked pot cut its lid off (overlap .72 instead of .88).
inline constexpr CarvingRule kOutlineVote{.dissent = 0.2};

class Carving {
 public:
  // Refers to the silhouettes. `widened`: inside() is called with a slack.
  Carving(std::span<const Silhouette> silhouettes, const CarvingRule& rule, bool widened = false);

  // Cameras nearer than `near` do not show the point. `slack`: scene units that silhouettes are widened by, so that a coarse grid
  // loses nothing.
  bool inside(const Vec3d& p, double near = 0, double slack = 0) const;
  // How far inside, 0 to 1, with coverage interpolated between pixels: the value that all photos but the dissenting share reach.
  // `scratch` is overwritten.
  float occupancy(const Vec3d& p, std::vector<float>& scratch) const;

 private:
  // Pixels inside a silhouette, in rectangles of its picture: a summed-area table, [h+1,w+1].
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
