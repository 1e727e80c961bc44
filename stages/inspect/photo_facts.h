// What is known of every photo of a folder: EXIF and measures of a small decoding.
#pragma once

#include <functional>

#include "core/photo/measures.h"
#include "core/photo/photo_files.h"

namespace vitrine {

struct PhotoFacts {
  std::string name;                // below the folder
  std::string failure;             // why it cannot be used; the rest is empty then
  int width = 0, height = 0;       // upright, as photographed
  std::optional<double> focal_px;  // at that size
  std::optional<double> exposure_ev;
  std::string camera, time, digest;
  ColorFacts color;
  PhotoMeasures measures;
  std::vector<std::string> notes;  // what would be left out or assumed (core/photo/photo_files.h)

  bool usable() const { return failure.empty(); }
  double longest() const { return std::max(width, height); }
  // Blur in pixels of a photo of kBlurSide pixels, so that photos of different sizes compare.
  std::optional<double> blur() const;
};
inline constexpr double kBlurSide = 1600;

// In the order of the folder. `progress` is called with the number of photos done.
std::vector<PhotoFacts> photo_facts(const PhotoFolder& folder, const std::function<void(size_t)>& progress);

}  // namespace vitrine
