// Common interface of the sources of masks: files, boxes, networks and proposals.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/observe/stereo/edge_field.h"
#include "core/scene/camera/mask_class.h"
#include "core/scene/camera/undistort.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/image.h"

namespace vitrine {

// The photos to be masked.
struct MaskCapture {
  std::filesystem::path sfm_folder;
  ViewSet set;
  std::vector<Undistortion> undistortions;       // [view] from the original photo to the undistorted one
  std::vector<std::string> photos = {};          // [view] the photo that it is cut from, else itself; empty: none is cut
  std::vector<std::string> without_camera = {};  // photos without a pose
  bool camera_flash = false;                     // the light moves with the camera (PhotoLenses)
  bool cut_out = false;                          // the photos may have no background (PhotoLenses)
};
// An sfm artifact without its report counts as free of distortion.
MaskCapture read_mask_capture(const std::filesystem::path& sfm_folder);

// One channel each, of any size, with the field of view of the undistorted photo; 1 = belongs to the class, 1 = certain.
struct SoftMask {
  ImageF value, confidence;
};

class MaskSource {
 public:
  virtual ~MaskSource() = default;
  virtual std::string_view name() const = 0;  // "files", ...
  // nullopt: no mask for that photo.
  virtual std::optional<SoftMask> at(size_t view) const = 0;
  virtual std::string_view trust() const { return "given"; }  // a word of ObjectTrust (core/scene/objects)
  virtual bool propagated() const { return false; }           // from few marks or none: edges may be off by pixels
  virtual void report(nlohmann::ordered_json& j) const = 0;   // entries of this class in masks/report.json
};

// Reduced photos for mask computation: enough resolution for view dependence (proposed) and for outlines (boxes).

inline constexpr int kSmallSide = 320;  // longest side in pixels

struct SmallPhoto {
  View view;                // intrinsics at this size; gain 1 (the photo's gain is divided out)
  std::vector<float> srgb;  // [3,h,w] display-referred, in [0,1], with equal exposure in all photos
};
// `max_side` limits the longest side.
std::vector<View> small_views(const MaskCapture& capture, int max_side);
std::vector<SmallPhoto> small_photos(const MaskCapture& capture, int max_side);
EdgePhoto edge_photo(const SmallPhoto& photo);
std::vector<EdgePhoto> edge_photos(std::span<const SmallPhoto> photos);
// For edge detection: a subset of a large capture, evenly spread; some dozens of photos are enough to locate an edge.
std::vector<EdgePhoto> edge_photos(const MaskCapture& capture, int max_side);

// Gaussian, in place, of planar [channels, h, w]; clipped at the border.
void blur_planes(std::vector<float>& planes, int width, int height, float sigma);

}  // namespace vitrine
