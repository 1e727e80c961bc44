// Edge of the picture of a fisheye lens: a circle with black around it where the lens shows less than the sensor holds.
#pragma once

#include <span>
#include <vector>

#include "core/foundation/math/vec.h"
#include "core/scene/image/image.h"

namespace vitrine {

// Collects photos of one camera. The circle is found if the corners of all photos are black, what is black ends at one radius all
// around, and the pictures reach near to it: night photos and dark vignettes have no such edge.
class LensCircle {
 public:
  // `centre`: of the circle, in pixels of photos of `width` x `height`.
  LensCircle(int width, int height, const Vec2d& centre);
  void add(const Image8& photo);  // sRGB, 3 channels, of any size with the shape of the photos
  // Radius in pixels of the photos, inside the soft edge; 0 = no circle.
  double radius() const;

 private:
  int width_, height_;
  Vec2d centre_;
  size_t photos_ = 0;
  std::vector<float> brightest_;  // [sector][ring], 0 to 255
};

// Of one photo, sRGB-coded, 0 to 1, three channels, with the lens in its middle.
bool shows_lens_circle(const ImageF& photo);

}  // namespace vitrine
