// Separates the photos of a folder from masks, depth maps and other companions. A picture is left out only if its name and its
// content agree.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/intake/photos/photo_files.h"

namespace vitrine {

// Moves masks, depth maps, normal maps and reduced copies from `folder.photos` to `folder.beside`, and records in
// `folder.like_photos` the files that have such a name but look like photos. Decodes only pictures with such a name.
void sort_pictures(PhotoFolder& folder);

// Second sets of the same photos in other folders: reduced copies, cut-outs, other versions (undistorted, or their originals).
void leave_out_second_sets(PhotoFolder& folder);

// Removes the photos with `out` set.
void drop_photos(std::vector<PhotoFile>& photos, const std::vector<uint8_t>& out);

// A few elements, to test a property of all.
template <class T>
std::vector<T> spread_samples(const std::vector<T>& all) {
  constexpr size_t kSamples = 5;
  std::vector<T> samples;
  const size_t n = std::min(kSamples, all.size());
  for (size_t k = 0; k < n; ++k) samples.push_back(all[k * all.size() / n]);
  return samples;
}

}  // namespace vitrine
