// IoU of a convex silhouette and a mask, integrated along pixel rows with subpixel span ends.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/observe/stereo/silhouette.h"

namespace vitrine {

// A convex silhouette: the span [left, right] of each pixel row at its centre height; right < left where the row is empty. No
// rows: the object is entirely behind the camera.
using RowSpans = std::vector<std::array<double, 2>>;
RowSpans no_spans(const View& view);
// Extends the spans by the segment between two image points.
void add_segment(Vec2d a, Vec2d b, RowSpans& spans);

// 1 inside, [h,w] of the view.
std::vector<uint8_t> pixels_of(const RowSpans& spans, const View& view);

// Prefix sums of a mask along rows: marked pixels, and known pixels, to the left of x.
class MaskRows {
 public:
  explicit MaskRows(const Silhouette& mask);
  const View& view() const { return view_; }
  bool says_nothing() const { return all_ == 0; }
  double agreement(const RowSpans& spans) const;

 private:
  size_t stride() const { return size_t(width_) + 1; }
  double left_of(const std::vector<float>& sums, int y, double x) const;

  View view_;
  int width_, height_;
  std::vector<float> mask_, known_;
  double all_ = 0;
};

// Mean over the best three quarters of the photos: the object may be occluded in the others.
double mean_of_better(std::vector<double> agreements);

}  // namespace vitrine
