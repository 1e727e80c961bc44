// Validation of image files: supported type and complete data. Photos, masks and maps all use it before decoding.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/scene/image/probe.h"

namespace vitrine {

struct PictureFile {
  Probe probe;
  std::string refusal;             // reason why it is not supported, with a workaround; empty if it is
  std::vector<std::string> notes;  // one clause per omission or assumption: "a TIFF whose first page ..."
  std::string aside;               // additional content intended by the camera: "a JPEG with a film behind ..."
};

// `extension` (with its dot) is used in the message.
PictureFile examine_picture(std::string_view bytes, std::string_view extension);

}  // namespace vitrine
