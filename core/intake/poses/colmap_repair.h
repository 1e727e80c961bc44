// COLMAP models that people thinned out by hand or put together with scripts: COLMAP reads them, and so does this.
#pragma once

#include <string>

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

// References that lead nowhere, and were dropped.
struct ColmapRepairs {
  size_t images_without_camera = 0;  // dropped as a whole
  size_t points_gone = 0;            // 2D points of a 3D point that is not there
  size_t images_gone = 0;            // places in tracks: of an image that is not there,
  size_t indices_gone = 0;           // of a 2D point beyond the image's last,
  size_t disagreeing = 0;            // of a 2D point that belongs to another 3D point or to none, and the other way round

  size_t count() const { return images_without_camera + points_gone + images_gone + indices_gone + disagreeing; }
  std::string text() const;  // "130 2D points name a 3D point that is not there, 7 ..."
};

// Afterwards every reference exists and both sides agree. `model` is sorted by ids.
ColmapRepairs drop_dangling_references(ColmapModel& model);

}  // namespace vitrine
