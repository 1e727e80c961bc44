// Common interface of the sources of masks: files, boxes, networks and proposals.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

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
  std::vector<std::string> without_camera = {};  // photos without a pose
  bool camera_flash = false;                     // the light moves with the camera (PhotoLenses)
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

}  // namespace vitrine
