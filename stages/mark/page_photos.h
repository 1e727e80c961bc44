// Photos for the page: upright as ingest reads them, reduced, JPEG, with the full size that mark coordinates refer to.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/intake/photos/photo_files.h"

namespace vitrine {

struct PagePhoto {
  std::string name;                   // name in marks and in all stages
  std::string failure = {};           // reason why it cannot be read; all other members are empty then
  int width = 0, height = 0;          // upright, as photographed
  std::string digest = {};            // of the file
  std::string jpeg = {}, small = {};  // the picture; a thumbnail for the list
};

// Longest side of the pictures: `side`, reduced so that all pictures together have at most `megapixels`, but at least kLeastSide.
int side_of_page(const std::vector<std::pair<int, int>>& sizes, int side, double megapixels);
inline constexpr int kLeastSide = 640;

// In the order of the folder. `progress` receives the number of photos done.
std::vector<PagePhoto> page_photos(const PhotoFolder& folder, int side, double megapixels,
                                   const std::function<void(size_t)>& progress);

}  // namespace vitrine
