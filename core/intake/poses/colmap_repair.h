// Drops dangling references from COLMAP models that were thinned by hand or assembled by scripts. COLMAP reads such models too.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

// Number of references that were dropped, by kind.
struct ColmapRepairs {
  size_t images_without_camera = 0;  // whole images
  size_t points_gone = 0;            // 2D points whose 3D point is missing
  size_t images_gone = 0;            // track entries whose image is missing,
  size_t indices_gone = 0;           // whose 2D point index is out of range,
  size_t disagreeing = 0;            // whose 2D point belongs to another 3D point or to none, and the reverse

  size_t count() const { return images_without_camera + points_gone + images_gone + indices_gone + disagreeing; }
  std::string text() const;  // "130 2D points name a 3D point that is not there, 7 ..."
};

// After the call every reference is valid in both directions. `model` is sorted by ids.
ColmapRepairs drop_dangling_references(ColmapModel& model);

// Removes points or images from a COLMAP model and renumbers the rest.

// Keeps the points for which `keep` holds. Removes 2D points without a 3D point, renumbers ids to 1..n and updates the tracks.
// Observations whose 2D point has lost its 3D point are removed from the tracks first.
ColmapModel compacted(ColmapModel model, const std::function<bool(const ColmapPoint3D&)>& keep);

// Removes these images (ids), points seen by fewer than two of the rest, and unused cameras.
ColmapModel without_images(ColmapModel model, const std::set<uint32_t>& images);

}  // namespace vitrine
