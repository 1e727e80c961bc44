// Captures of an object that is turned over between passes of photos, as museums photograph: it lies on a white plate beside a
// colour chart, is photographed all around, turned over, and photographed all around again. Plate, light and (as a rule) chart
// stay. The object is asymmetric and textured on all sides. Albedo with a little shading and one hard shadow, no light transport:
// a third of a second a photo. Photos are taken once and can be written to files several times, with other exposures.
// Truth: cameras in the frame of the object.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/foundation/base/file.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"

namespace vitrine::test {

enum class Lying { AsItIs, TurnedOver, OnItsSide };
enum class PassCameras {
  Around,  // a ring between 22 and 42 degrees above the plate: the top and all flanks
  Above,   // a ring near the vertical: the top alone
};

struct PassDesc {
  Lying lying = Lying::AsItIs;
  size_t photos = 16;
  PassCameras cameras = PassCameras::Around;
  size_t chart_place = 0;  // 0 to 2: where the chart lies, and how the ring of marks is turned
  bool marks = true;       // a ring of printed marks around the object
  float plate = 0.95f;     // linear albedo: in shots that are brighter by a third of a stop the plate is clipped
};

struct TakenPhoto {
  ImageF linear;
  Image8 object;  // mask, 255 = object
  Rigid cam_from_object;
};
using TakenPhotos = std::vector<TakenPhoto>;

TakenPhotos photos_of_pass(const PassDesc& desc);
// The same object turns once before a camera that stands still; floor and walls are textured.
TakenPhotos photos_on_turntable(size_t count);

struct DevelopDesc {
  bool exposure_varies = false;  // from photo to photo, by thirds of a stop up to two thirds
  double blue_gain = 1;          // white balance of the second pass
};

struct CapturedPhoto {
  std::string name;
  size_t pass = 0;
  Rigid cam_from_object;
  Vec3d gain{1, 1, 1};  // exposure and white balance
};

struct ObjectCapture {
  fs::path photos, masks;  // folders: photos/photo_000.jpg, masks/object/photo_000.png
  Intrinsics intrinsics;
  std::vector<CapturedPhoto> truth;  // in name order, pass after pass

  std::vector<View> views() const;                       // in the frame of the object
  std::vector<std::vector<std::string>> passes() const;  // names of the photos, most photos first
};

ObjectCapture write_capture(const fs::path& folder, std::span<const TakenPhotos* const> passes, const DevelopDesc& desc = {});

}  // namespace vitrine::test
