// Rays through a volume: straight lines of unit direction, infinite to both sides. Sources and detectors of X-ray pictures lie
// outside the volume, so that a line and a segment have the same integral. Rays of one picture are cut into tiles of 8 x 8,
// each bounded by a beam.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine {

struct VolumeRay {
  Vec3d origin, direction;  // direction: unit length
};

// All lines of a tile within `spread` |t| + `radius` of the axis, t = distance of a point of the line from where it passes
// the pivot.
struct RayBeam {
  VolumeRay axis;
  double radius = 0, spread = 0;
};

class RayTiles {
 public:
  static constexpr int kSide = 8, kRays = kSide * kSide;
  static constexpr int kGroup = 4;  // tiles along the side of a group

  struct Tile {
    int x = 0, y = 0;  // first pixel
    RayBeam beam;
    // [axis][ray]; rays beyond the picture repeat its border. Origins are relative to the pivot.
    alignas(64) std::array<std::array<float, kRays>, 3> origin, direction;
  };
  struct Group {
    RayBeam beam;
    std::vector<uint32_t> tiles;
  };

  // `rays` [h, width]; neighbours in the picture should be neighbours in space (else all is right but slow). `pivot`: the middle
  // of the volume. Origins move along their line to the point nearest to it, which keeps float accurate far from the source.
  RayTiles(std::span<const VolumeRay> rays, int width, const Vec3d& pivot);

  int width() const { return width_; }
  int height() const { return height_; }
  const Vec3d& pivot() const { return pivot_; }
  std::span<const Tile> tiles() const { return tiles_; }
  std::span<const Group> groups() const { return groups_; }

 private:
  int width_, height_;
  Vec3d pivot_;
  std::vector<Tile> tiles_;
  std::vector<Group> groups_;
};

}  // namespace vitrine
