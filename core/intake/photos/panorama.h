// Recognises photos that show all directions: equirectangular panoramas (core/scene/camera/equirect.h).
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "core/scene/image/image.h"

namespace vitrine {

// Fields of XMP's GPano name space (Google, "Photo Sphere XMP Metadata"). 0 = missing.
struct GPano {
  std::string projection;  // "equirectangular", "cylindrical", ...; empty: none
  int full_width = 0, full_height = 0, cropped_width = 0, cropped_height = 0;
};
// `bytes`: of a photo file of any format, or of its XMP packet. Compressed packets are not found.
GPano parse_gpano(std::string_view bytes);

// Partial: a panorama of a part of the sphere. Stereo: two panoramas, one above the other.
enum class PanoramaKind { None, Sphere, Partial, Stereo };

struct Panorama {
  PanoramaKind kind = PanoramaKind::None;
  std::string evidence;  // "XMP GPano:ProjectionType", or "its left and right edges continue each other, ..."
  // "a 360-degree panorama (...): it is cut into ten views"; empty for None
  std::string sentence() const;
};

// `width`, `height`: of the upright photo. `preview` is only called if these allow a panorama and XMP does not decide: the
// upright photo, sRGB-coded, 0 to 1, of any size. Without XMP a photo is a panorama if its size is 2:1, what its left and right
// edges show continues, and at least one pole is stretched along its row; plain edges and plain poles are no evidence,
// and a circle on black is a fisheye photo.
Panorama panorama_of(const GPano& xmp, int width, int height, const std::function<ImageF()>& preview);

}  // namespace vitrine
