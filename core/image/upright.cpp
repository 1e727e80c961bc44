#include "core/image/upright.h"

#include <algorithm>

namespace vitrine {

ImageF upright(const ImageF& stored, int orientation) {
  if (orientation <= 1 || orientation > 8) return stored;
  const int w = stored.width(), h = stored.height(), channels = stored.channels();
  const bool turned = orientation >= 5;
  ImageF out(turned ? h : w, turned ? w : h, channels);
  // Where row 0 and column 0 of the stored image belong (EXIF 2.32, tag 0x0112):
  //   1 top left  2 top right  3 bottom right  4 bottom left  5 left top  6 right top  7 right bottom  8 left bottom
  const bool mirror_x = orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7;
  const bool mirror_y = orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8;
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const int across = turned ? y : x, down = turned ? x : y;
      const int to_x = mirror_x ? out.width() - 1 - across : across, to_y = mirror_y ? out.height() - 1 - down : down;
      std::copy_n(stored.pixel(x, y), channels, out.pixel(to_x, to_y));
    }
  }
  return out;
}

}  // namespace vitrine
