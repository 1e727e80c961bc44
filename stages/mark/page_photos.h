// The photos that the page shows: upright as ingest sees them, reduced, as JPEG, with the size that marks count pixels of.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/photo/photo_files.h"

namespace vitrine {

struct PagePhoto {
  std::string name;                   // as marks and all stages call it
  std::string failure = {};           // why it cannot be read; the rest is empty then
  int width = 0, height = 0;          // upright, as photographed
  std::string digest = {};            // of the file
  std::string jpeg = {}, small = {};  // the picture; a small one for the list
};

// The longest side of the pictures, so that all of them together have at most so many pixels: `side`, or less where there are
// many photos, but not less than kLeastSide.
int side_of_page(const std::vector<std::pair<int, int>>& sizes, int side, double megapixels);
inline constexpr int kLeastSide = 640;

// In the order of the folder. `progress` is called with the number of photos done.
std::vector<PagePhoto> page_photos(const PhotoFolder& folder, int side, double megapixels,
                                   const std::function<void(size_t)>& progress);

}  // namespace vitrine
