// Per-pixel evidence whether the surroundings are static relative to the object or move (turntable, plain backdrop).
//   static   dense stereo explains the pixel: other photos confirm a surface there
//   moving   the pixel has texture, two neighbouring photos see its position, and no surface explains it; or it looks the same at
//            the same image position in photos from other directions: a room in front of a camera on a tripod
// Textureless pixels give no individual evidence. A plain backdrop is detected as a whole: most of the picture is constant at the
// same image position.
#pragma once

#include "core/learn/trainer/targets.h"
#include "stages/optimize/initialise.h"

namespace vitrine {

enum class Evidence : unsigned char { None, Still, Moves, Object };

// Evidence of one training photo, at the size of its depth map, without isolated outliers. Empty if the photo has no depth map.
struct PhotoEvidence {
  int width = 0, height = 0;
  std::vector<Evidence> pixels;  // Object: inside its mask or within a patch of its silhouette
  std::vector<uint8_t> plain;    // 1: textureless, and constant at the same image position
  std::vector<uint8_t> fine;     // 1: texture within a pixel; otherwise neighbouring texture decides how the patch matches
};

// Counts of the pixels around the object, over all training photos.
struct EvidenceCounts {
  size_t all = 0;
  size_t still = 0;        // explained by a surface
  size_t unexplained = 0;  // textured, visible in two neighbouring photos, and not explained
  size_t in_place = 0;     // textured, and constant at the same image position
  size_t plain = 0;        // textureless, and constant at the same image position in nearly all photos

  double part(size_t n) const;  // fraction of all pixels with evidence
  // True if the surroundings move at least in part.
  bool moving() const;
  bool moving_by_texture() const;  // true if texture, and not only a plain backdrop, indicates motion
};

struct MovingEvidence {
  std::vector<PhotoEvidence> photos;  // [capture.photos]
  EvidenceCounts counts;
};
MovingEvidence moving_evidence(const Capture& capture, const Targets& targets, const DenseDepth& dense);

// Masks of the surfaces that are static relative to the object. They cover pixels that dense stereo explains consistently in
// several photos, and the flat surface between them (a white plate with texture only on its rim and a ruler).

struct StillPoint {
  Vec3d position, normal;
  double radius;  // of the surface patch that the point represents
};

// Points that the photos consistently show as static relative to the object.
std::vector<StillPoint> still_points(const Capture& capture, const DenseDepth& dense, const MovingEvidence& evidence);

// Mask of the static surface in one photo, at the size of `view`, [h*w]: 255 certain, 128 at the boundary, 0 outside. `object`:
// object mask at that size, or empty. Moving pixels of the photo are excluded.
std::vector<uint8_t> shown(const View& view, std::span<const StillPoint> points, std::span<const uint8_t> object,
                           const PhotoEvidence& evidence);

}  // namespace vitrine
