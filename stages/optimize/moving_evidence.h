// Per-pixel evidence whether the surroundings are static relative to the object or move (turntable, plain backdrop).
//   static   dense stereo explains the pixel: other photos confirm a surface there
//   moving   the pixel has texture, two neighbouring photos see its position, and no surface explains it; or it looks the same at
//            the same image position in photos from other directions: a room in front of a camera on a tripod
// Textureless pixels give no individual evidence. A plain backdrop is detected as a whole: most of the picture is constant at the
// same image position.
#pragma once

#include "core/learn/trainer/targets.h"
#include "stages/optimize/dense_depth.h"

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

}  // namespace vitrine
