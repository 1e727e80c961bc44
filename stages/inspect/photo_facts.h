// EXIF data of every photo of a folder, and measures of a reduced decoding.
#pragma once

#include <functional>

#include "core/intake/photos/measures.h"
#include "core/intake/photos/photo_files.h"

namespace vitrine {

struct PhotoFacts {
  std::string name;                // relative to the folder
  std::string failure;             // reason why it cannot be used; all other members are empty then
  int width = 0, height = 0;       // upright, as photographed
  std::optional<double> focal_px;  // at this size
  std::optional<double> zoom;      // FocalLength in millimetres times digital zoom
  std::optional<double> exposure_ev;
  std::optional<GpsPosition> gps;
  std::string camera, time, digest;
  ColorFacts color;
  PhotoMeasures measures;
  std::vector<std::string> notes;  // content that would be ignored or assumed (core/intake/photos/photo_files.h)

  bool panorama = false;  // of the whole sphere: ingest cuts it into views

  bool usable() const { return failure.empty(); }
  double longest() const { return std::max(width, height); }
  // Blur in pixels at a size of kBlurSide pixels, comparable between photos of different sizes.
  std::optional<double> blur() const;
};
inline constexpr double kBlurSide = 1600;

// In the order of the folder. `progress` receives the number of photos done.
std::vector<PhotoFacts> photo_facts(const PhotoFolder& folder, const std::function<void(size_t)>& progress);

}  // namespace vitrine
