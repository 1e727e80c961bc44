// Whether the bytes of a file are a picture that is read, whole. The one place that decides: photos, masks and maps ask it before
// anything is decoded.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/scene/image/probe.h"

namespace vitrine {

struct PictureFile {
  Probe probe;
  std::string refusal;             // why it is not read, and the way out; empty when it is
  std::vector<std::string> notes;  // one clause for each thing that is left out or assumed: "a TIFF whose first page ..."
  std::string aside;               // what the file holds beside the picture, as cameras intend: "a JPEG with a film behind ..."
};

// `extension` (with its dot) is for the sentence.
PictureFile examine_picture(std::string_view bytes, std::string_view extension);

}  // namespace vitrine
