// Normals by multi-view stereo: depths where there is texture, and planes fitted to them. Inside the labels of glass and mirrors,
// where stereo fails, the normals of the objects' shapes.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/image.h"
#include "core/scene/objects/object_labels.h"
#include "stages/normals/normal_map.h"

namespace vitrine {

// Input of all sources of normals: cameras, sparse points, photos, and objects if available.
struct NormalCapture {
  std::filesystem::path sfm;
  LabelledObjects objects;  // without guessed objects
  ViewSet set;
  std::vector<uint32_t> helpers;   // photos usable as matching partners (not held out)
  std::vector<ImageF> depth = {};  // [view] z-depth of the user's maps (given_depth.h); empty: none

  // The photo, display-referred, at the requested size. [h,w,3]
  ImageF photo(size_t view, int width, int height) const;
};

NormalCapture load_normal_capture(const std::filesystem::path& sfm, const std::optional<std::filesystem::path>& objects,
                                  int holdout_every);

struct GeometricDesc {
  const NormalCapture& capture;
  int max_side;                     // matching resolution, pixels
  std::span<const uint32_t> views;  // requested photos
  bool with_objects = true;
};

// One map per requested photo, at most desc.max_side large; empty for a photo without a matching partner: `alone` counts them.
std::vector<NormalMap> geometric_normals(const GeometricDesc& desc, const std::function<void(double)>& progress,
                                         size_t* alone = nullptr);

// Normals from an incomplete depth map: fits a plane to the reliable depths around every pixel. In a pinhole camera the inverse
// depth of a plane is linear in the pixel, 1/z = a x + b y + c, and its normal is (fx a, fy b, c + a cx + b cy) up to length and
// sign, so the fit is weighted linear least squares.

struct DepthSamples {
  int width = 0, height = 0;
  std::vector<float> inverse_z;  // [h*w]
  std::vector<float> weight;     // [h*w]; 0 = unknown
};

// `luma` [h,w,1] guides the fit: depths across an edge of the photo have a lower weight. The confidence falls with the standard
// deviation of the normal under depth noise: it is low where depths are few or one-sided.
NormalMap fitted_normals(const DepthSamples& depth, const ImageF& luma, const Intrinsics& k);

}  // namespace vitrine
