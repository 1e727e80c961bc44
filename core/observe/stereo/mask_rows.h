// How well a convex silhouette agrees with a mask: intersection over union, row by row of pixels, so that parts of a pixel count.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/observe/stereo/silhouette.h"

namespace vitrine {

// A convex silhouette: the span [left, right] of every row of pixels, at the height of their centres; right < left where it has
// none. No rows: nothing of it is in front of the camera.
using RowSpans = std::vector<std::array<double, 2>>;
RowSpans no_spans(const View& view);
// Widens the spans by the segment between two points of the picture.
void add_segment(Vec2d a, Vec2d b, RowSpans& spans);

// 1 inside, [h,w] of the view.
std::vector<uint8_t> pixels_of(const RowSpans& spans, const View& view);

// A mask by rows: how much of it, and how much that is known at all, lies left of x.
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

// Mean over the better three quarters of the photos: an object may stand in front in the others.
double mean_of_better(std::vector<double> agreements);

}  // namespace vitrine
