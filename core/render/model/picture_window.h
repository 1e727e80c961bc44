// Rectangular pixel window of a picture.
#pragma once

#include <algorithm>
#include <cstddef>

#include "core/scene/camera/view.h"

namespace vitrine {

struct PictureWindow {
  int left = 0, top = 0, right = 0, bottom = 0;  // pixels of the picture; left and top inclusive, right and bottom exclusive

  bool empty() const { return left >= right || top >= bottom; }
  int width() const { return right - left; }
  int height() const { return bottom - top; }
  size_t pixel_count() const { return static_cast<size_t>(width()) * static_cast<size_t>(height()); }
  void extend(int x, int y) {
    if (empty()) {
      *this = {x, y, x + 1, y + 1};
      return;
    }
    extend({x, y, x + 1, y + 1});
  }
  // Requires both non-empty.
  bool meets(const PictureWindow& o) const { return left < o.right && o.left < right && top < o.bottom && o.top < bottom; }
  void extend(const PictureWindow& o) {
    left = std::min(left, o.left), right = std::max(right, o.right);
    top = std::min(top, o.top), bottom = std::max(bottom, o.bottom);
  }
  // Index in the window of pixel (x, y) of the picture.
  size_t index(int x, int y) const {
    return static_cast<size_t>(y - top) * static_cast<size_t>(width()) + static_cast<size_t>(x - left);
  }
  // Camera cropped to the window.
  View view(View whole) const {
    Intrinsics& k = whole.intrinsics;
    k.width = width(), k.height = height();
    k.cx -= left, k.cy -= top;
    return whole;
  }
};

}  // namespace vitrine
